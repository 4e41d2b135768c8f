"""What is to be said of a fit beside its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..arrays import Array

MISSED = 0.05  # thicknesses of the cortex by which outlines are missed that is told, where no noise is given
UNLIKELY = 3.0  # the same, in standard deviations of the noise
AT_BOUND = 1e-3  # share of a bound, or of what is between both, by which a value is at it: scipy stays inside


def remarks(
    to: Sequence[str], values: Array, low: Array, high: Array, misfits: Mapping[float, float],
    thickness: float, noise: float | None,
) -> Iterator[str]:  # fmt: skip
    """Yield sentences: which values are at a bound, and which outlines are missed by much.

    values, low, high: (p,).  misfits: by age, m.  noise: of the targets, m, if it is known.
    """
    for bound, word in ((low, "least"), (high, "largest")):
        near = AT_BOUND * np.where(np.isfinite(high - low), high - low, np.abs(bound))
        held_at = np.isfinite(bound) & (np.abs(values - bound) <= near)
        held = [name for name, at in zip(to, held_at, strict=True) if at]
        if held:
            yield f"{', '.join(held)}: at the {word} value allowed; standard errors are those without it"
    allowed = MISSED * thickness if noise is None else UNLIKELY * noise
    for age, misfit in misfits.items():
        if misfit > allowed:
            what = f"{misfit / thickness:.2g} of the cortical thickness"
            what += "" if noise is None else f", {misfit / noise:.2g} times the noise"
            yield (
                f"the outline at {age:g} is missed by {what}: the scene cannot make it, or folded into "
                "another branch; start from other values"
            )
