"""Triangles inside a closed polygon: Delaunay refinement by circumcentres, then relaxation.

Points stay where the boundary and the interface put them; between them the mesh has the asked edge length.
Only scipy's Delaunay triangulation (Qhull, BSD-like) is used: `triangle` may not be used commercially and
gmsh is under the GPL.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from ..arrays import Array, Integers
from ..geometry.polygon import inside

Size = Callable[[Array], Array]  # points (2, n) -> edge length (n,)

ROUNDS = 60
RELAXATIONS = 12
WORST = 20.0  # degrees
GRAIN = 2.0**-24  # of the extent: smaller differences are round-off


@dataclass(frozen=True, eq=False)
class Frame:
    """What is given: `points` (2, n), the boundary's first and in order, and `edges` (2, m) to be kept."""

    points: Array
    boundary: int
    edges: Integers

    @property
    def loop(self) -> Array:
        """The boundary polygon, (2, boundary)."""
        return self.points[:, : self.boundary]


def fill(frame: Frame, size: Size) -> tuple[Array, Integers]:
    """Return points (2, n), the frame's first, and counter-clockwise triangles (3, e) of its inside.

    Raises ValueError if an edge of the frame cannot be kept, or an angle stays below 20 degrees.
    """
    near, local, place = _normalised(frame, size)
    free = np.empty((2, 0))
    for _ in range(ROUNDS):
        points, triangles = _triangulated(near, free)
        more = _missing_points(near, points, triangles, local)
        if not more.shape[1]:
            break
        free = np.concatenate([free, more], axis=1)
    for _ in range(RELAXATIONS):
        points, triangles = _triangulated(near, free)
        free = _outside_circles(near, _relaxed(points, triangles, local)[:, frame.points.shape[1] :])
    _, triangles = _triangulated(near, free)
    points = np.concatenate([frame.points, place(free)], axis=1)
    _check(frame, points, triangles)
    return points, triangles


def _normalised(frame: Frame, size: Size) -> tuple[Frame, Size, Callable[[Array], Array]]:
    """Return frame and size around the origin, in units of the extent, and the way back for points.

    They are rounded to GRAIN: then neither the place of a body nor its unit decides between triangles that
    are equally good.
    """
    low, high = frame.loop.min(1, keepdims=True), frame.loop.max(1, keepdims=True)
    centre, unit = 0.5 * (low + high), float((high - low).max())

    def rounded(values: Array) -> Array:
        return np.asarray(np.round(values / GRAIN) * GRAIN)

    def place(at: Array) -> Array:
        return np.asarray(centre + unit * at)

    def local(at: Array) -> Array:
        return rounded(size(place(at)) / unit)

    return Frame(rounded((frame.points - centre) / unit), frame.boundary, frame.edges), local, place


def angles(points: Array, triangles: Integers) -> Array:
    """Return the smallest angle of each triangle, (e,); degrees."""
    a, b, c = points[:, triangles].swapaxes(0, 1)
    smallest = np.full(triangles.shape[1], 180.0)
    for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
        u, v = q - p, r - p
        angle = np.degrees(np.arctan2(u[0] * v[1] - u[1] * v[0], (u * v).sum(0)))
        smallest = np.minimum(smallest, angle)
    return smallest


def _triangulated(frame: Frame, free: Array) -> tuple[Array, Integers]:
    points = np.concatenate([frame.points, free], axis=1)
    triangles = np.asarray(Delaunay(points.T).simplices.T, dtype=np.int64)
    a, b, c = points[:, triangles].swapaxes(0, 1)
    turn = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
    triangles[1:, turn < 0] = triangles[:0:-1, turn < 0]
    # only a triangle with all its corners on the boundary can lie outside
    unsure = np.flatnonzero((triangles < frame.boundary).all(0))
    outside = unsure[~inside(points[:, triangles[:, unsure]].mean(1), frame.loop)]
    return points, np.delete(triangles, outside, axis=1)


