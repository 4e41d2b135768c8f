"""How far points lie from a curve, along its normal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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
    starts, ends: numbers of the corners of the side.  shares: of the way between them, in [0, 1], or beyond
    an open end.
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


@dataclass(frozen=True, eq=False)
class Polygon:
    """A polygon with corners (2, m), whose sides are found by place."""

    corners: Array
    closed: bool

    @cached_property
    def _ahead(self) -> Integers:
        """The number of the corner at which each side ends."""
        last = self.corners.shape[1]
        return np.roll(np.arange(last), -1)[: last if self.closed else last - 1]

    @cached_property
    def _sides(self) -> shapely.STRtree:
        start, end = self.corners[:, : len(self._ahead)], self.corners[:, self._ahead]
        return shapely.STRtree(shapely.linestrings(np.stack([start.T, end.T], axis=1)))

    def feet(self, points: Array) -> Feet:
        """Return where points (2, n) are nearest to it.

        Beyond the ends of an open one, distance and normal are those from the line along its last side.
        """
        nearest = np.asarray(self._sides.nearest(shapely.points(points.T)), dtype=np.int64)
        ends = self._ahead[nearest]
        start, way = self.corners[:, nearest], self.corners[:, ends] - self.corners[:, nearest]
        length2 = np.maximum((way**2).sum(0), np.finfo(float).tiny)
        gap, normal = points - start, np.stack([-way[1], way[0]]) / np.sqrt(length2)
        along = (gap * way).sum(0) / length2
        share = np.clip(along, 0.0, 1.0)
        off = gap - share * way
        if not self.closed:
            beyond = ((nearest == 0) & (along < 0)) | ((nearest == len(self._ahead) - 1) & (along > 1))
            off = np.where(beyond, (gap * normal).sum(0) * normal, off)
            share = np.where(beyond, along, share)
        size = np.hypot(*off)
        side = np.where((off * normal).sum(0) < 0, -1.0, 1.0)
        unit = np.where(size > 1e-12 * np.sqrt(length2), side * off / np.maximum(size, 1e-300), normal)
        return Feet(side * size, unit, nearest, ends, share)

    def distances(self, points: Array) -> tuple[Array, Array]:
        """Return the distances of points (2, n) from it, positive on its left, and their gradients (2, n)."""
        found = self.feet(points)
        return found.distances, found.normals
