"""Areas of polygons, and which points they enclose."""

import shapely


def area(loop):
    """Return the signed area inside a closed polygon (2, n); positive if counter-clockwise."""
    ring = shapely.LinearRing(loop.T)
    return shapely.Polygon(ring).area * (1 if ring.is_ccw else -1)


def inside(points, loop):
    """Return whether each point (2, n) lies inside the closed polygon (2, m)."""
    return shapely.contains_xy(shapely.Polygon(loop.T), *points)
