"""Plane curves given as points: checks, arc length, normals, the hull they stretch, distances to them.

Every measure of this package takes `points` (2, n) in order along the curve and `closed`:
False is a pial surface from one end of the base to the other, True an outline, None (default) an outline
where the gap between the two ends is at most twice the longest segment.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import ConvexHull, cKDTree

from ..arrays import Array, Integers
from ..checks import between, finite_array

FEWEST_POINTS = 8
FINE = 2000  # pieces at least that a curve is cut into where distances to it are wanted
WIDEST_GAP = 5.0  # closing segment of an outline over its longest other segment
COINCIDENT = 1e-12  # distance over extent below which two points are one
DIRECTION = 2e-3  # rad; directions of steps closer than this are one
THINNEST, THICKEST = 1e-3, 2.0  # cortical thickness over the radius of the body: beyond, the units differ


class InnerWall(np.ndarray):
    """Points (2, n) of a curve that has the body on its outer side, such as the wall of a ventricle.

    `Result.pial` gives them where it is so; of one's own: `points.view(InnerWall)`. The body of any other
    points lies inside them, whichever way they run; so gyri bulge outwards there, and inwards here.
    """


@dataclass(frozen=True, eq=False)
class Polyline:
    """Checked points (2, n) of a polyline; a closed one does not repeat its first point."""

    points: Array
    closed: bool

    @property
    def size(self) -> int:
        """Number of points."""
        return int(self.points.shape[1])

    @cached_property
    def segments(self) -> Array:
        """Vectors (2, m) from each point to the next; m = n if closed, else n - 1."""
        ahead = np.roll(self.points, -1, axis=1) - self.points
        return ahead if self.closed else ahead[:, :-1]

    @cached_property
    def lengths(self) -> Array:
        """Lengths (m,) of the segments."""
        return np.asarray(np.hypot(*self.segments))

    @property
    def length(self) -> float:
        """Length of the whole curve, m."""
        return float(self.lengths.sum())

    @cached_property
    def arc(self) -> Array:
        """Arc length (n,) from the first point to each point."""
        cumulative = np.concatenate(([0.0], np.cumsum(self.lengths)))
        return cumulative[: self.size]

    @cached_property
    def weights(self) -> Array:
        """Length (n,) that belongs to each point: half of its segments; the sum is the curve's length."""
        if self.closed:
            return (self.lengths + np.roll(self.lengths, 1)) / 2
        half = self.lengths / 2
        return np.concatenate((half, [0.0])) + np.concatenate(([0.0], half))

    @cached_property
    def orientation(self) -> float:
        """+1 if the body is on the left, -1 if it is on the right of the curve, closed by its chord."""
        return (1.0 if enclosed_area(self.points) >= 0 else -1.0) * (-1.0 if self.inner else 1.0)

    @property
    def inner(self) -> bool:
        """Whether the body is on the outer side."""
        return isinstance(self.points, InnerWall)

    @cached_property
    def segment_normals(self) -> Array:
        """Unit normals (2, m) of the segments, out of the body."""
        return self.orientation * np.stack((self.segments[1], -self.segments[0])) / self.lengths

    @cached_property
    def normals(self) -> Array:
        """Unit normals (2, n) at the points, out of the body: mean direction of the two segments there."""
        here, before = self.segment_normals, np.roll(self.segment_normals, 1, axis=1)
        if not self.closed:
            here, before = np.hstack((here, here[:, -1:])), np.hstack((here[:, :1], here))
        total = here + before
        norm = np.hypot(*total)
        spike = norm < COINCIDENT  # the curve turns back on itself: any of the two normals will do
        return np.where(spike, here, total) / np.where(spike, 1.0, norm)

    @cached_property
    def hull(self) -> Integers:
        """Indices of the points on the convex hull, in the order of the curve, and of the ends if open."""
        hull = np.sort(ConvexHull((self.points - self.points[:, :1]).T).vertices).astype(np.int64)
        return hull if self.closed else np.union1d(hull, [0, self.size - 1])

    @cached_property
    def outer(self) -> Polyline:
        """The taut outer path, through the hull: a straight cut across the base is never part of it."""
        return Polyline(self.points[:, self.hull], self.closed)

    @cached_property
    def depth(self) -> Array:
        """Distance (n,) from each point to the side of the outer path that bridges it, m.

        Not to the nearest side: a deep fold may come closer to the side of the body than to its own mouth.
        """
        side = np.searchsorted(self.hull, np.arange(self.size), side="right") - 1
        start, span = self.points[:, self.hull], self.outer.segments
        side = side % span.shape[1] if self.closed else np.minimum(side, span.shape[1] - 1)
        offset = self.points - start[:, side]
        along = np.clip(np.sum(offset * span[:, side], axis=0) / self.outer.lengths[side] ** 2, 0.0, 1.0)
        return np.asarray(np.hypot(*(offset - along * span[:, side])))

    @property
    def radius(self) -> float:
        """Size of the body, m: radius of the disc (pial surface: half disc) with the same outer path."""
        return self.outer.length / (2 * np.pi if self.closed else np.pi)

    @property
    def spacing(self) -> float:
        """Distance between neighbouring points, m: the median, which a straight cut across a base leaves."""
        return float(np.median(self.lengths))

    @property
    def voxel(self) -> float:
        """Size of the voxels, m, that a curve of steps in eight directions was traced round, at most.

        0 for any other curve. A step is the side of a voxel, or joins the middles of two of its sides.
        """
        angles = np.arctan2(self.segments[1], self.segments[0])
        directions = np.sum(np.diff(np.sort(angles)) > DIRECTION) + 1
        return np.sqrt(2) * self.spacing if directions <= 9 else 0.0  # -pi and pi are one

    @property
    def _thickest(self) -> float:
        return float("inf") if self.inner else THICKEST * self.radius

    def may_fold(self, thickness: float) -> bool:
        """Return whether the body is large enough for folds of a cortex so thick, m."""
        return thickness <= self._thickest

    def checked_thickness(self, thickness: Any) -> float:
        """Return a cortical thickness, m, as a float; ValueError if it is not in the unit of the points."""
        low, high = THINNEST * self.radius, self._thickest
        unit = f"the body has a radius of {self.radius:.4g}: give both in one unit, such as m"
        return between("thickness", thickness, low, high, unit)

    def smoothed(self, length: float) -> Polyline:
        """Return the curve averaged along its arc with a Gaussian of standard deviation `length`, m.

        Every point keeps its index. An open curve is continued by its mirror image in the line through its
        ends, as a half body is by its other half.
        """
        if length == 0:
            return self
        loop = self.points
        if not self.closed:
            start, span = loop[:, :1], loop[:, -1:] - loop[:, :1]
            offset = loop - start
            image = start + 2 * span * np.sum(span * offset, axis=0) / np.sum(span**2) - offset
            loop = np.hstack((loop, image[:, -2:0:-1]))
        whole_loop = Polyline(loop, closed=True)
        step = max(min(self.spacing, length), self.spacing / 8) / 4
        count = int(np.ceil(whole_loop.length / step))
        at = np.arange(count) * whole_loop.length / count
        even = [np.interp(at, whole_loop.arc, row, period=whole_loop.length) for row in loop]
        mean = gaussian_filter1d(even, length * count / whole_loop.length, axis=1, mode="wrap")
        return self._along(np.stack([np.interp(self.arc, at, row, period=whole_loop.length) for row in mean]))

    def _along(self, points: Array) -> Polyline:
        """Return other points of the same curve, with the body on the same side."""
        return Polyline(points.view(type(self.points)), self.closed)

    def reversed(self) -> Polyline:
        """Return the same curve, run through from its other end."""
        return Polyline(self.points[:, ::-1], self.closed)

    def cut(self, longest: float) -> Polyline:
        """Return the same polyline with its segments cut into equal pieces no longer than `longest`, m."""
        pieces = np.ceil(self.lengths / longest).astype(int)
        owner = np.repeat(np.arange(pieces.size), pieces)
        piece = np.arange(owner.size) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        points = self.points[:, owner] + self.segments[:, owner] * (piece / pieces[owner])
        return self._along(points if self.closed else np.hstack((points, self.points[:, -1:])))


