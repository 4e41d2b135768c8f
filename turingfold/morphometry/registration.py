"""Fold-morphogen registration: do the gyri stand on the peaks of a pattern?"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import finite_array, whole
from .polyline import Polyline, as_polyline, signed_distance

UNMOVED = 1e-9  # fold height over the radius of the body below which there are no folds


def registration(
    pattern: Any, points: Any, reference: Any, *, trend: int = 4, closed: bool | None = None
) -> float:
    """Return the correlation in [-1, 1] of a pattern with the fold height: +1 means gyri on its peaks.

    pattern (n,): values at the points, e.g. the activator.  points, reference (2, n): the pial surface
    deformed and undeformed, node by node. Fold height: signed distance to the undeformed curve (on a half
    disc the radial position), weighted with undeformed length. From both, a trend is first removed: over
    the undeformed arc, polynomials up to degree `trend` (open) or harmonics up to trend/2 (closed);
    trend = 0 leaves the plain correlation. 0 where the height has nothing but trend.
    Raises ValueError for shapes that do not match and for a pattern that is nothing but trend.
    """
    rest = as_polyline(reference, closed, "reference")
    shape = as_polyline(points, rest.closed)
    if shape.size != rest.size:
        raise ValueError(f"points are {shape.size} and reference {rest.size}; they must be the same nodes.")
    values = finite_array("pattern", pattern, (None,))
    if values.size == rest.size + 1 and rest.closed:
        values = values[:-1]  # the outline came with its first point repeated
    if values.size != rest.size:
        raise ValueError(f"pattern has {values.size} values; it must have one per point, {rest.size}.")
    height = _without_trend(signed_distance(shape.points, rest), rest, trend)
    wave = _without_trend(values, rest, trend)
    if np.abs(wave).max() <= UNMOVED * max(1e-300, float(np.abs(values).max())):
        raise ValueError(f"pattern is constant or a trend of degree {trend}; no fold can be on its peaks.")
    if np.abs(height).max() <= UNMOVED * rest.radius:
        return 0.0
    w = rest.weights
    return float(np.sum(w * wave * height) / np.sqrt(np.sum(w * wave**2) * np.sum(w * height**2)))


def _without_trend(values: Array, curve: Polyline, trend: int) -> Array:
    """Return values minus their best slow trend, least squares weighted with length."""
    degree = whole("trend", trend, at_least=0)
    s = curve.arc / curve.length
    if curve.closed:
        k = np.arange(1, degree // 2 + 1)[:, None]
        basis = np.concatenate((np.ones((1, s.size)), np.cos(2 * np.pi * k * s), np.sin(2 * np.pi * k * s))).T
    else:
        basis = np.polynomial.legendre.legvander(2 * s - 1, degree)
    root = np.sqrt(curve.weights)
    fit, *_ = np.linalg.lstsq(root[:, None] * basis, root * values, rcond=None)
    return np.asarray(values - basis @ fit)
