"""Self-contact of the body's boundary, and with the straight lines on which base or mirror continue.

The barrier and the continuous collision detection are ipctk's (incremental potential contact, Li et al.
2020). They see chords of the quadratic boundary edges, several to an edge and all moved by its three nodes;
walls keep apart by what the chords miss of the curves. At the two ends of the pial surface of a clamped,
rolling or mirrored body the base (or mirror) line continues outward as an obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import ipctk
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import kron
from scipy.spatial import cKDTree

from ..arrays import Array
from ..checks import finite_array, positive
from ..geometry.body import Body
from ..geometry.quadratic import distance, gap
from ..parts import Entries, Evaluation, Hessian, Operator, Potential, Term, TimeStep
from ..state import State
from .boundary import boundary_edges, chords, counts, neighbours, stays_straight
from .obstacles import Obstacle, continued, joined

BEND = 0.5  # of its length: how far a boundary edge may bend before its chords miss more than half of APART
APART = 0.05  # of dhat, which chords always keep between them
ROOM = 3.0  # shortest distances between nodes: edges this close get places in the matrix
MEETINGS = {
    "body": ("itself", "outlines that keep their distance"),
    "base": ("the line on which its base continues", "base_line=False"),
    "mirror": ("the line of its mirror", "an outline that keeps its distance"),
    "skull": ("the skull", "a wider one"),
}


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

    def on(self, body: Body) -> ContactOperator:
        """Return the term discretised on `body`."""
        return ContactOperator(body, self)


class ContactOperator(Operator):
    """The collision mesh of one body: in units of the body's length, about its centre."""

    def __init__(self, body: Body, term: SelfContact) -> None:
        ipctk.set_num_threads(1)  # more threads make the last bit irreproducible
        boundary = boundary_edges(body)
        start, middle, end = body.nodes.T[boundary]
        shortest = float(min(np.hypot(*(middle - one).T).min() for one in (start, end)))
        self.unit, self.dhat = body.length, term.gap * shortest / body.length
        self.apart, self.reach = APART * self.dhat, ROOM * shortest / body.length
        self.nodes, edges = np.unique(boundary, return_inverse=True)
        fixed, fixed_edges, names = joined(_obstacles(body, term, shortest), self.nodes)
        self.names = ["body"] * boundary.shape[1] + names  # of what each edge belongs to
        self.edges = np.concatenate([edges.reshape(3, -1), fixed_edges], axis=1)
        k = counts(np.hypot(*(end - start).T), BEND, 0.5 * self.apart * self.unit)
        k[stays_straight(body, boundary)] = 1
        k = np.append(k, np.ones_like(fixed_edges[0]))
        self.chords = chords(self.edges, k, len(self.nodes))
        centre = body.nodes.mean(axis=1)
        self.rest = (np.concatenate([body.nodes.T[self.nodes], fixed]) - centre) / self.unit
        at_rest = np.asfortranarray(self.chords.share @ self.rest)
        self.mesh = ipctk.CollisionMesh(at_rest, np.asfortranarray(self.chords.pieces.astype(np.int32)))
        near = neighbours(at_rest, self.chords.pieces, shortest / self.unit)
        wall = ipctk.make_sparse_filter(dict.fromkeys(map(tuple, near.tolist()), False), True)
        self.mesh.can_collide = ipctk.make_static_obstacle_filter(self.chords.moving) & wall
        # its slope at half of dhat is 4.33 dhat³ in ipctk's units, and 5.3 where neighbouring chords act too
        self.barrier = ipctk.BarrierPotential(self.dhat, 0.5 * term.stiffness / (5.3 * self.dhat**3))
        self.dofs = (2 * self.nodes[:, None] + np.arange(2)).ravel()
        self.n_dofs = body.nodes.size
        share = self.chords.share[: self.chords.moving, : len(self.nodes)]
        self.share = kron(share, np.eye(2), format="csr")
        self._check_rest(at_rest, centre)

    def moved(self, x: Array) -> Array:
        """Return the nodes of boundary and obstacles, (n, 2), at the displacement x."""
        points: Array = self.rest.copy()
        points[: len(self.nodes)] += x[self.dofs].reshape(-1, 2) / self.unit
        return points

    def positions(self, x: Array) -> Array:
        """Return the vertices of the chords, (v, 2), at the displacement x."""
        positions: Array = np.asfortranarray(self.chords.share @ self.moved(x))
        return positions

    def collisions(self, positions: Array, reach: float) -> ipctk.NormalCollisions:
        """Return the pairs closer than `reach`, beside what they keep apart anyway."""
        found = ipctk.NormalCollisions()
        found.use_area_weighting = True
        found.build(self.mesh, positions, reach, self.apart, ipctk.SweepAndPrune())
        return found

    def smallest_gap(self, x: Array) -> float:
        """Return the smallest distance between curved walls closer than 2 dhat, m, or NaN without any."""
        points, positions, chords = self.moved(x), self.positions(x), self.chords
        found = self.collisions(positions, 2 * self.dhat)
        if found.empty():
            return float("nan")
        pairs = [(c.vertex_id, *chords.pieces[c.edge_id], c.edge_id) for c in found.ev_collisions]
        pairs += [(c.vertex0_id, *2 * (c.vertex1_id,), -1) for c in found.vv_collisions]
        vertex, start, end, piece = np.array(pairs).T
        gaps = distance(*(positions[k].T for k in (vertex, start, end)))
        one = chords.edge[vertex]
        other = np.where(piece < 0, chords.edge[end], chords.edge_of[piece])
        xi, eta = chords.place[vertex], np.where(piece < 0, chords.place[end], chords.place_of[piece])
        # places on edges with a common node would run together there
        curved = ~(self.edges[:, None, one] == self.edges[:, other]).any((0, 1))
        edges = points[self.edges].transpose(0, 2, 1)
        gaps[curved] = gap(edges[..., one[curved]], edges[..., other[curved]], xi[curved], eta[curved])
        return float(gaps.min()) * self.unit

    def _check_rest(self, at_rest: Array, centre: Array) -> None:
        """Raise ValueError where walls cross at rest or are closer than dhat."""
        if ipctk.has_intersections(self.mesh, at_rest):
            raise ValueError(
                "SelfContact: the undeformed boundary crosses itself; repair the outline, or use smaller "
                "elements where its walls are close."
            )
        found = self.collisions(at_rest, self.dhat)
        if found.empty():
            return
        vertices = [v for v in found[0].vertex_ids(self.mesh.edges, self.mesh.faces) if v >= 0]
        met, remedy = MEETINGS[self.names[self.chords.edge[vertices].max()]]  # obstacles come last
        x, y = at_rest[min(vertices)] * self.unit + centre
        raise ValueError(
            f"SelfContact: the undeformed boundary comes closer to {met} than dhat = "
            f"{self.dhat * self.unit:.3g} m, near ({x:.4g}, {y:.4g}) m; use a smaller gap, or {remedy}."
        )

    def during(self, state: State, step: TimeStep) -> ContactPotential:
        """Return the barrier; it does not change from step to step."""
        return ContactPotential(self, float(state["stress_scale"]) * self.unit**2)


