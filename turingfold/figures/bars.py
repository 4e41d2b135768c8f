"""Which parameters matter: sorted bars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MORE, LESS = "#d55e00", "#0072b2"


def tornado(axes: Axes, parameters: Sequence[str], per_cent: Array, *, most: int = 12) -> None:
    """Draw by how many per cent a measure changes with one per cent of each parameter, the largest on top.

    per_cent: of the parameters, (p,). At most `most` of them are shown.
    """
    order = [k for k in np.argsort(-np.abs(per_cent)) if np.isfinite(per_cent[k])][:most]
    values = np.asarray(per_cent)[order]
    rows = np.arange(len(order))
    bars = axes.barh(rows, values, color=np.where(values > 0, MORE, LESS), height=0.7)
    axes.bar_label(bars, [f"{value:+.2g}" for value in values], padding=3, fontsize=8)
    axes.set_yticks(rows, [parameters[k] for k in order], fontsize=8)
    axes.invert_yaxis()
    axes.axvline(0.0, color="#333333", linewidth=0.8)
    widest = float(np.abs(values).max(initial=0.0)) or 1.0
    low, high = values.min(initial=0.0), values.max(initial=0.0)
    # room for the numbers at the ends of bars
    axes.set_xlim(low - (0.5 * widest if low < 0 else 0.0), high + (0.5 * widest if high > 0 else 0.0) or 1)
    axes.set_xlabel("% for 1 % more of the parameter", fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
