"""A skull is checked before it confines a body: it goes round the whole pial surface and crosses nothing."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import LineString, Point

from ..arrays import Array
from ..geometry.body import Body


def check_skull(body: Body, skull: Array) -> None:
    """Raise ValueError for a skull, points (2, n) in m, that crosses a body or leaves out some of its pial
    surface.

    Around a pial surface that is closed the skull must be closed too. An open one lies between the skull, the
    straight ways from the skull's ends to its own, and the rest of the body's boundary.
    """
    first, last = skull[:, 0], skull[:, -1]
    closed = np.hypot(*(last - first)) <= 1e-9 * body.length
    wall = LineString([*skull[:, :-1].T, first if closed else last])
    met = wall.intersection(_sides(body, np.asarray(body.mesh.boundary_facets())))
    if not met.is_empty:
        at = shapely.get_coordinates(met)[0]
        steps = np.cumsum(np.hypot(*np.diff(skull, axis=1)))
        k = min(int(np.searchsorted(steps, wall.project(Point(at)))), len(steps) - 1)
        raise ValueError(
            f"skull crosses the body near {_shown(at)} m, between its points {k} and {k + 1}; "
            "a skull goes round the body at a distance."
        )
    surface, ways = np.concatenate([body.nodes[:, path.nodes] for path in body.pial_paths], axis=1), [wall]
    if not closed:
        if any(path.closed for path in body.pial_paths):
            raise ValueError(
                f"skull ends at {_shown(last)} m, not where it begins, at {_shown(first)} m; around a closed "
                "pial surface it must be closed: repeat its first point at the end."
            )
        ground = np.setdiff1d(body.mesh.boundary_facets(), body.mesh.boundaries["pial"])
        ways += [*_links(skull, surface[:, 0], surface[:, -1]), _sides(body, ground)]
        surface = surface[:, 1:-1]
    interior = shapely.union_all(
        shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.union_all(ways))))
    )
    outside = np.flatnonzero(~shapely.contains_xy(interior, *surface))
    if len(outside):
        raise ValueError(
            f"skull does not go round the body: the point {_shown(surface[:, outside[0]])} m of the pial "
            f"surface lies outside it, and {len(outside) - 1} others; give a curve around the whole surface."
        )


def check_clear(skull: Array, lines: Array, distance: float) -> None:
    """Raise ValueError for a skull, (2, n) in m, that meets or comes within `distance` of lines (2, 2, m).

    lines: start and end points of those on which base and mirror continue.
    """
    wall, beyond = (
        LineString(skull.T),
        shapely.multilinestrings(shapely.linestrings(lines.transpose(2, 0, 1))),
    )
    if wall.distance(beyond) < distance:
        close = shapely.distance(shapely.points(skull.T), beyond) < distance
        near = skull[:, np.argmax(close)] if close.any() else shapely.get_coordinates(wall & beyond)[0]
        raise ValueError(
            f"skull reaches, near {_shown(near)} m, the line on which the body's base (or mirror) "
            f"continues outward; its ends have to stay clear of that line by more than {distance:.3g} m: "
            "leave out its points there."
        )


def _sides(body: Body, facets: Array) -> shapely.MultiLineString:
    """Return the two straight halves of quadratic edges as lines."""
    (start, end), middle = body.mesh.facets[:, facets], body.mesh.nvertices + facets
    return shapely.multilinestrings(shapely.linestrings(body.nodes[:, np.stack([start, middle, end])].T))


def _links(skull: Array, start: Array, end: Array) -> list[LineString]:
    """Return the straight ways from the skull's ends to those of the pial surface, the shorter ones."""
    ways = [
        [LineString([a, b]) for a, b in zip(skull[:, [0, -1]].T, ends, strict=True)]
        for ends in ((start, end), (end, start))
    ]
    return min(ways, key=lambda way: sum(line.length for line in way))


def _shown(point: Array) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g})"
