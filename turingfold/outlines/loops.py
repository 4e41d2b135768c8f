"""Closed curves as they are given: checked, sampled along smooth lines, and found again from any point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from shapely import Polygon

from ..arrays import Array
from ..checks import finite_array, real_array
from .line import FINER, line
from .region import nearest, segments
from .relations import crossings

FEWEST = 8  # different points that make an outline
RING = 3  # different points that enclose something: so many do for one of several curves
MERGE = 1e-9  # points closer than this share of the extent are one point
UNEVEN = 2.0  # times as long as a segment beside it, a segment gets points
TANGLED = 20, 0.1  # times, and times per point, that a curve crosses itself if its points are in order
GAP = 5.0  # a curve is open if its ends are farther apart than this many times its longest other segment


def closed_loops(name: str, given: Any) -> list[Array]:
    """Return closed curves, each (2, n), counter-clockwise, without repeated points.

    given: one curve, (2, n) or (n, 2), or several in a list.
    Raises ValueError for other shapes, values that are not finite, open curves (ends farther apart than 5
    times the longest other segment), points that are not in order, and fewer than 8 different points, or 3 of
    one of several curves.
    """
    several = isinstance(given, (list, tuple)) and len(given) > 0 and all(np.ndim(one) == 2 for one in given)
    curves = given if several else [given]
    fewest = RING if len(curves) > 1 else FEWEST
    return [_closed(f"{name}[{k}]" if several else name, curve, fewest) for k, curve in enumerate(curves)]


def _closed(name: str, points: Any, fewest: int) -> Array:
    curve = real_array(name, points)
    if curve.ndim != 2 or 2 not in curve.shape:
        raise ValueError(f"{name} has shape {curve.shape}; it must be (2, n) or (n, 2).")
    curve = curve if curve.shape[0] == 2 else curve.T
    if not np.isfinite(curve).all():
        k = int(np.flatnonzero(~np.isfinite(curve).all(axis=0))[0])
        raise ValueError(f"point {k} of {name} is {shown(curve[:, k])}; every coordinate must be finite.")
    extent = float(np.ptp(curve, axis=1).max())
    curve = curve[:, np.hypot(*(curve - np.roll(curve, 1, axis=1))) > MERGE * extent]
    count = len(np.unique(np.round(curve / (MERGE * extent)), axis=1).T) if extent > 0 else 1
    if count < fewest:
        raise ValueError(f"{name} has {count} different points; give at least {fewest} along the outline.")
    length, ends = np.hypot(*np.diff(curve, axis=1)), curve[:, [0, -1]]
    if (gap := float(np.hypot(*(ends[:, 1] - ends[:, 0])))) > GAP * length.max():
        raise ValueError(
            f"{name} is an open curve: its ends {shown(ends[:, 0])} and {shown(ends[:, 1])} are {gap:.3g} "
            f"apart, its longest segment is {length.max():.3g}. Add the missing part, e.g. along the base."
        )
    _refuse_tangled(name, curve)
    x, y = curve
    return np.array(curve if x @ np.roll(y, -1) > y @ np.roll(x, -1) else curve[:, ::-1])


def _refuse_tangled(name: str, curve: Array) -> None:
    most = max(TANGLED[0], int(TANGLED[1] * curve.shape[1]))
    if not Polygon(curve.T).is_valid and (count := crossings(curve, most)) > most:
        raise ValueError(
            f"{name} crosses itself {count} times or more: the points are not in order. Give them as they "
            f"follow each other along the outline; up to {most} crossings are taken apart."
        )


def large_enough(
    name: str, loops: list[Array], least: tuple[float, float, float], notes: list[str]
) -> list[Array]:
    """Return the loops at least size/2 and 1.5 voxels wide or high; a note on the others is added to `notes`.

    least: size and voxel, m, and what the curves lack of the area of their voxels, m².
    Raises ValueError if all are smaller.
    """
    size, voxel, lacking = least
    limit, what = max((0.5 * size, "half an element"), (1.5 * voxel, "1.5 voxels"))
    widths = [float(np.ptp(loop, axis=1).max()) for loop in loops]
    if widths and max(widths) < limit:
        raise ValueError(
            f"{name} encloses nothing as large as an element: its largest curve is {max(widths):.3g} m wide; "
            f"use smaller elements (size={size:.3g} m), and the same unit for all curves."
        )
    small = [k for k, width in enumerate(widths) if width < limit]
    if small:
        area = sum(Polygon(loops[k].T).area + lacking for k in small)
        notes.append(f"{len(small)} curves of {name} smaller than {what} left out, {area:.2g} m²")
    return [loop for k, loop in enumerate(loops) if k not in small]


def placed_bases(loops: list[Array], base_ends: Any, size: float) -> list[tuple[int, int, int]]:
    """Return each base as (loop, its first point, its last point); it runs counter-clockwise along the loop.

    base_ends: two points, (2, 2), or such a pair for each base, (n, 2, 2).
    Raises ValueError for ends farther than `size` from every loop, or nearest to one and the same point.
    """
    if base_ends is None:
        return []
    pairs = finite_array("base_ends", np.reshape(base_ends, (-1, 2, 2)), (None, 2, 2))
    everything = shapely.MultiLineString([shapely.LinearRing(loop.T) for loop in loops])
    bases = []
    for pair in pairs:
        for end in pair:
            way = shapely.shortest_line(everything, shapely.points(end))
            if way.length > size:
                raise ValueError(
                    f"base_ends: {shown(end)} m is {way.length:.3g} m from the outline, more than size="
                    f"{size:g} m; its nearest point is {shown(np.array(way.coords[0]))} m. Give points on "
                    "the outline, in its unit."
                )
        k = int(np.argmin([np.hypot(*(loop - pair[0][:, None])).min() for loop in loops]))
        first, last = (int(np.argmin(np.hypot(*(loops[k] - end[:, None])))) for end in pair)
        if first == last:
            raise ValueError(
                f"base_ends {pair.tolist()} are nearest to the same point of the outline, "
                f"{shown(loops[k][:, first])}; give two ends that are farther apart."
            )
        bases.append((k, first, last))
    return bases


@dataclass(frozen=True, eq=False)
class Trace:
    """Closed curves sampled along smooth lines: as polygons, and so finely that chords are the curve.

    polygons, fine: (2, n) each.  bases: straight parts that are not pial, (2, n) each.
    """

    polygons: list[Array]
    fine: list[Array]
    bases: list[Array]

    @cached_property
    def _segments(self) -> shapely.STRtree:
        return segments(self.fine)

    def feet(self, at: Array) -> Array:
        """Return the nearest points of the smooth lines to points (2, n), (2, n)."""
        return nearest(at, self._segments)


def traced(
    loops: list[Array], step: float, smooth: float = 0.0, bases: Sequence[tuple[int, int, int]] = (),
    lacking: float | None = None,
) -> Trace:  # fmt: skip
    """Return loops (2, n) sampled every `step` along the splines through their points; bases stay as given.

    Points within 0.8 steps of the one before are left out. smooth: details shorter than this go.
    lacking: see `line`.
    """
    polygons, fine, bottoms = [], [], []
    for k, loop in enumerate(loops):
        dense, every = [], []
        for part, curved in _parts(loop, [base[1:] for base in bases if base[0] == k]):
            closed = curved and part is loop
            if curved:
                points = line(_evened(part, closed, 0.8 * step), closed, step, smooth, lacking)
            else:
                bottoms.append(points := part)
            dense.append(points if closed else points[:, :-1])
            every.append(dense[-1][:, :: FINER if curved else 1])
        fine.append(np.concatenate(dense, axis=1))
        polygons.append(np.concatenate(every, axis=1))
    return Trace(polygons, fine, bottoms)


def _parts(loop: Array, bases: list[tuple[int, int]]) -> list[tuple[Array, bool]]:
    """Return the parts of a loop in order, each with its last point, and whether it is pial."""
    if not bases:
        return [(loop, True)]
    order = sorted(bases)
    turned, count = np.roll(loop, -order[0][0], axis=1), loop.shape[1]
    turned = np.concatenate([turned, turned[:, :1]], axis=1)
    parts = []
    for k, (first, last) in enumerate(order):
        begin, end = ((i - order[0][0]) % count for i in (first, last))
        onward = (order[k + 1][0] - order[0][0]) if k + 1 < len(order) else count
        if end > onward or end < begin:
            raise ValueError("base_ends: the bases overlap along the outline; give them counter-clockwise.")
        parts += [(turned[:, begin : end + 1], False), (turned[:, end : onward + 1], True)]
    return [(part, curved) for part, curved in parts if part.shape[1] > 1]


def _evened(curve: Array, closed: bool, spacing: float) -> Array:
    """Return the curve without points within `spacing` of the last kept one; open ends stay.

    Long segments are halved until none is over twice as long as one beside it, for a spline would swing out
    along a long segment beside short ones.
    """
    whole = np.concatenate([curve, curve[:, :1]], axis=1) if closed else curve
    points = shapely.get_coordinates(shapely.remove_repeated_points(shapely.LineString(whole.T), spacing)).T
    while True:
        length = np.hypot(*np.diff(points))
        around = np.concatenate([length[-1:], length, length[:1]] if closed else [[np.inf], length, [np.inf]])
        long = np.flatnonzero(length > UNEVEN * np.minimum(around[:-2], around[2:]))
        if not len(long):
            return np.asarray(points[:, :-1] if closed else points)
        points = np.insert(points, long + 1, 0.5 * (points[:, long] + points[:, long + 1]), axis=1)


def shown(point: Array) -> str:
    """Return a point as text."""
    return f"({point[0]:.4g}, {point[1]:.4g})"
