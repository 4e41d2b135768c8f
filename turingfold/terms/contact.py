"""Self-contact of the body's boundary, and with the straight lines on which base or mirror continue.

The barrier and the continuous collision detection are ipctk's (incremental potential contact, Li et al.
2020). They see chords of the quadratic boundary edges, several to an edge and all moved by its three nodes;
walls keep apart by what the chords miss of the curves. Where two edges with a common node fold together, a
barrier on the angle between them does the same, and others keep triangles from turning over. At the two ends
of the pial surface of a clamped, rolling or mirrored body the base (or mirror) line continues outward as an
obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import ipctk
import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Integers
from ..checks import finite_array, positive
from ..geometry.body import Body, by_node
from ..geometry.quadratic import bend
from ..parts import Abrupt, Entries, Fields, Hessian, Operator, Potential, Term, TimeStep
from ..state import State
from .boundary import boundary_edges, counts, crossed_edges, stays_straight, tissue_left
from .creases import creases
from .inversion import bounding, inversion
from .obstacles import joined, obstacles
from .turning import Turning
from .walls import Walls, check_rest

BEND = 0.1  # of its length: how far a boundary edge may bend before its chords miss more than half of APART
APART = 0.05  # of dhat, which chords always keep between them
SOON = 3.0  # shortest distances between nodes: edges this close get places in the matrix
FEWEST, MOST = 4, 32  # chords of an edge
MISSED = 1.0  # times what chords keep apart: they miss a bent edge by no more before it is made of more
RECENT = 3  # walls of other numbers of chords that are kept
CHORDS = "contact_chords"  # of each edge, as a state was found, (1, m)


@dataclass(frozen=True, kw_only=True)
class SelfContact(Term):
    """Barrier energy that keeps the boundary from touching itself: it acts below the distance dhat.

    gap: dhat as a share of the shortest distance between neighbouring boundary nodes at rest; parts of one
    wall that are nearer than that distance at rest, as at the tip of a crease, do not repel each other.
    stiffness: traction at half the distance dhat, about, in units of the scene's largest shear modulus.
    base_line: whether the line of a clamped or rolling base goes on outside the body as an obstacle, as far
    as it is clear of the body.  skull: a fixed curve around the body that it cannot pass, points (2, n) in m:
    closed around a closed pial surface; else its ends stay clear of the lines on which base and mirror
    continue.
    On a body, raises ValueError where the boundary at rest crosses itself or comes too close to itself or an
    obstacle, and for a skull that does not go round the whole pial surface.
    """

    gap: float = 0.4
    stiffness: float = 1.0
    base_line: bool = True
    skull: ArrayLike | None = None

    def __post_init__(self) -> None:
        positive("gap", self.gap, at_most=0.9, remedy="neighbouring nodes must not be in contact at rest")
        positive("stiffness", self.stiffness)
        if not isinstance(self.base_line, bool):
            raise ValueError(f"base_line={self.base_line!r} must be True or False.")
        if self.skull is not None:
            points = finite_array("skull", self.skull, (2, None))
            if points.shape[1] < 2:
                raise ValueError(f"skull has {points.shape[1]} point; give at least two.")
            object.__setattr__(self, "skull", tuple(map(tuple, points.tolist())))

    @property
    def reads(self) -> tuple[str, ...]:
        """The scale of stress."""
        return ("stress_scale",)

    @property
    def optional(self) -> tuple[str, ...]:
        """Of how many chords edges were made."""
        return (CHORDS,)

    @property
    def writes(self) -> tuple[str, ...]:
        """Of how many chords edges were made, so that a state can be seen as it was found."""
        return (CHORDS,)

    def on(self, body: Body) -> ContactOperator:
        """Return the term discretised on `body`."""
        return ContactOperator(body, self)

    def for_states_of(self, body: Body) -> SelfContact:
        """Return contact in which parts of one wall that do not repel each other on `body` do so nowhere."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        return _AsOnCoarser(**own, near=_shortest(body))


@dataclass(frozen=True, kw_only=True)
class _AsOnCoarser(SelfContact):
    """Contact that takes for parts of one wall what a coarser mesh does; near: its distance for that, m.

    Where a state creases, what is one wall of it would be two on a finer mesh, and touch.
    """

    near: float


