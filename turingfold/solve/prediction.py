"""Where the next equilibrium is expected, from those before it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array

REMEMBERED = 4  # equilibria before the present one, so that a prediction is of degree four at most


class Past(NamedTuple):
    """Time and displacement (2, n_nodes) of an equilibrium."""

    time: float
    displacement: Array


def extrapolated(points: Sequence[Past], time: float) -> Array:
    """Return the displacement at a later time on the polynomial through the last of at least two points.

    Its degree is the one that would have foretold the last point best, or one more where none higher could
    be tried: after an instability the past says little, on a smooth path it says nearly all.
    """
    *past, now = points
    misses = [
        float(np.linalg.norm(_at(past[-count:], now.time) - now.displacement))
        for count in range(1, len(past) + 1)
    ]
    degree = int(np.argmin(misses))
    if degree == len(past) - 1:
        degree += 1
    return _at(points[-1 - degree :], time)


def _at(points: Sequence[Past], time: float) -> Array:
    """Return Lagrange's polynomial through all points at a time."""
    total = np.zeros_like(points[0].displacement)
    for i, point in enumerate(points):
        others = [other.time for j, other in enumerate(points) if j != i]
        total += np.prod([(time - t) / (point.time - t) for t in others]) * point.displacement
    return total
