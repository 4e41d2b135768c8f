"""What is to be said of a fit beside its numbers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import Array
from .inverse import Fit

MISSED = 0.05  # thicknesses of the cortex by which outlines are missed that is told, where no noise is given
UNLIKELY = 3.0  # standard deviations of the sum of squares above what the noise gives, likewise
APART = 2.0  # times the misfit, and MISSED beyond it: a surface with folds that the outline lacks
AT_BOUND = 1e-3  # share of a bound, or of what is between both, by which a value is at it: scipy stays inside


def remarks(found: Fit, low: Array, high: Array, noise: float | None) -> Iterator[str]:
    """Yield sentences: which values are at a bound, and which outlines are missed by much.

    low, high: bounds, (p,).  noise: of the targets, m, if it is known.
    """
    thickness = found.scene.body.thickness
    for bound, word in ((low, "least"), (high, "largest")):
        near = AT_BOUND * np.where(np.isfinite(high - low), high - low, np.abs(bound))
        held_at = np.isfinite(bound) & (np.abs(found.values - bound) <= near)
        held = [name for name, at in zip(found.parameters, held_at, strict=True) if at]
        if held:
            yield f"{', '.join(held)}: at the {word} value allowed; standard errors are those without it"
    smooth = ", or the map is too smooth" if found.smoothness > 0 else ""
    for age, misfit in found.misfits.items():
        allowed = MISSED * thickness
        if noise is not None:
            count = found.targets[age].shape[1]
            allowed = noise * np.sqrt(1 + UNLIKELY * np.sqrt(2 / count))
        if misfit > allowed:
            what = f"{misfit / thickness:.2g} of the cortical thickness"
            what += "" if noise is None else f", {misfit / noise:.2g} times the noise"
            yield (
                f"the outline at {age:g} is missed by {what}: the scene cannot make it, or folded into "
                f"another branch{smooth}; start from other values"
            )
        if found.strays[age] > APART * misfit + MISSED * thickness:
            yield (
                f"at {age:g} the surface is {found.strays[age] / thickness:.2g} thicknesses of the cortex "
                "off the outline, which lies nearer to it: it has folds that the outline lacks"
            )