def _shortest(body: Body) -> float:
    """Return the shortest distance between neighbouring nodes of the boundary; m."""
    start, middle, end = body.nodes.T[boundary_edges(body)]
    return float(min(np.hypot(*(middle - one).T).min() for one in (start, end)))


class ContactOperator(Operator):
    """The boundary of one body: in units of the body's length, about its centre."""

    def __init__(self, body: Body, term: SelfContact) -> None:
        ipctk.set_num_threads(1)  # more threads make the last bit irreproducible
        self.body, boundary = body, boundary_edges(body)
        shortest = _shortest(body)
        self.unit, self.dhat = body.length, term.gap * shortest / body.length
        self.shortest, self.apart = shortest / body.length, APART * self.dhat
        self.near = term.near / body.length if isinstance(term, _AsOnCoarser) else self.shortest
        self.triangles = body.mesh.f2t[0, boundary[1] - body.mesh.nvertices]  # of the body's edges, (m,)
        self.at_points = body.quadrature.weights.shape
        self.nodes = np.unique(body.triangles)
        share = (1 + APART) * term.gap
        lines = obstacles(body, shortest, term.base_line, term.skull, share)
        fixed, fixed_edges, names = joined(lines, self.nodes)
        self.names = ["body"] * boundary.shape[1] + names  # of what each edge belongs to
        self.edges = np.concatenate([np.searchsorted(self.nodes, boundary), fixed_edges], axis=1)
        self.straight = np.append(stays_straight(body, boundary), np.ones(fixed_edges.shape[1], dtype=bool))
        centre = body.nodes.mean(axis=1)
        self.rest = (np.concatenate([body.nodes.T[self.nodes], fixed]) - centre) / self.unit
        lengths = np.hypot(*(self.rest[self.edges[2]] - self.rest[self.edges[0]]).T)
        self.counts = self._counts(BEND * lengths, 0.5)
        self.walls = self._walls(self.counts)
        self._recent: list[Walls] = []  # of other numbers of chords, the last first
        self.barriers = (
            creases(self.edges, tissue_left(body, boundary), self.rest, term.gap, term.stiffness),
            inversion(np.searchsorted(self.nodes, bounding(body, boundary)), self.rest, term.stiffness),
            Turning(np.searchsorted(self.nodes, body.triangles), self.rest, term.stiffness),
        )
        # its slope at half of dhat is 4.33 dhat³ in ipctk's units, and 4.63 where neighbouring chords act too
        self.barrier = ipctk.BarrierPotential(self.dhat, 0.5 * term.stiffness / (4.63 * self.dhat**3))
        self.dofs = (2 * self.nodes[:, None] + np.arange(2)).ravel()
        self.n_dofs = body.nodes.size
        check_rest(self.walls, self.rest, self.dhat, self.names, self.unit, centre)

    def moved(self, x: Array) -> Array:
        """Return the nodes of boundary and obstacles, (n, 2), at the displacement x."""
        points: Array = self.rest.copy()
        points[: len(self.nodes)] += x[self.dofs].reshape(-1, 2) / self.unit
        return points

    def _counts(self, bends: Array, missed: float) -> Integers:
        """Return of how many chords each edge is made, 4, 8, 16 ..., or 1 if it cannot bend.

        bends: of each edge, (m,).  missed: times what chords keep apart: how far they may be from edges.
        """
        needed = np.maximum(counts(bends, missed * self.apart), FEWEST)
        rounded = FEWEST * 2 ** np.ceil(np.log2(needed / FEWEST)).astype(np.int64)
        return np.where(self.straight, 1, np.minimum(rounded, MOST))

    def _walls(self, numbers: Integers) -> Walls:
        return Walls(self.edges, numbers, self.rest, len(self.nodes), self.apart, self.near)

    def during(self, state: State, step: TimeStep) -> ContactPotential:
        """Return the barrier; edges that bend far are made of more chords than at rest."""
        scale = float(state["stress_scale"]) * self.unit**2
        points = self.moved(by_node(state["displacement"]))
        known = CHORDS in state
        used = np.maximum(self.counts, state[CHORDS][0].astype(np.int64)) if known else self.counts
        if known and step.over:
            return ContactPotential(self, self.made_of(used), scale, points, used)
        return ContactPotential(self, self.following(self.needed(points), points, used), scale, points, used)

    def needed(self, points: Array) -> Integers:
        """Return of how many chords each edge is to be made, (m,), with the nodes at `points`, (n, 2)."""
        bends = np.hypot(*bend(points[self.edges].transpose(0, 2, 1)))
        return np.maximum(self.counts, self._counts(bends, MISSED))

    def following(self, wanted: Integers, points: Array, used: Integers) -> Walls:
        """Return walls of as many chords as wanted, (m,), where the nodes are at `points`, (n, 2).

        used: as many as do not cross there; edges whose new chords are too close to others keep as many.
        """
        wanted = wanted.copy()
        while (wanted != used).any():
            walls = self.made_of(wanted)
            positions = walls.positions(points)
            close = walls.edges_within(positions, 1e-3 * self.dhat)
            if close.size == 0 and not walls.cross(positions):
                return walls
            if (wanted[close] == used[close]).all():
                break
            wanted[close] = used[close]
        return self.made_of(used)

    def made_of(self, numbers: Integers) -> Walls:
        """Return the walls, each edge made of so many chords, (m,)."""
        if (numbers == self.counts).all():
            return self.walls
        walls = next((walls for walls in self._recent if (walls.counts == numbers).all()), None)
        if walls is None:
            walls = self._walls(numbers.copy())
            self._recent = [walls, *self._recent[: RECENT - 1]]
        return walls


