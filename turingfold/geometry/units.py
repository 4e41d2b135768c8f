"""Units of length of files, and words where numbers look like another unit."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..checks import positive

METRES = {
    "m": 1.0, "meter": 1.0, "metre": 1.0, "cm": 1e-2, "mm": 1e-3, "millimetre": 1e-3, "millimeter": 1e-3,
    "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "micron": 1e-6, "nm": 1e-9,
}  # fmt: skip
UNIT = re.compile(r"(?<![^\W_])(" + "|".join(METRES) + r")s?(?![^\W_])")
LARGE = 10.0  # no brain has so many metres, and a body without units is seldom drawn so large


def metres(unit: str | float) -> float:
    """Return the length in m of a unit: a word such as "mm", or a number of metres.

    Raises ValueError for words that are no unit of length, and for numbers that are not positive.
    """
    if not isinstance(unit, str):
        return positive("unit", unit, remedy='give the length of a unit in m, or a word such as "mm"')
    if unit.strip() not in METRES:
        raise ValueError(f"unit={unit!r} must be one of {', '.join(METRES)}, or a number of metres.")
    return METRES[unit.strip()]


def note_large(source: str, loops: Sequence[Array], remedy: str) -> None:
    """Warn of curves (2, n) of 10 m or more: their numbers are probably millimetres."""
    if not loops:
        return
    points = np.concatenate(list(loops), axis=1)
    width, height = np.ptp(points, axis=1)
    if max(width, height) >= LARGE:
        words = f"{source} is {width:g} by {height:g} large, read as metres; if they are mm, {remedy}."
        warnings.warn(words, stacklevel=3)