@dataclass(frozen=True)
class ContactPotential(Potential):
    """The barrier energy as a function of the displacement; `scale` is the unit of energy, J/m."""

    operator: ContactOperator
    scale: float

    def evaluate(self, x: Array) -> ContactEvaluation:
        """Return energy and derivatives at x."""
        return ContactEvaluation(self.operator, self.scale, x)


class ContactEvaluation(Evaluation):
    """Barrier energy at one displacement."""

    def __init__(self, operator: ContactOperator, scale: float, x: Array) -> None:
        positions = operator.positions(x)
        self.operator, self.scale, self.x, self.positions = operator, scale, x, positions
        self.collisions = operator.collisions(positions, operator.dhat)
        self.has_hessian = not self.collisions.empty()
        self.energy = scale * float(operator.barrier(self.collisions, operator.mesh, positions))
        self.round_off = 1e-15 * self.energy

    @cached_property
    def _forces(self) -> Array:
        operator = self.operator
        forces = operator.barrier.gradient(self.collisions, operator.mesh, self.positions)
        scale = self.scale / operator.unit
        return np.asarray(operator.share.T @ forces[: operator.share.shape[0]]) * scale

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
        operator = self.operator
        method = ipctk.PSDProjectionMethod.CLAMP if convexity > 0 else ipctk.PSDProjectionMethod.NONE
        full = operator.barrier.hessian(self.collisions, operator.mesh, self.positions, method)
        n = operator.share.shape[0]  # obstacles come after the boundary
        by_node = (operator.share.T @ full[:n, :n].tocsr() @ operator.share).tocoo()
        used = by_node.col <= by_node.row
        places = Entries(operator.dofs[by_node.row[used]], operator.dofs[by_node.col[used]])
        values = by_node.data[used] * (self.scale / operator.unit**2)
        return Hessian(places, values, constant=False, expected=self._expected)

    def largest_step(self, direction: Array) -> float:
        """Return nine tenths of the step at which walls would first come too close, at most 1."""
        operator, start = self.operator, self.positions
        end = operator.positions(self.x + direction)
        if not np.isfinite(end).all():
            return 0.0  # ipctk would answer that nothing is in the way
        pairs = ipctk.Candidates()
        pairs.build(operator.mesh, start, end, 0.5 * operator.apart, ipctk.SweepAndPrune())
        if pairs.is_step_collision_free(operator.mesh, start, end, operator.apart):
            return 1.0
        return 0.9 * float(pairs.compute_collision_free_stepsize(operator.mesh, start, end, operator.apart))

    def measure(self) -> dict[str, float]:
        """Return the smallest distance between walls, m, or NaN while none are closer than 2 dhat."""
        return {"min_gap": self.operator.smallest_gap(self.x)}

    def _expected(self) -> Entries:
        """Return the entries of all pairs of edges that could come into contact before long."""
        operator, chords = self.operator, self.operator.chords
        tree = cKDTree(self.positions[: chords.moving])
        pairs = np.unique(chords.edge[tree.query_pairs(operator.reach, output_type="ndarray")], axis=0)
        nodes = operator.nodes[operator.edges[:, pairs]].swapaxes(0, 1).reshape(len(pairs), 6)
        dofs = np.sort((2 * nodes[..., None] + np.arange(2)).reshape(len(pairs), 12), axis=1)
        columns, rows = np.triu_indices(12)
        return Entries(dofs[:, rows], dofs[:, columns])


def _obstacles(body: Body, term: SelfContact, clearance: float) -> list[Obstacle]:
    """Return the lines that go on from the body's ends and the skull; raises ValueError for a bad skull."""
    lines = continued(body, clearance, term.base_line)
    if term.skull is None:
        return lines
    from .skull import check_clear, check_skull

    skull = np.asarray(term.skull, dtype=float)
    check_skull(body, skull)
    ways = np.array([line.points[:, [0, -1]] for line in lines]).reshape(-1, 2, 2).transpose(2, 1, 0)
    check_clear(skull, ways, (1 + APART) * term.gap * clearance)
    return [*lines, Obstacle("skull", skull)]
