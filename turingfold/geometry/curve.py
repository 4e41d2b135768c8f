"""A piecewise quadratic curve: its nodes in order, arc length, and the nearest point to any other point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array, Integers

NEAREST = 4  # samples whose segments are tried as the nearest one
LEAF = 64  # samples in a leaf of the tree: points deep inside are near to many (16: 1.6 times the time)


@dataclass(frozen=True, eq=False)
class Curve:
    """Quadratic segments through `points` (2, n): vertex, mid, vertex, ... in order.

    Open curves have an odd n; a closed one has an even n and returns to its first point.
    """

    points: Array
    closed: bool = False

    @cached_property
    def segments(self) -> Array:
        """Start, mid and end points, shape (3, 2, n_segments)."""
        nodes = np.concatenate([self.points, self.points[:, :1]], axis=1) if self.closed else self.points
        return np.stack([nodes[:, :-2:2], nodes[:, 1:-1:2], nodes[:, 2::2]])

    @cached_property
    def arc(self) -> Array:
        """Arc length at every point, shape (n,), by Gauss quadrature of the speed on each half segment."""
        halves = [self._length(-1.0, 0.0), self._length(0.0, 1.0)]
        steps = np.stack(halves, axis=1).ravel()
        return np.concatenate([[0.0], np.cumsum(steps)])[: self.points.shape[1]]

    @cached_property
    def length(self) -> float:
        """Total arc length."""
        return float(self._length(-1.0, 1.0).sum())

    @cached_property
    def area(self) -> float:
        """What a closed curve encloses, negative where it runs clockwise: of its chords, and 4/3 of what lies
        between each chord and the middle point.
        """
        (x0, y0), (xm, ym), (x1, y1) = self.segments
        bulge = (xm - x0) * (y1 - y0) - (ym - y0) * (x1 - x0)
        return float(0.5 * np.sum(x0 * y1 - y0 * x1) + 2 / 3 * np.sum(bulge))

    def _length(self, low: float, high: float) -> Array:
        xi, weights = np.polynomial.legendre.leggauss(4)
        xi = 0.5 * (low + high) + 0.5 * (high - low) * xi
        speed = np.stack([np.hypot(*self._slope(np.full(self.segments.shape[2], x))) for x in xi])
        return np.asarray(0.5 * (high - low) * (weights @ speed))

    def _slope(self, xi: Array, which: Integers | None = None) -> Array:
        start, mid, end = self.segments if which is None else self.segments[:, :, which]
        return np.asarray(0.5 * (end - start) + (start - 2 * mid + end) * xi)

    def _point(self, xi: Array, which: Integers) -> Array:
        start, mid, end = self.segments[:, :, which]
        return np.asarray(mid + 0.5 * (end - start) * xi + 0.5 * (start - 2 * mid + end) * xi**2)

    def nearest(self, points: Array) -> tuple[Array, Array, Array]:
        """Return distance, unit tangent (2, m) and arc length at the nearest curve point of each point.

        points: (2, m). The foot point solves (x - c(ξ))·c'(ξ) = 0 on the segments of the nearest samples.
        """
        samples, segment, start = self._samples
        tree = cKDTree(samples.T, leafsize=LEAF)
        _, found = tree.query(points.T, k=min(NEAREST, samples.shape[1]))
        found = found.reshape(points.shape[1], -1)
        near = segment[found]
        best = np.full(points.shape[1], np.inf)
        foot, where = np.zeros_like(best), np.zeros(best.shape, dtype=np.int64)
        for k in range(near.shape[1]):
            new = np.flatnonzero((near[:, :k] != near[:, k : k + 1]).all(axis=1))
            which = near[new, k]
            xi = self._project(points[:, new], which, start[found[new, k]])
            distance = np.hypot(*(points[:, new] - self._point(xi, which)))
            better = distance < best[new]
            at = new[better]
            best[at], foot[at], where[at] = distance[better], xi[better], which[better]
        slope = self._slope(foot, where)
        return best, slope / np.hypot(*slope), self._arc_at(foot, where)

    @cached_property
    def _samples(self) -> tuple[Array, Integers, Array]:
        """Points on the curve, about evenly spaced, and the segment and the ξ of each."""
        lengths = self._length(-1.0, 1.0)
        counts = np.ceil(4 * lengths / np.median(lengths)).astype(np.int64)
        which = np.repeat(np.arange(len(counts)), counts)
        order = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
        xi = (2 * order + 1) / counts[which] - 1
        return self._point(xi, which), which, xi

    def _project(self, points: Array, which: Integers, xi: Array) -> Array:
        start, mid, end = self.segments[:, :, which]
        (bx, by), (sx, sy), (dx, dy) = start - 2 * mid + end, 0.5 * (end - start), points - mid
        for _ in range(8):
            gx, gy = dx - (sx + 0.5 * bx * xi) * xi, dy - (sy + 0.5 * by * xi) * xi
            tx, ty = sx + bx * xi, sy + by * xi
            speed2 = tx * tx + ty * ty
            # Gauss-Newton far from the curve's centre of curvature, where the full derivative may vanish
            curvature = np.maximum(speed2 - gx * bx - gy * by, 0.2 * speed2)
            xi = np.clip(xi + (gx * tx + gy * ty) / curvature, -1.0, 1.0)
        return xi

    def _arc_at(self, xi: Array, which: Integers) -> Array:
        nodes = np.append(self.arc, self.length) if self.closed else self.arc
        low, mid, high = nodes[2 * which], nodes[2 * which + 1], nodes[2 * which + 2]
        return mid + 0.5 * (high - low) * xi + 0.5 * (low - 2 * mid + high) * xi**2
