"""Nodes along the lines that a mesh must keep: pial surface, interface, base and holes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from ..arrays import Array, Booleans, Integers
from .region import along

Size = Callable[[Array], Array]  # points (2, n) -> edge length (n,)
Put = Callable[[Array], Array]  # points (2, n) near a smooth line -> points on it

BEND = 0.8  # rad, by which an edge of a curved line turns at most
BEND_OF_HOLES = 0.4  # rad: elements around them are large; at 0.8 a round hole lacks 8e-4 of its area
ROUND = 10  # edges of a closed line at least: of fewer, those of a circle bulge too much to be curved
FINEST = 0.3  # share of the asked element size below which bends do not refine a line
RESOLUTION = 2.0**-24  # of the extent: smaller differences are round-off
CORNER = 30.0  # degrees by which a base must turn for its vertex to be kept


@dataclass(frozen=True, eq=False)
class Side:
    """A polyline of the frame, (2, n), what it is, and the arc lengths of the nodes on it."""

    kind: str
    line: Array
    places: Array
    put: Put

    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
        return bool((self.line[:, 0] == self.line[:, -1]).all())

    @cached_property
    def arc(self) -> Array:
        """Arc length at the points, (n,)."""
        return along(self.line)

    def at(self, s: Array) -> Array:
        """Return the points at arc lengths, (2, m)."""
        return np.stack([np.interp(s, self.arc, x) for x in self.line])

    @cached_property
    def nodes(self) -> Array:
        """The nodes in order, (2, m); a closed line does not repeat the first one."""
        at = self.put(self.at(self.places))
        at[:, 0], at[:, -1] = self.line[:, 0], self.line[:, -1]  # shared with other lines
        if self.closed:
            at[:, 0] = self.put(self.line[:, :1])[:, 0]
        return at[:, :-1] if self.closed else at

    @cached_property
    def middles(self) -> Array:
        """The points half way between nodes, (2, edges)."""
        return self.put(self.at(0.5 * (self.places[1:] + self.places[:-1])))


def side(kind: str, line: Array, size: Size, put: Put, stops: Array | None = None) -> Side:
    """Return a line with nodes as far apart as `size` asks, closer where it bends.

    stops: arc lengths at which there must be nodes; the corners of a base get some, too.
    """
    made = Side(kind, line, np.zeros(0), put)
    arc, ends = made.arc, [0.0, float(made.arc[-1])]
    step = np.diff(line, axis=1)
    if kind == "base":
        turn = np.degrees(np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(step[1], step[0]))))))
        ends += arc[1:-1][turn > CORNER].tolist()
    breaks = np.unique(np.concatenate([ends, [] if stops is None else stops]))
    places = [breaks[:1]]
    for low, high in pairwise(breaks):
        s, edge = _edge_lengths(made, low, high, size)
        places.append(_graded(s, edge, ROUND if made.closed else 1)[1:])
    return replace(made, places=np.concatenate(places))


def _edge_lengths(made: Side, low: float, high: float, size: Size) -> tuple[Array, Array]:
    """Return arc lengths between two, and the edge length there: less where the line bends sharply."""
    asked = float(size(made.line).min())
    s = np.linspace(low, high, max(16, int(np.ceil(8 * (high - low) / asked))) + 1)
    edge = size(made.at(s))
    if made.kind != "base":
        h = s[1] - s[0]
        ahead, behind = s + 2 * h, s - 2 * h
        if made.closed:
            ahead, behind = ahead % made.arc[-1], behind % made.arc[-1]
        before, here, after = (x + 1j * y for x, y in (made.at(behind), made.at(s), made.at(ahead)))
        steps = (after - here) * np.conj(here - before)  # 0 at open ends
        bend = np.where(steps == 0, 0.0, np.abs(np.angle(steps))) / (2 * h)
        most = BEND_OF_HOLES if made.kind == "hole" else BEND
        edge = np.minimum(edge, np.maximum(most / np.maximum(bend, 1e-12 / h), FINEST * edge))
    grading = 0.35
    laps = 3 if made.closed else 1
    slope = grading * np.concatenate([s + lap * (high - low) for lap in range(laps)])
    edge = np.tile(edge, laps)
    edge = np.minimum(edge, slope + np.minimum.accumulate(edge - slope))
    edge = np.minimum(edge, np.minimum.accumulate((edge + slope)[::-1])[::-1] - slope)
    return s, edge[len(s) : 2 * len(s)] if made.closed else edge


def _graded(s: Array, edge: Array, fewest: int) -> Array:
    """Return places from the first to the last of s whose distances are about the edge lengths there."""
    steps = 0.5 * (1 / edge[1:] + 1 / edge[:-1]) * np.diff(s)
    number = np.concatenate([[0.0], np.cumsum(steps)])
    return np.interp(np.linspace(0.0, number[-1], max(fewest, round(number[-1])) + 1), number, s)


@dataclass(frozen=True, eq=False)
class Frame:
    """What a mesh keeps: `points` (2, n), and `edges` (2, m) of them.

    exact: the points before they were rounded.  kinds: of the edges, (m,).  side, place: of each edge, the
    side it belongs to and its number there.  middles: of the edges, (2, m).
    """

    points: Array
    exact: Array
    kinds: NDArray[np.str_]
    edges: Integers
    side: Integers
    place: Integers
    middles: Array

    @cached_property
    def boundary(self) -> Integers:
        """The edges along the boundary, (2, b)."""
        return np.asarray(self.edges[:, self.kinds != "interface"])

    @cached_property
    def centres(self) -> Array:
        """Of the straight edges, (2, m)."""
        return np.asarray(0.5 * (self.points[:, self.edges[0]] + self.points[:, self.edges[1]]))

    @cached_property
    def lengths(self) -> Array:
        """Of the edges, (m,)."""
        return np.asarray(np.hypot(*(self.points[:, self.edges[0]] - self.points[:, self.edges[1]])))

    @cached_property
    def domain(self) -> BaseGeometry:
        """What the boundary edges enclose, ready to be asked about points."""
        ends = np.moveaxis(self.points[:, self.boundary], 0, -1)  # (2, b, 2)
        area = shapely.build_area(shapely.multilinestrings(shapely.linestrings(ends.swapaxes(0, 1))))
        shapely.prepare(area)
        return area


def frame(sides: list[Side]) -> Frame:
    """Return the nodes and edges of lines; equal nodes become one."""
    starts = np.cumsum([one.nodes.shape[1] for one in sides[:-1]])
    exact = np.concatenate([one.nodes for one in sides], axis=1)
    points, first, local = np.unique(
        np.round(exact / RESOLUTION) * RESOLUTION, axis=1, return_index=True, return_inverse=True
    )
    counts = [len(one.places) - 1 for one in sides]
    edges = [
        np.stack([ids, np.roll(ids, -1)])[:, :count]  # a closed line has as many nodes as edges
        for ids, count in zip(np.split(local.ravel(), starts), counts, strict=True)
    ]
    which, place = np.repeat(np.arange(len(sides)), counts), np.concatenate([np.arange(n) for n in counts])
    middles = np.concatenate([one.middles for one in sides], axis=1)
    kinds = np.array([one.kind for one in sides])[which]
    return Frame(points, exact[:, first], kinds, np.concatenate(edges, axis=1), which, place, middles)


def split(sides: list[Side], found: Frame, edges: Integers) -> list[Side]:
    """Return the lines with nodes half way along some edges of their frame."""
    result = []
    for k, one in enumerate(sides):
        chosen = found.place[edges[found.side[edges] == k]]
        half_way = 0.5 * (one.places[chosen + 1] + one.places[chosen])
        places = np.sort(np.concatenate([one.places, half_way]))
        result.append(replace(one, places=places) if len(chosen) else one)
    return result


def kept(sides: list[Side], shortest: float, rounds: int = 40) -> tuple[list[Side], Frame]:
    """Return the lines with so many nodes that no circle around an edge holds another node.

    Every edge is then one of the Delaunay triangulation. Edges shorter than twice `shortest` stay.
    """
    for _ in range(rounds):
        found = frame(sides)
        hidden = _encroached(found) & (found.lengths > 2 * shortest)
        if not hidden.any():
            break
        sides = split(sides, found, np.flatnonzero(hidden))
    return sides, frame(sides)


def _encroached(found: Frame) -> Booleans:
    edge, point = within(found.centres, found.points, 0.5 * found.lengths * (1 + 1e-9))
    other = (found.edges[:, edge] != point).all(0)
    return np.bincount(edge[other], minlength=len(found.lengths)) > 0


def within(centres: Array, points: Array, radii: Array) -> Integers:
    """Return the pairs (2, p) of circles, with centres (2, n) and radii (n,), and points (2, m) in them."""
    tree = shapely.STRtree(shapely.points(points.T))
    pairs = tree.query(shapely.points(centres.T), predicate="dwithin", distance=radii)
    return np.asarray(pairs[:, np.lexsort(pairs[::-1])])


def missing(found: Frame, triangles: Integers) -> Integers:
    """Return the edges of the frame that no triangle (3, e) has."""
    count = int(triangles.max()) + 1
    sides = np.concatenate([triangles[[0, 1]], triangles[[1, 2]], triangles[[2, 0]]], axis=1)
    present = np.unique(np.sort(sides, axis=0).T @ np.array([count, 1]))
    return np.flatnonzero(~np.isin(np.sort(found.edges, axis=0).T @ np.array([count, 1]), present))
