"""Planar sets of tissue, by shapely: real contours made fit for elements of a given size."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from ..arrays import Array, Booleans

SLIVER = 1e-3  # share of the size below which a gap is round-off
THIN = 0.02  # share of the size below which what rounding takes away is no bridge
CLEFT = 1.0  # of the size: shorter gaps between walls are filled, longer ones opened
ARC, ROUND = 32, 8  # points on a quarter of a circle: around the depth of the cortex, in rounded corners


def pieces(area: BaseGeometry) -> list[Polygon]:
    """Return the polygons of a set, without the lines and points that repairs leave."""
    return [
        one for one in shapely.get_parts(shapely.get_parts(area)) if isinstance(one, Polygon) and one.area
    ]


def hollows(area: BaseGeometry) -> list[Polygon]:
    """Return what the holes of a set enclose."""
    return [Polygon(hole) for one in pieces(area) for hole in one.interiors]


def enclosed(loop: Array) -> MultiPolygon:
    """Return the points that lie inside an odd number of turns of a closed curve (2, n)."""
    return MultiPolygon(pieces(shapely.make_valid(Polygon(loop.T))))


def even_odd(loops: Sequence[Array]) -> BaseGeometry:
    """Return the points that lie inside an odd number of turns of closed curves (2, n)."""
    return reduce(shapely.symmetric_difference, map(enclosed, loops))


def rings(area: BaseGeometry) -> list[Array]:
    """Return all rings of a set, counter-clockwise, (2, n) with the first point repeated."""
    found = [ring for one in pieces(area) for ring in (one.exterior, *one.interiors)]
    return [shapely.get_coordinates(ring if ring.is_ccw else ring.reverse()).T for ring in found]


def along(points: Array) -> Array:
    """Return the length of a polyline (2, n) up to each of its points, (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=1)))])


def segments(loops: Sequence[Array]) -> shapely.STRtree:
    """Return the segments of closed curves (2, n), for `nearest`."""
    ends = [np.stack([loop, np.roll(loop, -1, axis=1)], axis=-1) for loop in loops]
    return shapely.STRtree(shapely.linestrings(np.concatenate(ends, axis=1).transpose(1, 2, 0)))


def nearest(points: Array, curves: shapely.STRtree) -> Array:
    """Return the place on curves, as `segments` makes them, nearest to each point, both (2, n)."""
    given = shapely.points(points.T)
    near = curves.geometries[curves.nearest(given)]
    return np.asarray(shapely.get_coordinates(shapely.shortest_line(given, near))[1::2].T, dtype=float)


def opened(area: BaseGeometry, radius: float) -> BaseGeometry:
    """Return the union of the discs of a radius that lie inside."""
    return area.buffer(-radius, quad_segs=ROUND).buffer(radius, quad_segs=ROUND)


def closed(area: BaseGeometry, radius: float) -> BaseGeometry:
    """Return the complement of the union of the discs that lie outside."""
    return area.buffer(radius, quad_segs=ROUND).buffer(-radius, quad_segs=ROUND)


def smoothed(area: BaseGeometry, size: float, gap: float) -> BaseGeometry:
    """Return a set whose parts are at least about size/2 thick, with gaps of at least `gap` between them.

    Thin parts go, short gaps are filled; where that would leave a thin bridge the gap is made wider instead.
    """
    thick = closed(opened(area, 0.25 * size), 0.5 * gap).simplify(SLIVER * size)
    thin = thick.difference(opened(thick, 0.22 * size)).buffer(-THIN * size)
    return opened(thick.difference(thin.buffer(gap + THIN * size)), 0.2 * size) if pieces(thin) else thick


def touching(area: BaseGeometry, inset: float, least: float) -> BaseGeometry:
    """Return the gaps of a set with walls nearer to each other than 2·inset, and not than 2·least."""
    return closed(area, inset).difference(area).buffer(-least)


def large(area: BaseGeometry, least: float) -> MultiPolygon:
    """Return the set without pieces smaller, and with holes filled that are smaller than an area."""
    kept = [one for one in pieces(area) if one.area >= least]
    return MultiPolygon(
        [Polygon(one.exterior, [h for h in one.interiors if Polygon(h).area >= least]) for one in kept]
    )


def fitted(area: BaseGeometry, size: float, inset: float, bases: BaseGeometry) -> MultiPolygon:
    """Return tissue that elements of a size can fill, changed only where it must be.

    Walls nearer than 2·inset to each other are moved apart, by inset each, where they run side by side for
    more than `size`; shorter gaps are filled. Tissue thinner than size/2 is taken away, corners are rounded,
    pieces and holes below size² are left out. Within 0.75 size of `bases` (lines) nothing changes.
    """
    tissue = large(area.simplify(SLIVER * size), SLIVER * size**2)
    clefts = []
    for gap in pieces(touching(tissue, inset, SLIVER * size)):
        x0, y0, x1, y1 = gap.bounds
        if np.hypot(x1 - x0, y1 - y0) > CLEFT * size:
            clefts.append(gap.buffer(inset + SLIVER * size))
    if clefts:
        tissue = tissue.difference(shapely.union_all(clefts))
    tissue = smoothed(tissue, size, min(0.25 * size, inset))
    return large(unchanged_near(bases, tissue, area, size), size**2)


def unchanged_near(
    bases: BaseGeometry, changed: BaseGeometry, given: BaseGeometry, size: float
) -> BaseGeometry:
    """Return a changed set, but as it was given within 0.75 size of the bases (lines) that it touches.

    Both parts overlap a little, or rounding would leave slits along the line where they meet.
    """
    touched = bases.intersection(given.buffer(SLIVER * size))
    if touched.is_empty:
        return changed
    near = touched.buffer(0.75 * size)
    return changed.difference(near).union(given.intersection(near.buffer(SLIVER * size)))


def below(area: BaseGeometry, pial: BaseGeometry, depth: float) -> BaseGeometry:
    """Return what lies at least a depth below the pial lines of a boundary."""
    if pial.equals(area.boundary):
        return area.buffer(-depth, quad_segs=ARC)
    return area.difference(pial.buffer(depth, quad_segs=ARC))


def tapered(points: Array, thickness: Array) -> BaseGeometry:
    """Return what lies within its own thickness (n,) of each point (2, n) of a polyline, and between them."""
    discs = shapely.buffer(shapely.points(points.T), thickness, quad_segs=12)
    pairs = shapely.geometrycollections(np.stack([discs[:-1], discs[1:]], axis=1))
    return shapely.union_all(shapely.convex_hull(pairs))


def moved(points: Array, area: BaseGeometry, walls: BaseGeometry, near: float) -> tuple[float, float]:
    """Return the largest distance of points (2, n) from the boundary of a set.

    First of points farther than `near` from `walls`, then of the others; 0 where there are none.
    """
    distance = np.hypot(*(points - nearest(points, segments([ring[:, :-1] for ring in rings(area)]))))
    shapely.prepare(walls)
    beside = shapely.dwithin(walls, shapely.points(points.T), near)
    return float(distance[~beside].max(initial=0.0)), float(distance[beside].max(initial=0.0))


def buried(points: Array, area: BaseGeometry, depth: float) -> Booleans:
    """Return which points (2, n) lie inside a set, farther than a depth from its boundary."""
    core = area.buffer(-depth)
    shapely.prepare(core)
    return np.asarray(shapely.contains_xy(core, *points))
