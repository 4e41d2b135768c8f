"""Gyri and sulci: where they are, how deep, how wide, how far apart.

A sulcus is an inward excursion of the fold height between two crests, followed along the arc and never as a
function of angle, so that overhanging folds and touching walls count like any other. The height is the
signed distance to a `reference` outline where one is given (then undulations of a still convex curve count
too), else minus the depth below the convex hull.

Two lengths say what counts: a sulcus is at least `prominence` below both its crests, and half of that
remains when the curve is averaged along its arc over `smoothing`. Ripples fail the first, the stairs of an
outline traced round voxels the second.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypedDict, Unpack

import numpy as np

from ..arrays import Array, Integers
from ..checks import between, positive
from .polyline import Polyline, as_polyline, signed_distance

PROMINENCE = 0.2, 0.0125  # least depth of a sulcus, over the cortical thickness and over the body's radius
SMOOTHING = 0.25, 1 / 60  # standard deviation of the average along the arc, over the same
COARSEST = 0.125  # largest voxel that raises the least depth, over the body's radius
PLATEAU = 0.1  # heights closer than this part of the prominence are one crest or one floor


class Options(TypedDict, total=False):
    """The options of `find_folds`, for functions that hand them on."""

    thickness: float | None
    prominence: float | None
    smoothing: float | None
    reference: Any
    closed: bool | None


@dataclass(frozen=True, kw_only=True)
class Folds:
    """Folds of one curve, in order along it.

    sulci, gyri: indices of fundi and crests; an open curve with sulci has one gyrus more, a curve without
    sulci has no gyri.  depths: fundus below the mean of the crests beside it, m, one per sulcus.
    hull_depths: distance of the fundus to the side of the convex hull that bridges it, m, the sulcal depth
    of surface-based morphometry.  widths: distance across a gyrus half way down its two walls, m, one per
    gyrus with two walls.  heights: fold height (n,) at all points, m.
    prominence, smoothing: the least depth and the length of averaging, m, that these folds passed.
    """

    sulci: Integers
    gyri: Integers
    depths: Array
    hull_depths: Array
    widths: Array
    heights: Array
    prominence: float
    smoothing: float

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

    On an `InnerWall` the hull is where the sulci end, and the height is the hull depth.

    Hull depth: distance to the side of the convex hull that bridges the fold; for a pial surface, of the
    way from its first point round the hull to its last.
    """
    return _height(as_polyline(points, closed), reference)


def find_folds(
    points: Any,
    *,
    thickness: float | None = None,
    prominence: float | None = None,
    smoothing: float | None = None,
    reference: Any = None,
    closed: bool | None = None,
) -> Folds:
    """Return the folds of a curve (2, n) that are deep and long enough to count.

    prominence: least depth of a sulcus, m; by default 0.2 of the cortical thickness, or 0.0125 of the body's
    radius where no `thickness`, m, is given, and at least a voxel where the points are traced round voxels.
    smoothing: standard deviation of the average along the arc, m, 0 for none; by default 0.25 of the
    thickness, or 1/60 of the radius.  Positions and depths are those of the curve as given.
    reference (2, m): outline that heights are measured from, such as that of `morphological_closing`.
    Raises ValueError for a prominence that is not positive, a thickness in another unit than the points, and
    points that are no curve.
    """
    curve = as_polyline(points, closed)
    by_radius = thickness is None
    scale = curve.radius if thickness is None else curve.checked_thickness(thickness)
    if prominence is None:
        voxel = min(curve.voxel, COARSEST * curve.radius)
        prominence = max(PROMINENCE[by_radius] * scale, voxel)
    least = positive("prominence", prominence)
    width = SMOOTHING[by_radius] * scale if smoothing is None else smoothing
    smoothing = between("smoothing", width, 0.0, curve.radius)
    heights = _height(curve, reference)
    smooth = heights if smoothing == 0 else _height(curve.smoothed(smoothing), reference)
    walk, along = _walk(curve, smooth)
    h = heights[walk]
    fundi = _fundi(smooth[walk][:along], least if smoothing == 0 else least / 2)
    crests, floors = _turns(curve, h, fundi)
    while fundi and (shallow := _shallow(curve, h, crests, floors, least)) is not None:
        del fundi[shallow]
        crests, floors = _turns(curve, h, fundi)
    turns = _round(curve, crests)
    sides = list(zip(pairwise(turns), floors, strict=True))
    tops = zip(pairwise(_bounds(curve, fundi)), crests, strict=True) if fundi else ()
    slack = PLATEAU * least
    sulci = walk[np.array([_middle(h, a, b, floor, slack) for (a, b), floor in sides], dtype=np.int64)]
    gyri = walk[np.array([_middle(h, a, b, crest, slack) for (a, b), crest in tops], dtype=np.int64)]
    return Folds(
        sulci=sulci,
        gyri=gyri,
        depths=np.array([(h[a] + h[b]) / 2 - h[floor] for (a, b), floor in sides]),
        hull_depths=curve.depth[sulci],
        widths=_widths(curve, walk, h, sides) if fundi else np.zeros(0),
        heights=heights,
        prominence=least,
        smoothing=smoothing,
    )


def fold_count(points: Any, **options: Unpack[Options]) -> int:
    """Return the number of sulci of `find_folds`, with its options.

    A convex curve has none, unless a `reference` outline (2, m) says what it undulates about.
    """
    return find_folds(points, **options).count


def sulcal_depth(points: Any, **options: Unpack[Options]) -> float:
    """Return the mean depth, m, of the sulci of `find_folds`, with its options; 0 without sulci."""
    return find_folds(points, **options).depth


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
        return curve.depth if curve.inner else -curve.depth
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


def _bounds(curve: Polyline, fundi: list[int]) -> list[int]:
    """Return the fundi with what ends the stretches between them: the first again, or the curve's ends."""
    return [*fundi, fundi[0] + curve.size] if curve.closed else [0, *fundi, curve.size - 1]


def _round(curve: Polyline, crests: list[int]) -> list[int]:
    return [*crests, crests[0] + curve.size] if curve.closed and crests else crests


def _turns(curve: Polyline, h: Array, fundi: list[int]) -> tuple[list[int], list[int]]:
    """Return the highest points between the fundi and the lowest between those."""
    if not fundi:
        return [], []
    crests = [a + int(np.argmax(h[a : b + 1])) for a, b in pairwise(_bounds(curve, fundi))]
    return crests, [a + int(np.argmin(h[a : b + 1])) for a, b in pairwise(_round(curve, crests))]


def _shallow(curve: Polyline, h: Array, crests: list[int], floors: list[int], least: float) -> int | None:
    """Return the fundus beside the lowest crest, the higher of two, if that crest rises less than `least`."""
    low = h[floors]
    end = [] if curve.closed else [-np.inf]
    before, after = (np.roll(low, 1) if curve.closed else np.append(end, low)), np.append(low, end)
    rise = h[crests] - np.maximum(before, after)
    k = int(np.argmin(rise))
    if rise[k] >= least:
        return None
    floor = k - 1 if before[k] > after[k] else k
    return (floor + 1) % low.size if curve.closed else floor


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
