"""The deformed body as the window and its saved pictures show it."""

from __future__ import annotations

from textwrap import shorten
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ..arrays import Array
from ..figures.grids import GRAY
from ..figures.sections import outline, peaks, scale_bar, section
from ..figures.style import INK, MM, copies, core, edge, frame, shaded
from ..geometry.body import Body
from ..results.result import Result, pial_closed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SKY = "#56b4e9"  # of Okabe and Ito's colours
TISSUE, STRESS = "tissue and pattern", "von Mises stress"
VIEWS = (TISSUE, STRESS)
Box: TypeAlias = tuple[Array, Array]  # lower left and upper right corner; mm
Before: TypeAlias = tuple[Array, str]  # pial surface, (2, n), and what was changed


def picture(axes: Axes, result: Result, view: str, *, before: Before | None = None, box: Box) -> None:
    """Draw the last state of a result in a frame, with the undeformed outline.

    view: one of VIEWS.  before: another run to compare it with.
    """
    body = result.scene.body
    if view == STRESS:
        section(axes, result)
        peaks(axes, result)
    else:
        _tissue(axes, result)
    if result.history:
        outline(axes, body)
    if before is not None:
        line, label = before
        if pial_closed(body):
            line = np.concatenate([line, line[:, :1]], axis=1)
        axes.plot(*(MM * line), color=SKY, linewidth=1.5, label=f"run before: {shorten(label, 40)}")
    (left, low), (right, high) = box
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            loc="upper left", bbox_to_anchor=(0, 0), ncols=3, frameon=False, fontsize=9, labelcolor=INK
        )


def extent(result: Result, box: Box | None = None) -> Box:
    """Return a frame that holds the last state, and another frame; mm."""
    body = result.scene.body
    if box is None:  # room to grow
        low, high = _corners(body, body.nodes, 0.07)
    else:
        low, high = box
    now_low, now_high = _corners(body, body.nodes + result.last["displacement"], 0.04)
    return np.minimum(low, now_low), np.maximum(high, now_high)


def _corners(body: Body, points: Array, margin: float) -> Box:
    places = np.concatenate([MM * copy for copy in copies(body, points)], axis=1)
    low, high = places.min(axis=1), places.max(axis=1)
    wide = float((high - low).max())
    return low - [margin * wide, 0.1 * wide], high + margin * wide  # below, there is the scale bar


def _tissue(axes: Axes, result: Result) -> None:
    """Shade the cortex by the activator from 0 to 1, or in one colour where there is none."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    body, state = result.scene.body, result.last
    patterned = "pattern" in state
    colors = ScalarMappable(Normalize(0, 1), "viridis" if patterned else ListedColormap([GRAY]))
    values = np.ones(body.nodes.shape[1])
    if patterned:
        values = body.spread(body.cortex, state["pattern"], outside=0.0)
    for points in copies(body, body.nodes + state["displacement"]):
        core(axes, points, body)
        shaded(axes, points, body, body.in_cortex, values, colors)
        edge(axes, points, body)
    frame(axes)
    scale_bar(axes, body)
    if patterned:
        axes.figure.colorbar(colors, ax=axes, label="activator û", shrink=0.7, pad=0.02, ticks=[0, 0.5, 1])
