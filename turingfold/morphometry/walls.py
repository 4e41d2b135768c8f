"""How a curve meets itself: crossings, touching walls, and its mirror image."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array, Integers
from ..checks import finite_array, positive
from .polyline import Polyline, as_polyline

LONG = 4.0  # segments longer than this many medians are tested against all others
OPPOSED = -0.5  # cosine between the normals of two walls that face each other


def self_intersections(points: Any, *, closed: bool | None = None) -> int:
    """Return the number of proper crossings of pairs of segments that do not share a point.

    The points are first moved by 1e-12 of their extent (always the same way), so that a crossing through a
    vertex counts once; a contact closer than that may count as none or two.
    """
    curve = as_polyline(points, closed)
    pairs = _near_pairs(curve)
    shift = np.random.default_rng(0).uniform(-1e-12, 1e-12, curve.points.shape)
    start = curve.points - curve.points.mean(axis=1, keepdims=True)
    start = start / np.abs(start).max() + shift
    end = np.roll(start, -1, axis=1)[:, : curve.lengths.size]
    i, j = pairs.T
    a, b, c, d = start[:, i], end[:, i], start[:, j], end[:, j]
    split = (_side(a, b, c) != _side(a, b, d)) & (_side(c, d, a) != _side(c, d, b))
    return int(split.sum())


def wall_contact_length(points: Any, gap: float, *, closed: bool | None = None) -> float:
    """Return the length of the curve, m, that faces another part of it at most `gap`, m, away.

    Both walls count. A point faces another where their normals are opposed by more than 120 degrees and the
    other lies outside, within a sampling step (the median segment) of the normal.
    """
    curve = as_polyline(points, closed)
    gap = positive("gap", gap)
    step = float(np.median(curve.lengths))
    fine = curve.cut(step)
    normal, middle = fine.segment_normals, fine.points[:, : fine.lengths.size] + fine.segments / 2
    pairs = cKDTree(middle.T).query_pairs(float(np.hypot(gap, step)), output_type="ndarray")
    pairs = pairs[np.sum(normal[:, pairs[:, 0]] * normal[:, pairs[:, 1]], axis=0) < OPPOSED]
    i, j = np.concatenate((pairs, pairs[:, ::-1])).T
    offset = middle[:, j] - middle[:, i]
    away = np.sum(offset * normal[:, i], axis=0)
    aside = np.abs(offset[0] * normal[1, i] - offset[1] * normal[0, i])
    touching = np.unique(i[(away > 0) & (away <= gap) & (aside <= step)])
    return float(fine.lengths[touching].sum())


def mirror_error(points: Any) -> float:
    """Return the largest distance, m, between the curve and its mirror image in x = 0.

    max_k |x_k - M x_{n-1-k}| with M = diag(-1, 1): for points (2, n) numbered symmetrically.
    """
    array = finite_array("points", points, (2, None))
    if array.shape[1] == 0:
        raise ValueError("points has no points; it must have at least 1.")
    image = array[:, ::-1] * np.array([[-1.0], [1.0]])
    return float(np.hypot(*(array - image)).max())


def _near_pairs(curve: Polyline) -> Integers:
    """Return pairs (k, 2) of segments that share no point and may cross."""
    m, lengths = curve.lengths.size, curve.lengths
    long = lengths > LONG * np.median(lengths)
    middle = curve.points[:, :m] + curve.segments / 2
    short = np.flatnonzero(~long)
    near = cKDTree(middle[:, short].T).query_pairs(float(lengths[short].max()), output_type="ndarray")
    with_long = np.stack(np.meshgrid(np.flatnonzero(long), np.arange(m)), axis=-1).reshape(-1, 2)
    once = ~long[with_long[:, 1]] | (with_long[:, 0] < with_long[:, 1])
    pairs = np.concatenate((short[near], with_long[once]))
    apart = np.abs(pairs[:, 0] - pairs[:, 1])
    return np.asarray(pairs[(apart > 1) & ~(curve.closed & (apart == m - 1))])


def _side(a: Array, b: Array, c: Array) -> Array:
    """Return on which side of the line a-b the points c lie."""
    return np.asarray((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0)