def _missing_points(frame: Frame, points: Array, triangles: Integers, size: Size) -> Array:
    """Return circumcentres of triangles that are too large, not too close to each other, (2, m)."""
    a, b, c = points[:, triangles].swapaxes(0, 1)
    u, v = b - a, c - a
    twice = 2 * (u[0] * v[1] - u[1] * v[0])
    uu, vv = (u**2).sum(0), (v**2).sum(0)
    offset = np.stack([v[1] * uu - u[1] * vv, u[0] * vv - v[0] * uu]) / twice
    radius, centre = np.hypot(*offset), a + offset
    wanted = size(centre) / np.sqrt(3)
    large = np.flatnonzero((radius > 1.2 * wanted) & inside(centre, frame.loop))
    order = large[np.argsort(-(radius / wanted)[large])]
    centre = _outside_circles(frame, centre[:, order])
    if not centre.shape[1]:
        return centre
    lengths = size(centre)
    near = cKDTree(centre.T).query_pairs(0.8 * lengths.max(), output_type="ndarray")
    apart = np.hypot(*(centre[:, near[:, 0]] - centre[:, near[:, 1]]))
    clash = near[apart < 0.8 * np.minimum(lengths[near[:, 0]], lengths[near[:, 1]])]
    dropped = np.zeros(centre.shape[1], dtype=bool)
    for first, second in clash[np.lexsort(clash.T[::-1])].tolist():
        if not dropped[first]:
            dropped[second] = True
    return centre[:, ~dropped]


def _outside_circles(frame: Frame, free: Array) -> Array:
    """Return the points outside the circles around edges of the frame; inside, they would hide them."""
    start, end = frame.points[:, frame.edges[0]], frame.points[:, frame.edges[1]]
    middle, radius = 0.5 * (start + end), 0.5 * np.hypot(*(end - start))
    if not free.shape[1]:
        return free
    reach = 1.05 * radius
    near = cKDTree(free.T).query_ball_point(middle.T, reach)
    hiding = np.unique(np.concatenate([np.asarray(ids, dtype=np.int64) for ids in near]))
    return np.delete(free, hiding, axis=1)


def _relaxed(points: Array, triangles: Integers, size: Size) -> Array:
    """Move every point to the mean of its triangles' centres, weighted by area / (edge length)²."""
    a, b, c = points[:, triangles].swapaxes(0, 1)
    centre = (a + b + c) / 3
    u, v = b - a, c - a
    weight = 0.5 * (u[0] * v[1] - u[1] * v[0]) / size(centre) ** 2
    corner, count = triangles.ravel(), points.shape[1]
    total = np.bincount(corner, np.tile(weight, 3), minlength=count)
    moved = np.stack([np.bincount(corner, np.tile(weight * x, 3), minlength=count) for x in centre])
    return moved / np.where(total > 0, total, 1.0)


def _check(frame: Frame, points: Array, triangles: Integers) -> None:
    count = points.shape[1]
    sides = np.concatenate([triangles[[0, 1]], triangles[[1, 2]], triangles[[2, 0]]], axis=1)
    present = np.unique(np.sort(sides, axis=0).T @ np.array([count, 1]))
    wanted = np.sort(frame.edges, axis=0).T @ np.array([count, 1])
    lost = np.flatnonzero(~np.isin(wanted, present))
    if len(lost):
        x, y = points[:, frame.edges[:, lost[0]]].mean(1)
        raise ValueError(
            f"the mesh loses {len(lost)} edges of boundary or interface, first near ({x:.4g}, {y:.4g}) m, "
            "where two lines come closer than the element size; use smaller elements (size=...) or a "
            "smoother outline (smooth=...)."
        )
    smallest = angles(points, triangles)
    if smallest.min() < WORST:
        k = int(np.argmin(smallest))
        x, y = points[:, triangles[:, k]].mean(1)
        raise ValueError(
            f"the mesh has an angle of {smallest[k]:.3g} degrees near ({x:.4g}, {y:.4g}) m, less than "
            f"{WORST:g}; use smaller elements (size=...) or a smoother outline (smooth=...)."
        )
