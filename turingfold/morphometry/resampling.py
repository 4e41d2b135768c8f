"""Points at given places along a curve, on the cubic spline through its points."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import whole
from .polyline import FEWEST_POINTS, Polyline, as_polyline


def resample(points: Any, count: int, *, closed: bool | None = None) -> Array:
    """Return `count` points (2, count) at equal steps of arc length on the cubic spline through the points.

    An outline starts at its first point and does not repeat it; an open curve keeps both ends.
    """
    curve = as_polyline(points, closed)
    return spline_points(curve, fractions(whole("count", count, at_least=FEWEST_POINTS), curve.closed))


def fractions(count: int, closed: bool) -> Array:
    """Return equally spaced fractions (count,) of the arc length; 1 is included only for an open curve."""
    return np.linspace(0.0, 1.0, count, endpoint=not closed)


def spline_points(curve: Polyline, where: Array) -> Array:
    """Return points (2, n) at fractions `where` of the arc length of the cubic spline through the curve."""
    from scipy.interpolate import CubicSpline

    nodes, at = curve.points, curve.arc
    if curve.closed:
        nodes, at = np.hstack((nodes, nodes[:, :1])), np.append(at, curve.length)
    spline = CubicSpline(at, nodes, axis=1, bc_type="periodic" if curve.closed else "not-a-knot")
    # Chords undercount the arc, more so where points are sparse: measure it on a refined copy.
    fine = np.interp(np.arange(8 * (at.size - 1) + 1) / 8, np.arange(at.size), at)
    travelled = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(spline(fine), axis=1)))))
    return np.asarray(spline(np.interp(where * travelled[-1], travelled, fine)), dtype=float)
