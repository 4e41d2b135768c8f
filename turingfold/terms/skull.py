"""A skull is checked before it confines a body: it goes round the whole pial surface and crosses nothing."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..geometry.polygon import enclosed, intersections


def check_skull(body: Body, skull: Array) -> None:
    """Raise ValueError for a skull, points (2, n) in m, that crosses a body or leaves out some of its pial
    surface.

    Around a pial surface that is closed the skull must be closed too. An open one lies between the skull, the
    straight ways from the skull's ends to its own, and the rest of the body's boundary.
    """
    wall = np.stack([skull[:, :-1], skull[:, 1:]])
    sides = _sides(body, np.asarray(body.mesh.boundary_facets()))
    i, _, share, _ = intersections(wall, sides)
    if len(i):
        met = wall[0, :, i[0]] + share[0] * (wall[1, :, i[0]] - wall[0, :, i[0]])
        raise ValueError(
            f"skull crosses the body near {_shown(met)} m, between its points {i[0]} and {i[0] + 1}; "
            "a skull goes round the body at a distance."
        )
    first, last = skull[:, 0], skull[:, -1]
    surface = body.nodes[:, body.pial]
    if np.hypot(*(last - first)) > 1e-9 * body.length:
        if body.pial_curve.closed:
            raise ValueError(
                f"skull ends at {_shown(last)} m, not where it begins, at {_shown(first)} m; around a closed "
                "pial surface it must be closed: repeat its first point at the end."
            )
        wall = np.concatenate([wall, _links(skull, surface[:, 0], surface[:, -1]), _ground(body)], axis=2)
        surface = surface[:, 1:-1]
    outside = np.flatnonzero(~enclosed(surface, wall))
    if len(outside):
        raise ValueError(
            f"skull does not go round the body: the point {_shown(surface[:, outside[0]])} m of the pial "
            f"surface lies outside it, and {len(outside) - 1} others; give a curve around the whole surface."
        )


def check_clear(skull: Array, lines: Array, distance: float) -> None:
    """Raise ValueError for a skull, (2, n) in m, that meets or comes within `distance` of lines (2, 2, m).

    lines: start and end points of those on which base and mirror continue.
    """
    wall = np.stack([skull[:, :-1], skull[:, 1:]])
    met = [skull[:, i] for i in np.unique(intersections(wall, lines)[0])]
    for start, end in lines.transpose(2, 0, 1):
        along = (end - start) / np.hypot(*(end - start))
        way = skull - start[:, None]
        foot = np.clip(along @ way, 0.0, np.hypot(*(end - start)))
        met += [*skull[:, np.hypot(*(way - foot * along[:, None])) < distance].T]
    if met:
        raise ValueError(
            f"skull reaches, near {_shown(met[0])} m, the line on which the body's base (or mirror) "
            f"continues outward; its ends have to stay clear of that line by more than {distance:.3g} m: "
            "leave out its points there."
        )


def _sides(body: Body, facets: Array) -> Array:
    """Return the two straight halves of quadratic edges as segments, (2, 2, 2 n_facets)."""
    (start, end), middle = body.mesh.facets[:, facets], body.mesh.nvertices + facets
    ends = np.stack([np.concatenate([start, middle]), np.concatenate([middle, end])])
    return np.ascontiguousarray(body.nodes[:, ends].swapaxes(0, 1))


def _ground(body: Body) -> Array:
    """Return the boundary that is not pial, such as base and mirror, as segments."""
    return _sides(body, np.setdiff1d(body.mesh.boundary_facets(), body.mesh.boundaries["pial"]))


def _links(skull: Array, start: Array, end: Array) -> Array:
    """Return the segments from the skull's ends to those of the pial surface, whichever way is shorter."""
    ways = [np.stack([skull[:, [0, -1]], np.stack(ends, axis=1)]) for ends in ((start, end), (end, start))]
    return min(ways, key=lambda way: float(np.hypot(*(way[1] - way[0])).sum()))


def _shown(point: Array) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g})"
