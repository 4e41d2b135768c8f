"""Triangles inside a frame of lines: Delaunay refinement by circumcentres, then relaxation.

Nodes of the frame stay where they are; between them the mesh has the asked edge length. Only scipy's Delaunay
triangulation (Qhull, BSD-like) is used: `triangle` may not be used commercially and gmsh is under the GPL.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely
from scipy.spatial import Delaunay, cKDTree

from ..arrays import Array, Booleans, Integers
from .frame import RESOLUTION, Frame, Side, Size, kept, missing, split, within

ROUNDS = 60
RELAXATIONS = 4
REPAIRS = 6
WORST = 21.0  # degrees: below, edges of the frame are split
SHORTEST = 0.05  # share of the asked size below which edges of the frame are not split
NEAREST = 4  # nodes of the frame that bound the edge length at a point
FLAT = 1e-6  # height of a triangle over its length below which its corners are on one line
SLACK = 1.2  # edges may be this much longer than those of the frame beside them


def fill(
    sides: list[Side], size: Size, white: Callable[[Array], Booleans], grading: float
) -> tuple[Frame, Array, Integers, Integers]:
    """Return the frame, points (2, n), the frame's first, and counter-clockwise triangles (3, e) inside.

    At last the edges of the frame that no triangle has: none unless lines cross.

    size: edge length asked for at points; where `white` tells that they are in white matter it grows by
    grading × distance from the frame. It is bounded by 1.2 × edge + grading × distance of the nearest nodes
    of the frame. Beside triangles with an angle below 21 degrees edges of the frame are split.
    """
    shortest = SHORTEST * float(min(size(one.line).min() for one in sides))
    best, result = -np.inf, None
    for _ in range(REPAIRS):
        sides, found = kept(sides, shortest)
        bounded = _bounded(found, size, white, grading)
        points, triangles = _refined(found, np.empty((2, 0)), bounded)
        for _ in range(RELAXATIONS):
            free = _relaxed(points, triangles, bounded)[:, found.points.shape[1] :]
            points, triangles = _refined(found, _outside_circles(found, free), bounded)
            gone, smallest = missing(found, triangles), angles(points, triangles)
            worst = -1.0 if len(gone) else min(WORST, float(smallest.min()))
            if worst >= best:
                best, result = worst, (found, points, triangles, gone)
        if best == WORST:
            break
        beside = np.flatnonzero(np.isin(found.edges, triangles[:, smallest < WORST]).any(axis=0))
        again = np.union1d(beside, gone)
        again = again[found.lengths[again] > 2 * shortest]
        if not len(again):
            break
        sides = split(sides, found, again)
    assert result is not None
    return result


def _bounded(found: Frame, size: Size, white: Callable[[Array], Booleans], grading: float) -> Size:
    """Return the edge length at points: as asked, more in white matter, and fit for the frame beside it."""
    longest = np.zeros(found.points.shape[1])
    np.maximum.at(longest, found.edges.ravel(), np.tile(found.lengths, 2))
    tree, count = cKDTree(found.points.T), np.arange(1, 1 + min(NEAREST, len(longest)))

    def bounded(at: Array) -> Array:
        distance, near = (np.asarray(found) for found in tree.query(at.T, k=count))
        deep = np.where(white(at), distance[:, 0], 0.0)
        beside = (SLACK * longest[near] + grading * distance).min(1)
        return np.asarray(np.round(np.minimum(size(at) + grading * deep, beside) / RESOLUTION) * RESOLUTION)

    return bounded


def angles(points: Array, triangles: Integers) -> Array:
    """Return the smallest angle of each triangle, (e,); degrees."""
    a, b, c = points[:, triangles].swapaxes(0, 1)
    smallest = np.full(triangles.shape[1], 180.0)
    for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
        u, v = q - p, r - p
        angle = np.degrees(np.arctan2(u[0] * v[1] - u[1] * v[0], (u * v).sum(0)))
        smallest = np.minimum(smallest, angle)
    return smallest


def _triangulated(found: Frame, free: Array) -> tuple[Array, Integers]:
    points = np.concatenate([found.points, free], axis=1)
    triangles = np.asarray(Delaunay(points.T).simplices.T, dtype=np.int64)
    a, b, c = points[:, triangles].swapaxes(0, 1)
    turn = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
    triangles[1:, turn < 0] = triangles[:0:-1, turn < 0]
    # only a triangle with all its corners on the boundary can lie outside, or be flat
    around = np.zeros(points.shape[1], dtype=bool)
    around[found.boundary] = True
    unsure = np.flatnonzero(around[triangles].all(0))
    centres, longest = points[:, triangles[:, unsure]].mean(1), ((b - a) ** 2 + (c - a) ** 2).sum(0)[unsure]
    keep = shapely.contains_xy(found.domain, *centres) & (np.abs(turn[unsure]) > FLAT * longest)
    return points, np.delete(triangles, unsure[~keep], axis=1)


def _refined(found: Frame, free: Array, size: Size) -> tuple[Array, Integers]:
    """Return points, the frame's first, and triangles, after adding points where triangles are too large."""
    for _ in range(ROUNDS):
        points, triangles = _triangulated(found, free)
        more = _missing_points(found, points, triangles, size)
        if not more.shape[1]:
            break
        free = np.concatenate([free, more], axis=1)
    return points, triangles


def _missing_points(found: Frame, points: Array, triangles: Integers, size: Size) -> Array:
    """Return circumcentres of triangles that are too large, not too close to each other, (2, m)."""
    a, b, c = points[:, triangles].swapaxes(0, 1)
    u, v = b - a, c - a
    twice = 2 * (u[0] * v[1] - u[1] * v[0])
    uu, vv = (u**2).sum(0), (v**2).sum(0)
    with np.errstate(divide="ignore", invalid="ignore"):  # of flat triangles
        offset = np.stack([v[1] * uu - u[1] * vv, u[0] * vv - v[0] * uu]) / twice
    within = shapely.contains_xy(found.domain, *np.nan_to_num(a + offset, posinf=9.0, neginf=9.0))
    radius, centre = np.hypot(*offset)[within], (a + offset)[:, within]
    excess = radius / (1.2 / np.sqrt(3) * size(centre))
    order = np.argsort(-excess, kind="stable")[: int((excess > 1).sum())]
    centre = _outside_circles(found, centre[:, order])
    if not centre.shape[1]:
        return centre
    lengths = size(centre)
    clash = _too_near(centre, 0.8 * lengths)
    dropped = np.zeros(centre.shape[1], dtype=bool)
    for first, second in clash.T.tolist():
        if not dropped[first]:
            dropped[second] = True
    return centre[:, ~dropped]


def _too_near(points: Array, apart: Array) -> Integers:
    """Return the pairs of points (2, n) nearer to each other than `apart` (n,) of both, in order; (2, m)."""
    first, second = pairs = within(points, points, apart)
    distance = np.hypot(*(points[:, first] - points[:, second]))
    return pairs[:, (first < second) & (distance < apart[second])]


def _outside_circles(found: Frame, free: Array) -> Array:
    """Return the points outside the circles around edges of the frame; inside, they would hide them."""
    return np.delete(free, np.unique(within(found.centres, free, 0.525 * found.lengths)[1]), axis=1)


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
