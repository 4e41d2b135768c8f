"""Self-contact of the body's boundary, and with the straight lines on which base or mirror continue.

The barrier and the continuous collision detection are ipctk's (incremental potential contact, Li et al.
2020). The boundary's polyline runs through the corner and middle nodes of the quadratic edges. At the two
ends of the pial surface of a clamped, rolling or mirrored body the base (or mirror) line continues outward as
an obstacle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import ipctk
import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Integers
from ..checks import finite_array, positive
from ..geometry.body import Body
from ..parts import Entries, Evaluation, Hessian, Operator, Potential, Term, TimeStep
from ..state import State

ipctk.set_num_threads(1)  # more threads make the last bit irreproducible
REACH = 8.0  # obstacles extend this many body lengths


@dataclass(frozen=True, kw_only=True)
class SelfContact(Term):
    """Barrier energy that keeps the boundary from touching itself: it acts below the distance dhat.

    gap: dhat as a share of the shortest distance between neighbouring boundary nodes at rest; below 1, or
    nodes would be in contact from the start.  stiffness: traction at half the distance dhat, in units of the
    scene's largest shear modulus.  skull: a fixed curve around the body that it cannot pass, points (2, n) in
    m: closed around a closed pial surface; else its ends stay clear of the lines on which base and mirror
    continue.
    On a body, raises ValueError for a skull that crosses it or does not go round its whole pial surface.
    """

    gap: float = 0.4
    stiffness: float = 1.0
    skull: ArrayLike | None = None

    def __post_init__(self) -> None:
        positive("gap", self.gap, at_most=0.9, remedy="neighbouring nodes must not be in contact at rest")
        positive("stiffness", self.stiffness)
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
    """The collision mesh of one body. Distances inside ipctk are in units of the body's length."""

    def __init__(self, body: Body, term: SelfContact) -> None:
        self.unit = body.length
        self.nodes, edges, shortest = _boundary(body)
        skull = None
        if term.skull is not None:
            from .skull import check_clear, check_skull

            skull = np.asarray(term.skull, dtype=float)
            check_skull(body, skull)
            check_clear(skull, _continued(body), term.gap * shortest)
        obstacles, obstacle_edges = _obstacles(body, self.nodes, skull)
        self.rest = np.asfortranarray(np.concatenate([body.nodes[:, self.nodes].T, obstacles]) / self.unit)
        self.moving = len(self.nodes)
        self.edges = np.concatenate([edges, obstacle_edges]).astype(np.int32)
        self.mesh = ipctk.CollisionMesh(self.rest, np.asfortranarray(self.edges))
        if skull is not None:  # its points may be as dense as they like: they do not meet each other
            self.mesh.can_collide = ipctk.make_static_obstacle_filter(self.moving)
        self.dhat = term.gap * shortest / self.unit
        self.reach = 3 * shortest / self.unit  # pairs this close get a place in the matrix
        # the barrier's slope at half of dhat is 4.33 dhat³ in ipctk's units; both walls have one
        self.barrier = ipctk.BarrierPotential(self.dhat, 0.5 * term.stiffness / (4.33 * self.dhat**3))
        dofs = 2 * np.repeat(self.nodes, 2)
        dofs[1::2] += 1
        self.dofs = dofs
        self.n_dofs = 2 * body.nodes.shape[1]
        if self.smallest_gap(self.rest) < self.dhat:
            raise ValueError(
                f"SelfContact: the undeformed boundary comes closer to itself or the skull than dhat = "
                f"{self.dhat * self.unit:.3g} m; use a smaller gap, or outlines that keep their distance."
            )

    def positions(self, x: Array) -> Array:
        """Return the collision vertices (n, 2) at the displacement x."""
        moved = self.rest.copy(order="F")
        moved[: self.moving] += x[self.dofs].reshape(-1, 2) / self.unit
        return moved

    def collisions(self, positions: Array, reach: float) -> ipctk.NormalCollisions:
        """Return the pairs closer than `reach`."""
        found = ipctk.NormalCollisions()
        found.use_area_weighting = True
        found.build(self.mesh, positions, reach)
        return found

    def smallest_gap(self, positions: Array) -> float:
        """Return the smallest distance between walls closer than 2 dhat, or NaN without any.

        At rest, neighbouring nodes are farther apart than that.
        """
        found = self.collisions(positions, 2 * self.dhat)
        if found.empty():
            return float("nan")
        return float(np.sqrt(found.compute_minimum_distance(self.mesh, positions)))

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
        return np.asarray(operator.barrier.gradient(self.collisions, operator.mesh, self.positions))

    def gradient(self) -> tuple[Array, float]:
        """Return the nodal forces and the sum of squares of the contact forces."""
        operator = self.operator
        total = np.zeros(operator.n_dofs)
        if not self.has_hessian:
            return total, 0.0
        forces = self._forces[: len(operator.dofs)] * (self.scale / operator.unit)
        total[operator.dofs] = forces
        return total, float(forces @ forces)

    def hessian(self, convexity: float) -> Hessian:
        """Return the barrier's Hessian, clamped to be semi-definite where convexity is asked for."""
        operator = self.operator
        method = ipctk.PSDProjectionMethod.CLAMP if convexity > 0 else ipctk.PSDProjectionMethod.NONE
        full = operator.barrier.hessian(self.collisions, operator.mesh, self.positions, method).tocoo()
        used = (full.col <= full.row) & (full.row < len(operator.dofs))  # obstacles come after the body's
        rows, columns = operator.dofs[full.row[used]], operator.dofs[full.col[used]]
        values = full.data[used] * (self.scale / operator.unit**2)
        return Hessian(Entries(rows, columns), values, constant=False, expected=self._expected)

    def largest_step(self, direction: Array) -> float:
        """Return nine tenths of the step at which parts of the boundary would first touch, at most 1."""
        operator, start = self.operator, self.positions
        end = operator.positions(self.x + direction)
        if not np.isfinite(end).all():
            return 0.0  # ipctk would answer that nothing is in the way
        if ipctk.is_step_collision_free(operator.mesh, start, end):
            return 1.0
        return 0.9 * float(ipctk.compute_collision_free_stepsize(operator.mesh, start, end))

    def measure(self) -> dict[str, float]:
        """Return the smallest distance between walls, m, or NaN while none are closer than 2 dhat."""
        return {"min_gap": self.operator.smallest_gap(self.positions) * self.operator.unit}

    def _expected(self) -> Entries:
        """Return the entries of all pairs that could come into contact before long."""
        operator = self.operator
        near = ipctk.Candidates()
        near.build(operator.mesh, self.positions, 0.5 * operator.reach)
        pairs = [(c.vertex_id, *operator.edges[c.edge_id]) for c in near.ev_candidates]
        vertices = np.array(pairs, dtype=np.int64).reshape(-1, 3)
        vertices = vertices[(vertices < operator.moving).all(1)]
        dofs = np.sort(operator.dofs.reshape(-1, 2)[vertices].reshape(-1, 6), axis=1)
        columns, rows = np.triu_indices(6)
        return Entries(dofs[:, rows], dofs[:, columns])