def enclosed_area(points: Array) -> float:
    """Return the area, m², that points (2, n) enclose with their chord; negative if they run clockwise."""
    x, y = np.asarray(points - points[:, :1])
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def as_polyline(points: Any, closed: bool | None = None, name: str = "points") -> Polyline:
    """Return checked points (2, n) as a curve; a repeated first point at the end of an outline is dropped.

    Raises ValueError for a wrong shape, NaN, fewer than 8 points, points on one line, two equal points in
    a row, an outline that does not close, and an open curve that does.
    """
    array = finite_array(name, points, (2, None))
    if isinstance(points, InnerWall):
        array = array.view(InnerWall)
    _enough(array, name)
    extent = float(np.hypot(*np.ptp(array, axis=1)))
    gap = float(np.hypot(*(array[:, -1] - array[:, 0])))
    steps = np.hypot(*np.diff(array, axis=1))
    repeated = np.flatnonzero(steps <= COINCIDENT * extent)
    if repeated.size:
        k = int(repeated[0])
        raise ValueError(f"{name} {k} and {k + 1} coincide at {array[:, k]}; remove one of them.")
    longest = float(steps.max())
    if closed is None:
        closed = gap <= 2 * longest
    _check_ends(name, closed, gap, longest, extent)
    if closed and gap <= COINCIDENT * extent:
        array = array[:, :-1]
        _enough(array, name)
    spread = np.linalg.svd(array - array.mean(axis=1, keepdims=True), compute_uv=False)
    if spread[1] <= COINCIDENT * spread[0]:
        raise ValueError(f"{name} lie on one straight line; a curve around a body is needed.")
    return Polyline(array, closed)


