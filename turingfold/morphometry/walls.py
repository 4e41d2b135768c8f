"""How a curve meets itself: crossings, touching walls, and its mirror image."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array, Booleans, Integers
from ..checks import finite_array, positive
from ..geometry.quadratic import bend, distance, point
from .polyline import Polyline, as_polyline

LONG = 4.0  # segments longer than this many medians are tested against all others
FLAT = 1e-9  # of the extent: parts of curves closer than this to their chords are those
OPPOSED = -0.5  # cosine between the normals of two walls that face each other


def self_intersections(points: Any, *, closed: bool | None = None, quadratic: bool = False) -> int:
    """Return how often a curve crosses itself: proper crossings of segments that do not share a point.

    quadratic: the points are the nodes of quadratic segments, a vertex and a middle by turns, and the curves
    through them are counted, not their chords; overlaps less deep than FLAT of the extent may be missed.
    The points are first moved by 1e-12 of their extent (always the same way), so that a crossing through a
    vertex counts once; a contact closer than that may count as none or two.
    """
    curve = as_polyline(points, closed)
    start = _unsettled(curve.points)
    if quadratic:
        if curve.size % 2 == curve.closed:
            raise ValueError(
                f"points has {curve.size} points; the nodes of quadratic segments are an "
                f"{'even' if curve.closed else 'odd'} number: a vertex and a middle by turns."
            )
        size = curve.size
        first = np.arange(0, size - (not curve.closed), 2)
        return len(_curved_crossings(start[:, [first, first + 1, (first + 2) % size]].swapaxes(0, 1)))
    pairs = _near_pairs(curve)
    end = np.roll(start, -1, axis=1)[:, : curve.lengths.size]
    i, j = pairs.T
    return int(_cross(start[:, i], end[:, i], start[:, j], end[:, j]).sum())


def edge_crossings(points: Array, edges: Integers) -> Integers:
    """Return the two edges of each place, (k, 2), where quadratic edges cross each other.

    points: of the nodes, (2, n).  edges: start, middle and end node of each, (3, m).  They are as many as
    `self_intersections` counts.
    """
    used, local = np.unique(edges, return_inverse=True)
    return _curved_crossings(_unsettled(points[:, used])[:, local.reshape(edges.shape)].swapaxes(0, 1))


def _unsettled(points: Array) -> Array:
    """Return points (2, n) about their centre, in units of their extent, each moved by 1e-12 or less."""
    start = points - points.mean(axis=1, keepdims=True)
    shift = np.random.default_rng(0).uniform(-1e-12, 1e-12, points.shape)
    return np.asarray(start / np.abs(start).max() + shift)


def _curved_crossings(curves: Array) -> Integers:
    """Return the two segments of each crossing, (k, 2), of quadratic segments, (3, 2, m).

    Pairs are halved as long as they may meet: a part of length h in ξ leaves its chord by |b| h²/2 at most,
    with b = x₀ - 2 x_m + x₁.
    """
    bent = np.hypot(*bend(curves))
    hull = np.stack((curves[0], 2 * curves[1] - 0.5 * (curves[0] + curves[2]), curves[2]))
    i, j = _overlapping(hull.min(axis=0), hull.max(axis=0))
    meet = ~_parted(hull[..., i], hull[..., j])
    i, j = i[meet], j[meet]
    s, t, h = np.zeros(i.size), np.zeros(i.size), 1.0
    found = [np.zeros((0, 2), dtype=np.int64)]
    while i.size:
        a, b, c, d = (point(curves[..., k], x) for k, x in ((i, s), (i, s + h), (j, t), (j, t + h)))
        missed = 0.5 * h * h * (bent[i] + bent[j])
        near = _cross(a, b, c, d) | (_gap(a, b, c, d) <= missed)
        done = missed <= FLAT
        joined = np.any([(p == q).all(axis=0) for p in (a, b) for q in (c, d)], axis=0)
        met = _cross(a, b, c, d) & done & ~joined
        found.append(np.stack([i[met], j[met]], axis=1))
        halve = near & ~done
        h = 0.5 * h
        i, j = np.tile(i[halve], 4), np.tile(j[halve], 4)
        s = (s[halve] + h * np.array([[0], [1], [0], [1]])).ravel()
        t = (t[halve] + h * np.array([[0], [0], [1], [1]])).ravel()
    return np.concatenate(found)


def _overlapping(low: Array, high: Array) -> tuple[Integers, Integers]:
    """Return the pairs of boxes, by their lowest and highest corners (2, m), that overlap.

    Boxes overlap if they do along x and along y. Those of a straight wall all overlap across it: pairs are
    looked for along x, y, or a diagonal, whichever has fewest.
    """
    (x, y), (right, top) = low, high
    ways = ((x, right), (y, top), (x + y, right + top), (x - top, right - y))
    order, count = min((_within_reach(*way) for way in ways), key=lambda found: found[1].sum())
    number = np.arange(order.size)
    before = np.repeat(number, count)
    after = before + 1 + np.arange(before.size) - np.repeat(np.cumsum(count) - count, count)
    i, j = order[before], order[after]
    for start, end in ways[:2]:
        meet = (start[i] <= end[j]) & (start[j] <= end[i])
        i, j = i[meet], j[meet]
    return i, j


def _within_reach(start: Array, end: Array) -> tuple[Integers, Integers]:
    """Return the order of intervals by their starts, and how many of those later start before each ends."""
    order = np.argsort(start, kind="stable")
    return order, np.searchsorted(start[order], end[order], side="right") - np.arange(order.size) - 1


def _parted(one: Array, other: Array) -> Booleans:
    """Return whether pairs of curves have one end in common and a line through it has them on its two sides.

    one, other: their control points, (3, 2, n); seen from an end, a curve lies in the cone of the other two.
    """
    found = np.zeros(one.shape[2], dtype=bool)
    for arm in (one, one[::-1]):
        for opposite in (other, other[::-1]):
            near = np.flatnonzero((arm[0] == opposite[0]).all(axis=0))
            ways = np.stack([arm[1:], opposite[1:]])[..., near] - arm[0][:, near]
            lengths = np.hypot(ways[:, :, 0], ways[:, :, 1])
            mean = np.sum(ways / np.maximum(lengths, 1e-300)[:, :, None], axis=1)
            side = np.sum(ways * (mean[0] - mean[1]), axis=2)
            found[near] |= (side[0] > 0).all(axis=0) & (side[1] < 0).all(axis=0)
    return found


def _gap(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Return the distance between segments a-b and c-d that do not cross."""
    ways = ((a, c, d), (b, c, d), (c, a, b), (d, a, b))
    return np.asarray(np.min([distance(*way) for way in ways], axis=0))


def _cross(a: Array, b: Array, c: Array, d: Array) -> Booleans:
    """Return whether segments a-b and c-d cross each other."""
    return np.asarray((_side(a, b, c) != _side(a, b, d)) & (_side(c, d, a) != _side(c, d, b)))


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
