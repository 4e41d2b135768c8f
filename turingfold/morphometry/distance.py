"""How far points lie from a curve, along its normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from ..arrays import Array, Integers

FINE = 16  # straight pieces of a quadratic edge: a chord of one misses a 256th of the edge's own sagitta
XI = 2 * np.arange(FINE) / FINE - 1
SHAPES = np.stack([0.5 * XI * (XI - 1), 1 - XI**2, 0.5 * XI * (XI + 1)])


def sampled(nodes: Array, *, closed: bool) -> Array:
    """Return sixteen points on each quadratic edge of a curve, and its end; nodes: (2, n), in order."""
    path = np.concatenate([nodes, nodes[:, :1]], axis=1) if closed else nodes
    edges = np.stack([path[:, :-2:2], path[:, 1:-1:2], path[:, 2::2]])  # (3, 2, m)
    found = np.einsum("kim,kg->img", edges, SHAPES).reshape(2, -1)
    return np.asarray(found if closed else np.concatenate([found, nodes[:, -1:]], axis=1))


@dataclass(frozen=True, eq=False)
class Feet:
    """Where points are nearest to a polygon, n of them.

    distances: (n,), positive on its left.  normals: their gradients, unit vectors (2, n).
    starts, ends: numbers of the corners of the side.  shares: of the way between them, in [0, 1].
    """

    distances: Array
    normals: Array
    starts: Integers
    ends: Integers
    shares: Array

    def of(self, corners: Array) -> Array:
        """Return what is given at the corners, (..., m), at the feet, (..., n)."""
        start, end = corners[..., self.starts], corners[..., self.ends]
        return np.asarray(start + self.shares * (end - start))


def feet(points: Array, polygon: Array, *, closed: bool) -> Feet:
    """Return where points (2, n) are nearest to a polygon (2, m).

    Beyond the ends of an open one, distance and normal are those from the line along its last side.
    """
    last = polygon.shape[1]
    ahead = np.roll(np.arange(last), -1)[: last if closed else last - 1]
    start, way = polygon[:, : len(ahead)], polygon[:, ahead] - polygon[:, : len(ahead)]
    sides = shapely.STRtree(shapely.linestrings(np.stack([start.T, (start + way).T], axis=1)))
    nearest = np.asarray(sides.nearest(shapely.points(points.T)), dtype=np.int64)
    start, way = start[:, nearest], way[:, nearest]
    length2 = np.maximum((way**2).sum(0), np.finfo(float).tiny)
    gap, normal = points - start, np.stack([-way[1], way[0]]) / np.sqrt(length2)
    along = (gap * way).sum(0) / length2
    share = np.clip(along, 0.0, 1.0)
    off = gap - share * way
    if not closed:
        beyond = ((nearest == 0) & (along < 0)) | ((nearest == last - 2) & (along > 1))
        off = np.where(beyond, (gap * normal).sum(0) * normal, off)
    size = np.hypot(*off)
    side = np.where((off * normal).sum(0) < 0, -1.0, 1.0)
    unit = np.where(size > 1e-12 * np.sqrt(length2), side * off / np.maximum(size, 1e-300), normal)
    return Feet(side * size, unit, nearest, ahead[nearest], share)


def signed_distance(points: Array, polygon: Array, *, closed: bool) -> tuple[Array, Array]:
    """Return the distances of points (2, n) from a polygon, positive on its left, and their gradients."""
    found = feet(points, polygon, closed=closed)
    return found.distances, found.normals
