"""A body from any closed outline."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import MeshTri1, MeshTri2

from ..arrays import Array, Integers
from ..checks import between, finite_array, instance, one_of, positive
from ..geometry.body import BASES, Body
from ..geometry.shapes import element_size
from .fill import Frame, Size, fill
from .line import Line, line
from .offset import interface, onto_base, refuse_thick
from .repair import closed_outline, refuse_crossings, thinned

TIGHT = ("refuse", "trim")
BEND = 0.8  # rad, by which an edge of the pial surface turns at most
FINEST = 0.125  # share of the asked element size below which bends do not refine the pial surface
BULGE = 0.1  # largest share of its length by which an edge of the interface is curved
CORNER = 30.0  # degrees by which a base must turn for its vertex to be kept


@dataclass(frozen=True)
class Fine:
    """A disc in which the cortex has smaller elements: `share` of the asked size.

    centre: (x, y), m.  radius: m; beyond it elements grow by the outline's `grading` to the asked size.
    """

    centre: tuple[float, float]
    radius: float
    share: float

    def __post_init__(self) -> None:
        finite_array("centre", self.centre, (2,))
        positive("radius", self.radius)
        positive(
            "share", self.share, at_most=1.0, remedy="it is the part of the asked element size that is left"
        )

    def away(self, at: Array) -> Array:
        """Return the distances of points (2, n) from the disc, 0 inside it, (n,); m."""
        return np.asarray(np.maximum(0.0, np.hypot(*(at - np.array(self.centre)[:, None])) - self.radius))


def outline(
    points: Any,
    *,
    thickness: float,
    size: float | None = None,
    elements: float | None = None,
    base: str = "free",
    layers: str = "sharp",
    base_ends: Any = None,
    smooth: float = 0.0,
    tight: str = "refuse",
    grading: float = 0.35,
    fine: Fine | tuple[Fine, ...] = (),
) -> Body:
    """Return the inside of a closed curve, meshed with its gray-white interface on element edges.

    points: (2, n) or (n, 2) in m, in order. Clockwise curves are turned round, repeated points merged, and
    points closer than a tenth of `size` to the one before left out; see `closed_outline` for what is refused.
    thickness of the cortex, at most two thirds of the largest depth below the pial surface, and size (element
    edge in the cortex) in m; in place of size: elements, their number through the cortex. Below the cortex
    elements grow by `grading` m per m of depth.
    base: "free" (the whole curve may be pial), "clamped" or "roller"; the last two need
    layers: "sharp" or "sigmoid", see `Body`.
    base_ends: two points ((x, y), (x, y)) in m; the base runs counter-clockwise along the outline from the
    point of `points` nearest the first to the one nearest the second, each within `size` of the outline. The
    rest is pial.
    smooth: take away details of the pial surface shorter than this, in m.
    tight: where the thickness exceeds the radius of curvature, or half the distance of opposite sides,
    "refuse" (the message says where) or "trim": the interface, elsewhere the line at the depth `thickness`,
    is rounded there with the radius `size`.
    fine: a disc, or several, of smaller elements in the cortex, as in zones of thinner cortex or more growth.
    Raises ValueError for what cannot be meshed with angles of at least 20 degrees.
    """
    size = element_size(size, elements, thickness)
    _check_options(thickness, size, base, base_ends, smooth, tight, grading)
    discs = tuple(fine) if isinstance(fine, (tuple, list)) else (fine,)
    for disc in discs:
        instance("fine", disc, Fine, "Fine(centre=(0.0, 0.03), radius=0.01, share=0.5)")
    loop = closed_outline(points)
    free, ground = _parts(loop, base_ends, size)
    pial = line(thinned(free, ground is None, 0.1 * size), ground is None, smooth)
    around = pial.at(pial.spaced(0.25 * size))
    if ground is not None:
        around = np.concatenate([around, ground[:, 1:-1]], axis=1)
    refuse_crossings(around, "the outline after smoothing")
    white = interface(pial, thickness, around, size if tight == "trim" else 0.0)
    refuse_thick(pial, thickness, around, ground)
    if ground is not None:
        white = onto_base(white, ground)

    def finest(at: Array) -> Array:
        limits = [disc.share * size + grading * disc.away(at) for disc in discs]
        return np.asarray(np.min([np.full(at.shape[1], np.inf), *limits], axis=0))

    s, edge = _edge_lengths(pial, size, grading, finest)
    tree = cKDTree(pial.at(s).T)

    def wanted(at: Array) -> Array:
        depth, nearest = tree.query(at.T)
        below = grading * np.maximum(0.0, depth - thickness)
        return np.minimum(np.minimum(size, finest(at)) + below, edge[nearest] + grading * depth)

    plan = _planned(pial, ground, white, wanted, _graded(s, edge))
    return Body(_meshed(plan, wanted), thickness, base, layers)


def _check_options(
    thickness: float, size: float, base: str, base_ends: Any, smooth: float, tight: str, grading: float
) -> None:
    positive("thickness", thickness)
    one_of("base", base, BASES)
    one_of("tight", tight, TIGHT)
    between("smooth", smooth, 0.0, float("inf"))
    between("grading", grading, 0.0, 1.0)
    if positive("size", size) > 2 * thickness:
        raise ValueError(
            f"size={size:g} m must be at most twice the thickness {thickness:g} m; use smaller elements."
        )
    if base != "free" and base_ends is None:
        raise ValueError(
            f"base={base!r} needs base_ends=((x, y), (x, y)): where along the outline the base lies."
        )


@dataclass(frozen=True, eq=False)
class _Plan:
    """The frame of the mesh, its number of pial edges, its interface edges, and middles of curved edges."""

    frame: Frame
    pial: int
    white: Integers
    middles: dict[tuple[int, int], Array]


def _parts(loop: Array, base_ends: Any, size: float) -> tuple[Array, Array | None]:
    """Return the pial points, and the base from the end of the pial surface to its start if there is one."""
    if base_ends is None:
        return loop, None
    ends = finite_array("base_ends", base_ends, (2, 2))
    for x, y in ends:
        distance, (near, level) = _nearest(loop, np.array([x, y]))
        if distance > size:
            raise ValueError(
                f"base_ends: ({x:.4g}, {y:.4g}) m is {distance:.3g} m from the outline, more than size="
                f"{size:g} m; its nearest point is ({near:.4g}, {level:.4g}) m. Give points on the outline, "
                "in its unit."
            )
    first, last = (int(np.argmin(np.hypot(*(loop - end[:, None])))) for end in ends)
    if first == last:
        raise ValueError(
            f"base_ends {ends.tolist()} are nearest to the same point of the outline, ({loop[0, first]:.4g}, "
            f"{loop[1, first]:.4g}); give two ends that are farther apart."
        )
    turned = np.roll(loop, -first, axis=1)
    count = (last - first) % loop.shape[1]
    return np.concatenate([turned[:, count:], turned[:, :1]], axis=1), turned[:, : count + 1]


def _nearest(loop: Array, point: Array) -> tuple[float, Array]:
    """Return the distance of a point (2,) from a closed polygon (2, n), and the nearest point of it."""
    closed = np.concatenate([loop, loop[:, :1]], axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=1)))])
    at = _along(closed, arc, point)
    foot = np.array([np.interp(at, arc, x) for x in closed])
    return float(np.hypot(*(point - foot))), foot


def _edge_lengths(pial: Line, size: float, grading: float, finest: Size) -> tuple[Array, Array]:
    """Return arc lengths along the pial surface, and the edge length there: less where it bends sharply."""
    s = np.linspace(0.0, pial.length, max(64, round(10 * pial.length / size)) + 1)
    radius = 1.0 / np.maximum(np.abs(pial.curvature(s)), BEND / (10 * size))
    edge = np.minimum(np.clip(BEND * radius, FINEST * size, size), finest(pial.at(s)))
    # away from bends it grows by `grading` at most; a closed curve goes round three times
    laps = 3 if pial.closed else 1
    along = np.concatenate([s + lap * pial.length for lap in range(laps)])
    slope, edge = grading * along, np.tile(edge, laps)
    edge = np.minimum(edge, slope + np.minimum.accumulate(edge - slope))
    edge = np.minimum(edge, np.minimum.accumulate((edge + slope)[::-1])[::-1] - slope)
    return s, edge[len(s) : 2 * len(s)] if pial.closed else edge


def _graded(s: Array, edge: Array, fewest: int = 6) -> Array:
    """Return places from the first to the last of s whose distances are about the edge lengths there."""
    steps = 0.5 * (1 / edge[1:] + 1 / edge[:-1]) * np.diff(s)
    number = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(fewest, round(number[-1]))
    return np.interp(np.linspace(0.0, number[-1], count + 1), number, s)


def _planned(pial: Line, ground: Array | None, line_within: Array, wanted: Size, places: Array) -> _Plan:
    """Put nodes on pial surface (at `places`), base and interface."""
    s = places[:-1] if pial.closed else places
    half_way = 0.5 * (places[1:] + places[:-1])
    white, white_middles = _spread(line_within, wanted)
    surface, boundary = pial.at(s), len(s)
    if ground is None:
        ids = boundary + np.arange(white.shape[1])
    else:
        below, (late, early) = _base_points(ground, (white[:, -1], white[:, 0]), wanted)
        surface[:, 0], surface[:, -1] = ground[:, -1], ground[:, 0]
        surface = np.concatenate([surface, below[:, 1:-1]], axis=1)
        boundary += below.shape[1] - 2
        between_ends = boundary + np.arange(white.shape[1] - 2)
        ids = np.concatenate([[len(s) - 1 + early], between_ends, [len(s) - 1 + late]])
        white = white[:, 1:-1]
    around = np.arange(boundary)
    edges = np.stack([around, np.roll(around, -1)])
    inside = np.stack([ids, np.roll(ids, -1)])[:, : white_middles.shape[1]]
    middles = _named(edges[:, : len(half_way)], pial.at(half_way)) | _named(inside, white_middles)
    frame = Frame(np.concatenate([surface, white], axis=1), boundary, np.concatenate([edges, inside], axis=1))
    return _Plan(frame, len(half_way), inside, middles)


def _named(edges: Integers, middles: Array) -> dict[tuple[int, int], Array]:
    return {(min(a, b), max(a, b)): m for (a, b), m in zip(edges.T.tolist(), middles.T, strict=True)}


def _spread(white: Array, wanted: Size) -> tuple[Array, Array]:
    """Return vertices spaced as wanted along a fine polyline, and the points half way between them.

    A line that ends where it begins has as many middles as vertices, an open one has one less.
    """
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(white, axis=1)))])
    places = _graded(arc, wanted(white))
    places = np.interp(np.arange(2 * len(places) - 1) / 2, np.arange(len(places)), places)
    nodes = np.stack([np.interp(places, arc, x) for x in white])
    straight = 0.5 * (nodes[:, :-1:2] + nodes[:, 2::2])
    bulge, edge = np.hypot(*(nodes[:, 1::2] - straight)), np.hypot(*(nodes[:, 2::2] - nodes[:, :-1:2]))
    # at a kink of the interface a curved edge would fold its triangles
    middles = np.where(bulge < BULGE * edge, nodes[:, 1::2], straight)
    closes = np.array_equal(white[:, -1], white[:, 0])
    return nodes[:, :-1:2] if closes else nodes[:, ::2], middles


def _base_points(ground: Array, stops: tuple[Array, Array], wanted: Size) -> tuple[Array, list[int]]:
    """Return graded base vertices with corners and the two stops among them, and the places of the stops."""
    step = np.diff(ground, axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*step))])
    turn = np.degrees(np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(step[1], step[0]))))))
    at_stops = [_along(ground, arc, stop) for stop in stops]
    breaks = np.unique(np.concatenate([[0.0, arc[-1]], arc[1:-1][turn > CORNER], at_stops]))
    places = [breaks[:1]]
    for low, high in pairwise(breaks):
        fine = np.linspace(low, high, 200)
        edge = wanted(np.stack([np.interp(fine, arc, x) for x in ground]))
        places.append(_graded(fine, edge, fewest=1)[1:])
    s = np.concatenate(places)
    found = [int(np.argmin(np.abs(s - stop))) for stop in at_stops]
    return np.stack([np.interp(s, arc, x) for x in ground]), found


def _along(ground: Array, arc: Array, point: Array) -> float:
    """Return the arc length of a point on a polyline."""
    start, step = ground[:, :-1], np.diff(ground, axis=1)
    share = np.clip(((point[:, None] - start) * step).sum(0) / (step**2).sum(0), 0.0, 1.0)
    k = int(np.argmin(np.hypot(*(start + share * step - point[:, None]))))
    return float(arc[k] + share[k] * (arc[k + 1] - arc[k]))


def _meshed(plan: _Plan, wanted: Size) -> MeshTri2:
    points, triangles = fill(plan.frame, wanted)
    straight = MeshTri1(
        np.ascontiguousarray(points), np.ascontiguousarray(triangles), sort_t=False, validate=False
    )
    mesh = MeshTri2.from_mesh(straight)
    facet = {(int(p), int(q)): k for k, (p, q) in enumerate(straight.facets.T)}
    placed = mesh.doflocs.copy()
    for edge, middle in plan.middles.items():
        placed[:, points.shape[1] + facet[edge]] = middle

    def facets(edges: Integers) -> Integers:
        return np.array([facet[min(a, b), max(a, b)] for a, b in edges.T.tolist()], dtype=np.int64)

    around = facets(plan.frame.edges[:, : plan.frame.boundary])
    named = {"pial": around[: plan.pial], "base": around[plan.pial :]}
    cortex = _beside(straight, named["pial"], facets(plan.white))
    return MeshTri2(
        placed,
        mesh.t,
        _boundaries={name: part for name, part in named.items() if len(part)},
        _subdomains={"cortex": cortex},
        validate=False,
    )


def _beside(mesh: MeshTri1, pial: Integers, white: Integers) -> Integers:
    """Return the triangles that can be reached from the pial edges without crossing the interface."""
    crossed = np.setdiff1d(np.flatnonzero(mesh.f2t[1] >= 0), white)
    one, other = mesh.f2t[:, crossed]
    links = coo_matrix((np.ones(len(one)), (one, other)), shape=(mesh.nelements, mesh.nelements))
    _, part = connected_components(links, directed=False)
    return np.flatnonzero(np.isin(part, part[mesh.f2t[0, pial]]))