def _boundary(body: Body) -> tuple[Integers, Integers, float]:
    """Return the boundary's nodes, its edges (m, 2) as positions in them, and the shortest edge."""
    facets = body.mesh.boundary_facets()
    if body.mirror:
        facets = np.setdiff1d(facets, body.mesh.boundaries["mirror"])
    ends, middle = body.mesh.facets[:, facets], body.mesh.nvertices + facets
    edges = np.concatenate([np.stack([ends[0], middle]), np.stack([middle, ends[1]])], axis=1)
    nodes, local = np.unique(edges, return_inverse=True)
    length = np.hypot(*(body.nodes[:, edges[0]] - body.nodes[:, edges[1]]))
    return nodes, local.reshape(2, -1).T, float(length.min())


def _obstacles(body: Body, nodes: Integers, skull: Array | None) -> tuple[Array, Integers]:
    """Return the fixed points and edges (m, 2) of the lines beyond the pial surface's ends and of the skull.

    An edge counts its points after the boundary's nodes.
    """
    points: list[Array] = []
    edges: list[tuple[int, int]] = []
    for end, outward in _outward(body):
        points.append(_far(body, end, outward))
        edges.append((int(np.searchsorted(nodes, end)), len(nodes) + len(points) - 1))
    if skull is not None:
        first = len(nodes) + len(points)
        points.extend(skull.T)
        edges.extend((first + k, first + k + 1) for k in range(skull.shape[1] - 1))
    return np.array(points).reshape(-1, 2), np.array(edges, dtype=np.int64).reshape(-1, 2)


def _continued(body: Body) -> Array:
    """Return the lines beyond the pial surface's ends as segments, (2, 2, m)."""
    lines = [[body.nodes[:, end], _far(body, end, outward)] for end, outward in _outward(body)]
    return np.array(lines).reshape(-1, 2, 2).transpose(1, 2, 0)


def _far(body: Body, end: int, outward: Array) -> Array:
    return np.asarray(body.nodes[:, end] + REACH * body.length * outward)


def _outward(body: Body) -> Iterator[tuple[int, Array]]:
    """Yield each end of the pial surface on a straight base or mirror, and the way onward from there."""
    ends = [n for path in body.pial_paths if not path.closed for n in path.nodes[[0, -1]].tolist()]
    for name in ("base", "mirror"):
        if name not in body.mesh.boundaries or (name == "base" and body.base == "free"):
            continue
        for path in body.boundary_paths(name):
            for end, neighbour in (path.nodes[:2], path.nodes[:-3:-1]):
                if end in ends:
                    onward = body.nodes[:, end] - body.nodes[:, neighbour]
                    yield int(end), onward / np.hypot(*onward)
