"""What can be wrong with a closed curve given as points: repaired where that is plain, else refused."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import real_array
from ..geometry.polygon import area, intersections

FEWEST = 8
MERGE = 1e-9  # points closer than this share of the extent are one point
GAP = 5.0  # a curve is open if its ends are farther apart than this many times its longest other segment


def closed_outline(points: Any) -> Array:
    """Return the points of a closed curve as (2, n), counter-clockwise, the first one not repeated.

    points: (2, n) or (n, 2), in order along the curve. Repeated points are merged, a clockwise curve is
    turned round, a last point that repeats the first is dropped.
    Raises ValueError for other shapes, values that are not finite, fewer than 8 different points, an open
    curve (its ends farther apart than 5 times the longest other segment), or one that crosses itself.
    """
    curve = _columns(points)
    extent = float(np.ptp(curve, axis=1).max())
    step = np.hypot(*(curve - np.roll(curve, 1, axis=1)))
    curve = curve[:, step > MERGE * extent]
    count = len(np.unique(np.round(curve / (MERGE * extent)), axis=1).T) if extent > 0 else 1
    if count < FEWEST:
        raise ValueError(
            f"points has {count} different points; an outline needs at least {FEWEST}. "
            "Give more points along it."
        )
    length = np.hypot(*np.diff(curve, axis=1))
    ends = curve[:, [0, -1]]
    if np.hypot(*(ends[:, 1] - ends[:, 0])) > GAP * length.max():
        raise ValueError(
            f"points is an open curve: its ends {_shown(ends[:, 0])} and {_shown(ends[:, 1])} are "
            f"{np.hypot(*(ends[:, 1] - ends[:, 0])):.3g} apart, its longest segment is {length.max():.3g}. "
            "Add the points of the missing part, e.g. along the base."
        )
    refuse_crossings(curve, "points")
    return curve if area(curve) > 0 else np.ascontiguousarray(curve[:, ::-1])


def thinned(curve: Array, closed: bool, spacing: float) -> Array:
    """Return the curve without points nearer than `spacing` to the last kept one; open ends stay."""
    kept = [0]
    last = curve.shape[1] - 1
    for k in range(1, last + 1):
        if np.hypot(*(curve[:, k] - curve[:, kept[-1]])) >= spacing:
            kept.append(k)
    if not closed and kept[-1] != last:
        kept = [*(kept[:-1] if len(kept) > 1 else kept), last]
    if closed and len(kept) > 1 and np.hypot(*(curve[:, kept[-1]] - curve[:, 0])) < spacing:
        kept = kept[:-1]
    return curve[:, kept]


def refuse_crossings(curve: Array, name: str) -> None:
    """Raise ValueError where a closed polygon (2, n) crosses or touches itself, saying where."""
    n = curve.shape[1]
    ends = np.stack([curve, np.roll(curve, -1, axis=1)])
    i, j, share, _ = intersections(ends, ends)
    apart = np.minimum((i - j) % n, (j - i) % n) > 1
    if apart.any():
        k = int(np.flatnonzero(apart)[0])
        where = ends[0, :, i[k]] + share[k] * (ends[1, :, i[k]] - ends[0, :, i[k]])
        raise ValueError(
            f"{name} crosses or touches itself {np.sum(apart & (i < j))} times, first near {_shown(where)}, "
            f"between its points {i[k]} and {j[k]}. Remove the loop, or take the outer contour."
        )


def _columns(points: Any) -> Array:
    curve = real_array("points", points)
    if curve.ndim != 2 or 2 not in curve.shape:
        raise ValueError(f"points has shape {curve.shape}; it must be (2, n) or (n, 2).")
    curve = curve if curve.shape[0] == 2 else curve.T
    if not np.isfinite(curve).all():
        k = int(np.flatnonzero(~np.isfinite(curve).all(axis=0))[0])
        raise ValueError(f"point {k} of points is {_shown(curve[:, k])}; every coordinate must be finite.")
    return np.array(curve)


def _shown(point: Array) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g})"
