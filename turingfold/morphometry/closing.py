"""The outer path of a body by morphological closing, the envelope of the gyrification index of the field."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import positive
from .polyline import as_polyline

CLOSING = 3.0, 0.125  # usual radius over the cortical thickness, and over the body's
ARC = 64  # straight pieces that stand for a quarter of a circle


def closing_radius(points: Any, thickness: float | None = None, *, closed: bool | None = None) -> float:
    """Return the usual radius of the disc, m: 3 times the cortical thickness, as 7.5 mm in adult brains.

    Where no thickness, m, is given, 1/8 of the body's radius; never more than that radius.
    """
    curve = as_polyline(points, closed)
    if thickness is None:
        return CLOSING[1] * curve.radius
    return min(CLOSING[0] * curve.checked_thickness(thickness), curve.radius)


def morphological_closing(points: Any, radius: float, *, closed: bool | None = None) -> Array:
    """Return the outline (2, m) of the body after closing by a disc of `radius`, m: dilation, then erosion.

    It bridges sulci narrower than the disc and follows wider hollows, which the convex hull bridges, too.
    Of a pial surface (2, n), the way from end to end without the base. The distance is exact to a hundredth
    of the radius (GEOS). Where the curve crosses itself, its even-odd inside counts.
    Source: the outer surface of Schaer et al. 2008 (IEEE Trans. Med. Imaging 27, 161).
    Raises ValueError for a radius that is not positive or larger than the body's, and for an `InnerWall`.
    """
    import shapely
    from shapely.ops import substring

    curve = as_polyline(points, closed)
    if curve.inner:
        raise ValueError("points are an InnerWall; the closing is that of a body inside its outline.")
    positive("radius", radius, at_most=curve.radius, remedy="a larger disc gives the convex hull")
    body = shapely.make_valid(shapely.Polygon(curve.points.T))
    solid = body.buffer(radius, quad_segs=ARC).buffer(-radius, quad_segs=ARC)
    largest = max(shapely.get_parts(solid), key=lambda part: part.area)
    outline = shapely.LineString(largest.exterior.coords)
    if curve.closed:
        return np.asarray(shapely.get_coordinates(outline).T[:, :-1])
    first, last = sorted(outline.project(shapely.Point(end)) for end in curve.points[:, [0, -1]].T)
    between = shapely.get_coordinates(substring(outline, first, last)).T
    halves = (last, outline.length), (0.0, first)
    end, start = (shapely.get_coordinates(substring(outline, *half)).T for half in halves)
    ways = between, np.hstack((end, start[:, 1:]))
    return np.asarray(max(ways, key=lambda way: float(np.hypot(*np.diff(way, axis=1)).sum())))
