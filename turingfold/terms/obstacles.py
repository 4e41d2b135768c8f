"""Fixed curves that a body cannot pass: the lines on which its base and mirror continue, and a skull."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Integers
from ..geometry.body import Body
from .boundary import boundary_edges

EXTENSION = 8.0  # a line goes on for so many body lengths, or until it meets the body
LEAST = 3.0  # clearances; lines shorter than this are left out


@dataclass(frozen=True)
class Obstacle:
    """A fixed curve: what it is, its points (2, n) in m, and the node of the body that it starts from."""

    name: str
    points: Array
    start: int | None = None


def obstacles(
    body: Body, clearance: float, base_line: bool, skull: ArrayLike | None, share: float
) -> list[Obstacle]:
    """Return the lines that go on from the body's ends, and the skull; ValueError for a bad skull.

    clearance: the shortest distance between neighbouring boundary nodes, m.  share: of it, that the skull's
    ends keep from the lines.
    """
    lines = continued(body, clearance, base_line)
    if skull is None:
        return lines
    from .skull import check_clear, check_skull

    points = np.asarray(skull, dtype=float)
    check_skull(body, points)
    ways = np.array([line.points[:, [0, -1]] for line in lines]).reshape(-1, 2, 2).transpose(2, 1, 0)
    check_clear(points, ways, share * clearance)
    return [*lines, Obstacle("skull", points)]


def continued(body: Body, clearance: float, base_line: bool) -> list[Obstacle]:
    """Return the lines on which mirror and, if wanted, base continue beyond the ends of the pial surface.

    A line ends `clearance`, m, before it comes as near as that to the body.
    """
    boundary = np.unique(boundary_edges(body))
    found = []
    for name, end, outward in _outward(body):
        if name == "base" and not base_line:
            continue
        way = body.nodes[:, boundary] - body.nodes[:, end, None]
        along, aside = outward @ way, np.abs(outward[0] * way[1] - outward[1] * way[0])
        met = along[(along > LEAST * clearance) & (aside < 2 * clearance)]
        length = min(EXTENSION * body.length, met.min(initial=np.inf) - clearance)
        if length > LEAST * clearance:
            way = outward[:, None] * np.array([0.0, length])
            found.append(Obstacle(name, body.nodes[:, end, None] + way, end))
    return found


def joined(obstacles: list[Obstacle], nodes: Integers) -> tuple[Array, Integers, list[str]]:
    """Return points (n, 2) of obstacles, numbered after `nodes` of the body, their edges (3, m) and names.

    nodes: those on the body's boundary, in increasing order.
    """
    points: list[Array] = []
    edges: list[tuple[int, int, int]] = []
    names: list[str] = []
    for obstacle in obstacles:
        path = obstacle.points.T
        own = path if obstacle.start is None else path[1:]
        first = len(nodes) + len(points)
        line = [*range(first, first + len(own))]
        if obstacle.start is not None:
            line.insert(0, int(np.searchsorted(nodes, obstacle.start)))
        middles = first + len(own) + np.arange(len(line) - 1)
        points += [*own, *(0.5 * (path[:-1] + path[1:]))]
        edges += zip(line[:-1], middles.tolist(), line[1:], strict=True)
        names += [obstacle.name] * len(middles)
    return np.array(points).reshape(-1, 2), np.array(edges, dtype=np.int64).reshape(-1, 3).T, names


def _outward(body: Body) -> Iterator[tuple[str, int, Array]]:
    """Yield each end of the pial surface on a straight base or mirror, and the way onward from there."""
    ends = [n for path in body.pial_paths if not path.closed for n in path.nodes[[0, -1]].tolist()]
    for name in ("base", "mirror"):
        if name not in body.mesh.boundaries or (name == "base" and body.base == "free"):
            continue
        for path in body.boundary_paths(name):
            for end, neighbour in (path.nodes[:2], path.nodes[:-3:-1]):
                if end in ends:
                    onward = body.nodes[:, end] - body.nodes[:, neighbour]
                    yield name, int(end), onward / np.hypot(*onward)
