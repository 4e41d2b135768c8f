"""How far points lie from a curve, along its normal."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.interpolate import CubicSpline

from ..arrays import Array

SAMPLES = (np.arange(8) + 0.5) / 4 - 1.0  # in [-1, 1] of each quadratic edge
SHAPES = np.stack([0.5 * SAMPLES * (SAMPLES - 1), 1 - SAMPLES**2, 0.5 * SAMPLES * (SAMPLES + 1)])


def sampled(nodes: Array, *, closed: bool) -> Array:
    """Return eight points on each quadratic edge of a curve, given by its nodes (2, n) in order.

    With so many it does not matter where the points of a target lie: fewer would slide to where its noise
    averages out.
    """
    path = np.concatenate([nodes, nodes[:, :1]], axis=1) if closed else nodes
    edges = np.stack([path[:, :-2:2], path[:, 1:-1:2], path[:, 2::2]])  # (3, 2, m)
    return np.asarray(np.einsum("kim,kg->img", edges, SHAPES).reshape(2, -1))


def through(points: Array, *, closed: bool) -> Array:
    """Return a polygon with eight times as many points on the cubic spline through points (2, n)."""
    path = np.concatenate([points, points[:, :1]], axis=1) if closed else points
    arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(path, axis=1))))
    spline = CubicSpline(arc, path, axis=1, bc_type="periodic" if closed else "not-a-knot")
    fine = np.interp(np.arange(8 * (len(arc) - 1) + 1) / 8, np.arange(len(arc)), arc)
    return np.asarray(spline(fine[:-1] if closed else fine))


def signed_distance(points: Array, target: Array, *, closed: bool) -> tuple[Array, Array]:
    """Return the distances of points (2, n) from a polygon (2, m), positive on its left, and their gradients.

    The gradient of a distance, (2, n), is the unit vector from the nearest place to the point, or the normal
    of the polygon for a point on it.
    """
    start = target if closed else target[:, :-1]
    end = np.roll(target, -1, axis=1) if closed else target[:, 1:]
    edges = shapely.STRtree(shapely.linestrings(np.stack([start.T, end.T], axis=1)))
    nearest = edges.nearest(shapely.points(points.T))
    start, way = start[:, nearest], (end - start)[:, nearest]
    length2 = np.maximum((way**2).sum(0), np.finfo(float).tiny)
    gap = points - start
    off = gap - np.clip((gap * way).sum(0) / length2, 0.0, 1.0) * way
    normal = np.stack([-way[1], way[0]]) / np.sqrt(length2)
    size = np.hypot(*off)
    side = np.where((off * normal).sum(0) < 0, -1.0, 1.0)
    unit = np.where(size > 1e-12 * np.sqrt(length2), side * off / np.maximum(size, 1e-300), normal)
    return side * size, unit