def _enough(array: Array, name: str) -> None:
    if array.shape[1] < FEWEST_POINTS:
        raise ValueError(f"{name} has {array.shape[1]} points; at least {FEWEST_POINTS} are needed.")


def _check_ends(name: str, closed: bool, gap: float, longest: float, extent: float) -> None:
    if closed and gap > WIDEST_GAP * longest:
        raise ValueError(
            f"{name}: the gap between the ends is {gap:g} m; in a closed outline it must be at most "
            f"{WIDEST_GAP:g} times the longest segment, {longest:g} m: add points, or pass closed=False."
        )
    if not closed and gap <= COINCIDENT * extent:
        raise ValueError(f"{name}: the first and last of the points coincide; pass closed=True.")


def perimeter(points: Any, *, closed: bool | None = None) -> float:
    """Return the length of the curve, m."""
    return as_polyline(points, closed).length


def signed_distance(points: Array, curve: Polyline) -> Array:
    """Return the distance (n,) from points (2, n) to the curve, m; positive outside the body.

    The nearest vertex is found on a finely cut copy of the curve, then the point is projected on the two
    segments there; beside a vertex the sign is that of the mean normal.
    """
    fine = curve.cut(curve.length / max(FINE, 2 * curve.lengths.size))
    _, nearest = cKDTree(fine.points.T).query(points.T)
    last = fine.lengths.size - 1
    best = np.full(points.shape[1], np.inf)
    sign = np.ones(points.shape[1])
    for segment in (nearest - 1, nearest):
        k = segment % fine.lengths.size if fine.closed else np.clip(segment, 0, last)
        offset = points - fine.points[:, k]
        along = np.clip(np.sum(offset * fine.segments[:, k], axis=0) / fine.lengths[k] ** 2, 0.0, 1.0)
        across = offset - along * fine.segments[:, k]
        normal = np.where(along == 0.0, fine.normals[:, k], fine.segment_normals[:, k])
        normal = np.where(along == 1.0, fine.normals[:, (k + 1) % fine.size], normal)
        distance = np.hypot(*across)
        closer = distance < best
        best = np.where(closer, distance, best)
        sign = np.where(closer, np.where(np.sum(across * normal, axis=0) >= 0, 1.0, -1.0), sign)
    return best * sign
