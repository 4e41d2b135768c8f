"""Gyri and sulci: where they are, how deep, how wide, how far apart.

A sulcus is an inward excursion of the fold height by at least `prominence` against the crests on both
sides. It is followed along the arc, never as a function of angle, so overhanging folds and touching walls
count like any other. The height is the signed distance to a `reference` outline where one is given (then
undulations of a still convex curve count too), else minus the depth below the taut outer path.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ..arrays import Array, Integers
from ..checks import positive
from .polyline import Polyline, as_polyline, signed_distance

PROMINENCE = 0.005  # least depth of a sulcus over the radius of the body: some 0.05 to 0.08 of the thickness
PLATEAU = 0.1  # heights closer than this part of the prominence are one crest or one floor


@dataclass(frozen=True, kw_only=True)
class Folds:
    """Folds of one curve, in order along it.

    sulci, gyri: indices of fundi and crests; an open curve with sulci has one gyrus more, a curve without
    sulci has no gyri.  depths: fundus below the mean of the crests beside it, m, one per sulcus.
    widths: distance across a gyrus half way down its two walls, m, one per gyrus with two walls.
    heights: fold height (n,) at all points, m.
    """

    sulci: Integers
    gyri: Integers
    depths: Array
    widths: Array
    heights: Array

    @property
    def count(self) -> int:
        """Number of sulci."""
        return self.sulci.size

    @property
    def depth(self) -> float:
        """Mean depth of the sulci, m; 0 without sulci."""
        return float(self.depths.mean()) if self.depths.size else 0.0

    @property
    def width(self) -> float:
        """Mean width of the gyri with two walls, m; NaN without such gyri."""
        return float(self.widths.mean()) if self.widths.size else float("nan")


def fold_height(points: Any, *, reference: Any = None, closed: bool | None = None) -> Array:
    """Return the fold height (n,), m: signed distance to `reference` (2, m), or minus the hull depth.

    Hull depth: distance to the side of the convex hull that bridges the fold; for a pial surface, of the
    way from its first point round the hull to its last.
    """
    return _height(as_polyline(points, closed), reference)


def find_folds(
    points: Any, *, prominence: float | None = None, reference: Any = None, closed: bool | None = None
) -> Folds:
    """Return the folds of a curve; `prominence` is the least depth of a sulcus, m.

    Default: 0.005 of the radius of the body. Raises ValueError for a prominence that is not positive and
    for points that are no curve.
    """
    curve = as_polyline(points, closed)
    least = PROMINENCE * curve.radius if prominence is None else positive("prominence", prominence)
    heights = _height(curve, reference)
    walk, along = _walk(curve, heights)
    h = heights[walk]
    fundi = _fundi(h[:along], least)
    if not fundi:
        none = np.zeros(0, dtype=np.int64)
        return Folds(sulci=none, gyri=none, depths=np.zeros(0), widths=np.zeros(0), heights=heights)
    bounds = [*fundi, fundi[0] + curve.size] if curve.closed else [0, *fundi, curve.size - 1]
    crests = [a + int(np.argmax(h[a : b + 1])) for a, b in pairwise(bounds)]
    turns = [*crests, crests[0] + curve.size] if curve.closed else crests
    floors = [a + int(np.argmin(h[a : b + 1])) for a, b in pairwise(turns)]
    sides = list(zip(pairwise(turns), floors, strict=True))
    tops = zip(pairwise(bounds), crests, strict=True)
    slack = PLATEAU * least
    return Folds(
        sulci=walk[[_middle(h, a, b, floor, slack) for (a, b), floor in sides]],
        gyri=walk[[_middle(h, a, b, crest, slack) for (a, b), crest in tops]],
        depths=np.array([(h[a] + h[b]) / 2 - h[floor] for (a, b), floor in sides]),
        widths=_widths(curve, walk, h, sides),
        heights=heights,
    )


def fold_count(
    points: Any, *, prominence: float | None = None, reference: Any = None, closed: bool | None = None
) -> int:
    """Return the number of sulci deeper than `prominence`, m (default 0.005 of the radius of the body).

    A convex curve has none, unless a `reference` outline (2, m) says what it undulates about.
    """
    return find_folds(points, prominence=prominence, reference=reference, closed=closed).count


def sulcal_depth(
    points: Any, *, prominence: float | None = None, reference: Any = None, closed: bool | None = None
) -> float:
    """Return the mean depth of the sulci, m, each below the mean of its two crests; 0 without sulci."""
    return find_folds(points, prominence=prominence, reference=reference, closed=closed).depth


def wavelength_spectrum(
    points: Any, *, reference: Any = None, closed: bool | None = None
) -> tuple[Array, Array]:
    """Return wave lengths (k,), m, longest first, and the part (k,) of the fold height's variance in each.

    The height is expanded over the fraction s of the arc: closed, exp(2 pi i k s) with wave length H/k; open,
    cos(pi k s) with wave length 2H/k; H is the length of the outer path, so the wave length is the spacing
    of the crests and does not grow with the depth of the folds. All parts are 0 where the height is constant.
    """
    curve = as_polyline(points, closed)
    count = max(256, 2 * curve.size)
    s = np.append(curve.arc, curve.length) if curve.closed else curve.arc
    h = _height(curve, reference)
    h = np.append(h, h[0]) if curve.closed else h
    grid = (np.arange(count) + 0.5) / count * curve.length
    sampled = np.interp(grid, s, h)
    if not curve.closed:
        sampled = np.concatenate((sampled, sampled[::-1]))  # the even copy turns half waves into whole ones
    power = np.abs(np.fft.rfft(sampled)[1 : curve.size // 2]) ** 2
    k = np.arange(1, power.size + 1)
    waves = (1 if curve.closed else 2) * curve.outer.length / k
    total = power.sum()
    flat = np.ptp(h) <= 1e-9 * curve.radius
    return waves, np.zeros_like(power) if flat else power / total


def _height(curve: Polyline, reference: Any) -> Array:
    if reference is None:
        return -curve.depth
    return signed_distance(curve.points, as_polyline(reference, curve.closed, "reference"))


def _walk(curve: Polyline, heights: Array) -> tuple[Integers, int]:
    """Return point indices along the curve and how many of them make one round.

    An outline starts on its highest point, which also ends the round, and goes on for three rounds: then no
    stretch between folds is cut.
    """
    if not curve.closed:
        return np.arange(curve.size), curve.size
    start = int(np.argmax(heights))
    return (start + np.arange(3 * curve.size + 1)) % curve.size, curve.size + 1


def _fundi(heights: Array, least: float) -> list[int]:
    """Return the indices of the minima that lie at least `least` below a maximum on either side."""
    fundi, crest, floor, down = [], 0, 0, False
    for k, h in enumerate(heights):
        if down and h < heights[floor]:
            floor = k
        elif down and h - heights[floor] >= least:
            fundi.append(floor)
            crest, down = k, False
        elif not down and h > heights[crest]:
            crest = k
        elif not down and heights[crest] - h >= least:
            floor, down = k, True
    return fundi


def _middle(h: Array, first: int, last: int, extreme: int, slack: float) -> int:
    """Return the middle of the plateau around h[extreme] between two indices.

    The end of an open curve is taken for a mirror: a plateau that reaches it has its middle there.
    """
    level = first + np.flatnonzero(np.abs(h[first : last + 1] - h[extreme]) <= slack)
    if level[0] == 0 or level[-1] == h.size - 1:
        return 0 if level[0] == 0 else h.size - 1
    return int(level[0] + level[-1]) // 2


def _widths(curve: Polyline, walk: Integers, h: Array, sides: list[tuple[tuple[int, int], int]]) -> Array:
    """Return the distances between the half-depth points of the walls that face away from each other."""
    points = curve.points[:, walk]
    down = [_half_way(points, h, a, floor) for (a, _), floor in sides]
    up = [_half_way(points, h, b, floor) for (_, b), floor in sides]
    following = [*down[1:], down[0]] if curve.closed else down[1:]
    return np.array([np.hypot(*(q - p)) for p, q in zip(up, following, strict=False)])


def _half_way(points: Array, h: Array, crest: int, floor: int) -> Array:
    """Return the first point (2,) from crest to floor at the mean of their heights."""
    path = np.arange(crest, floor + 1) if floor > crest else np.arange(crest, floor - 1, -1)
    level = (h[crest] + h[floor]) / 2
    k = int(np.argmax(h[path] < level))
    a, b = path[k - 1], path[k]
    part = (h[a] - level) / (h[a] - h[b])
    return np.asarray(points[:, a] + part * (points[:, b] - points[:, a]))