@dataclass(frozen=True)
class ContactPotential(Potential):
    """The barrier energy as a function of the displacement.

    scale: the unit of energy, J/m.  start: the nodes at the start of the step, (n, 2).  used: of how many
    chords each edge was made then, (m,).
    """

    operator: ContactOperator
    walls: Walls
    scale: float
    start: Array
    used: Integers

    def evaluate(self, x: Array) -> ContactEvaluation:
        """Return energy and derivatives at x."""
        return ContactEvaluation(self, x)


class ContactEvaluation(Abrupt):
    """Barrier energy at one displacement."""

    def __init__(self, potential: ContactPotential, x: Array) -> None:
        self.potential, self.x = potential, x
        self.operator = operator = potential.operator
        self.walls, self.scale = walls, scale = potential.walls, potential.scale
        self.points = operator.moved(x)
        self.positions = walls.positions(self.points)
        self.collisions = walls.collisions(self.positions, operator.dhat)
        found = (barrier.at(self.points) for barrier in operator.barriers)
        self.pairs = [pairs for pairs in found if not pairs.empty]
        self.has_hessian = not self.collisions.empty() or bool(self.pairs)
        apart = float(operator.barrier(self.collisions, walls.mesh, self.positions))
        self.energy = scale * (apart + sum(pairs.energy for pairs in self.pairs))
        self.round_off = 1e-15 * self.energy

    def _wall_forces(self) -> Array:
        """Return what walls that touch give to each node, (n, 2), in units of the operator's."""
        operator, share = self.operator, self.walls.share
        forces = operator.barrier.gradient(self.collisions, self.walls.mesh, self.positions)
        by_node: Array = np.zeros_like(operator.rest)
        by_node[: len(operator.nodes)] = (share.T @ forces[: share.shape[0]]).reshape(-1, 2)
        return by_node

    @cached_property
    def _forces(self) -> Array:
        operator, by_node = self.operator, self._wall_forces()
        for pairs in self.pairs:
            pairs.add_forces(by_node)
        return np.asarray(by_node[: len(operator.nodes)].ravel() * (self.scale / operator.unit))

    def gradient(self) -> tuple[Array, float]:
        """Return the nodal forces and the sum of squares of the contact forces."""
        operator = self.operator
        total = np.zeros(operator.n_dofs)
        if not self.has_hessian:
            return total, 0.0
        total[operator.dofs] = self._forces
        return total, float(self._forces @ self._forces)

    def hessian(self, convexity: float) -> Hessian:
        """Return the barrier's Hessian, clamped to be semi-definite where convexity is asked for."""
        operator, share = self.operator, self.walls.share
        method = ipctk.PSDProjectionMethod.CLAMP if convexity > 0 else ipctk.PSDProjectionMethod.NONE
        full = operator.barrier.hessian(self.collisions, self.walls.mesh, self.positions, method)
        n = share.shape[0]  # obstacles come after the boundary
        by_node = (share.T @ full[:n, :n].tocsr() @ share).tocoo()
        parts = [(by_node.row, by_node.col, by_node.data)]
        parts += [pairs.hessian(convexity > 0) for pairs in self.pairs]
        rows, columns, values = (
            np.concatenate([part.ravel() for part in kind]) for kind in zip(*parts, strict=True)
        )
        used = (columns <= rows) & (rows < len(operator.dofs))  # nodes of obstacles come last
        places = Entries(operator.dofs[rows[used]], operator.dofs[columns[used]])
        values = values[used] * (self.scale / operator.unit**2)
        return Hessian(places, values, constant=False, expected=self._expected)

    def largest_step(self, direction: Array) -> float:
        """Return the step, at most 1, to a little before walls come too close or a triangle turns over."""
        end = self.operator.moved(self.x + direction)
        if not np.isfinite(end).all():
            return 0.0  # ipctk would answer that nothing is in the way
        bounds = [barrier.largest_step(self.points, end) for barrier in self.operator.barriers]
        return min(self.walls.largest_step(self.positions, self.walls.positions(end)), *bounds)

    def finer(self) -> ContactPotential | None:
        """Return the barrier of more chords, if edges bent so far in this step that curved walls cross.

        The chords of two edges that bow towards each other may miss twice of what they keep apart.
        """
        operator, potential = self.operator, self.potential
        wanted = np.maximum(self.walls.counts, operator.needed(self.points))
        crossed = np.unique(self._crossed)
        crossed = crossed[~operator.straight[crossed]]
        while not self._crosses(wanted) and (wanted[crossed] < MOST).any():
            wanted[crossed] = np.minimum(2 * wanted[crossed], MOST)
        if not self._crosses(wanted):
            return None
        walls = operator.following(wanted, potential.start, potential.used)
        return None if (walls.counts == self.walls.counts).all() else replace(potential, walls=walls)

    def _crosses(self, counts: Integers) -> bool:
        """Return whether walls cross that are made of more chords than these, so many of each edge, (m,)."""
        if (counts == self.walls.counts).all():
            return False
        seen = self.operator.made_of(counts)
        return seen.cross(seen.positions(self.points))

    def is_valid(self) -> bool:
        """Return whether the body's curved boundary does not cross itself, or its mirror image."""
        return self._crossed.size == 0

    @cached_property
    def _crossed(self) -> Integers:
        return crossed_edges(self.operator.body, self.x.reshape(-1, 2).T)

    def finish(self, wanted: frozenset[str]) -> Fields:
        """Return of how many chords each edge is made, (1, m)."""
        return {CHORDS: self.walls.counts[None].astype(float)}

    def observe(self) -> Fields:
        """Return the contact pressure in the triangles at the boundary, 0 in others; (q, e), Pa.

        What walls that touch give to the nodes of a triangle's edges, over their length now; a node gives
        each of its edges the same share.
        """
        operator = self.operator
        points, triangles = operator.at_points
        pressure = np.zeros((points, triangles))
        if not self.collisions.empty():
            forces = np.hypot(*self._wall_forces().T) * (self.scale / operator.unit)
            edges = operator.edges[:, : len(operator.triangles)]  # those of obstacles come last
            start, middle, end = (self.points[nodes] * operator.unit for nodes in edges)
            lengths = np.hypot(*(middle - start).T) + np.hypot(*(end - middle).T)
            shared = forces / np.maximum(np.bincount(edges.ravel(), minlength=len(forces)), 1)
            force, length = (
                np.bincount(operator.triangles, of_edges, minlength=triangles)
                for of_edges in (shared[edges].sum(axis=0), lengths)
            )
            pressure += np.divide(force, length, out=np.zeros(triangles), where=length > 0)
        return {"contact_pressure": pressure}

    def measure(self) -> dict[str, float]:
        """Return the smallest distance between walls, m, or NaN while none are closer than 2 dhat."""
        operator = self.operator
        return {"min_gap": self.walls.smallest_gap(self.points, 2 * operator.dhat) * operator.unit}

    def _expected(self) -> Entries:
        """Return the entries of all pairs of edges that could come into contact before long."""
        operator = self.operator
        pairs = self.walls.close_edges(self.positions, SOON * operator.shortest)
        nodes = operator.nodes[operator.edges[:, pairs]].swapaxes(0, 1).reshape(len(pairs), 6)
        dofs = np.sort((2 * nodes[..., None] + np.arange(2)).reshape(len(pairs), 12), axis=1)
        columns, rows = np.triu_indices(12)
        return Entries(dofs[:, rows], dofs[:, columns])
