"""Polygons: their area, which points they enclose, where segments meet."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Booleans, Integers

PAIRS = 2_000_000  # compared at once: some tens of MB


def area(curve: Array) -> float:
    """Return the signed area inside a closed polygon (2, n); positive if counter-clockwise."""
    x, y = curve
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def inside(points: Array, loop: Array) -> Booleans:
    """Return whether each point (2, n) lies inside the closed polygon (2, m)."""
    return enclosed(points, np.stack([loop, np.roll(loop, -1, axis=1)]))


def enclosed(points: Array, segments: Array) -> Booleans:
    """Return whether each point (2, n) lies inside the closed curves that segments make, in any order.

    segments: start and end points, (2, 2, m). A ray from a point inside crosses an odd number of them.
    """
    (ax, ay), (bx, by) = segments
    found = np.zeros(points.shape[1], dtype=bool)
    for begin in range(0, len(found), block := _block(segments)):
        x, y = points[:, begin : begin + block]
        i, j = np.nonzero((ay > y[:, None]) != (by > y[:, None]))
        left = x[i] < ax[j] + (y[i] - ay[j]) / (by[j] - ay[j]) * (bx[j] - ax[j])
        found[begin : begin + block] = np.bincount(i[left], minlength=len(x)) % 2 == 1
    return found


def intersections(one: Array, other: Array) -> tuple[Integers, Integers, Array, Array]:
    """Return which segments of `one` meet which of `other`, and where along each (0 to 1).

    one, other: start and end points, shapes (2, 2, n) and (2, 2, m). Parallel segments never meet.
    """
    found: list[tuple[Integers, Integers, Array, Array]] = []
    block = _block(other)
    d = other[1] - other[0]
    for begin in range(0, one.shape[2], block):
        start = one[0, :, begin : begin + block, None]
        along = one[1, :, begin : begin + block, None] - start
        gap = other[0][:, None] - start
        cross = along[0] * d[1] - along[1] * d[0]
        safe = np.where(cross == 0, np.inf, cross)
        s = (gap[0] * d[1] - gap[1] * d[0]) / safe
        t = (gap[0] * along[1] - gap[1] * along[0]) / safe
        i, j = np.nonzero((cross != 0) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1))
        found.append((i + begin, j, s[i, j], t[i, j]))
    i, j, s, t = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return i, j, s, t


def _block(segments: Array) -> int:
    """Return how many points or segments to compare with all these segments at once, to bound the memory."""
    return max(1, PAIRS // max(1, len(segments[0, 0])))
