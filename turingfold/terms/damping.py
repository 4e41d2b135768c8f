"""Damping proportional to stiffness: with drag, which is proportional to mass, it is Rayleigh's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, tril

from ..arrays import Array
from ..checks import instance, one_of, positive
from ..geometry.body import Body, by_node
from ..parts import Hessian, Operator, SimplePotential
from ..state import State
from .dynamics import SCHEMES, balanced_at
from .elastic.term import Elastic


@dataclass(frozen=True, kw_only=True)
class StiffnessDamping:
    """Force β K₀ ∂u/∂t against deformation, with K₀ the tangent of the undeformed, ungrown body.

    Over one step Φ = β/(2 dt) (x - u)ᵀ K₀ (x - u). With Drag(coefficient=α ρ) it makes Rayleigh's damping
    α M + β K₀, under which a small vibration of frequency ω has the damping ratio ζ = (α/ω + β ω)/2.
    elastic: the solid whose stiffness it is, usually that of the scene; a field "stiffness" multiplies it.
    time: β in s (in units of the scene's time).
    scheme: that of the scene's Inertia; with "midpoint" forces balance after half of the step, and the scene
    needs Inertia, which moves the body on to the end of it.
    It does not resist translation. As K₀ does not turn with the body, it resists rotation at the rate ω once
    the body has turned by an angle φ, with forces in proportion to ω sin φ; use it where rotations are small.
    """

    elastic: Elastic
    time: float
    scheme: str = "euler"

    ends_step = False

    def __post_init__(self) -> None:
        instance("elastic", self.elastic, Elastic, "Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))")
        positive("time", self.time, remedy="leave StiffnessDamping out for none")
        one_of("scheme", self.scheme, SCHEMES)

    @property
    def reads(self) -> tuple[str, ...]:
        """The displacement before the step; "stiffness" is used where it exists."""
        return ("displacement",)

    def on(self, body: Body) -> DampingOperator:
        """Return the term discretised on `body`."""
        return DampingOperator(self.elastic.on(body), self.time, balanced_at(self.scheme))


class DampingOperator:
    """Damping on one body; forces balance at the share `reach` of the step, 1 (end) or 1/2 (middle)."""

    grounds = False  # it leaves translations free

    def __init__(self, elastic: Operator, time: float, reach: float) -> None:
        self.elastic, self.time, self.reach = elastic, time, reach
        self._known: tuple[Array | None, Stiffness] | None = None

    def during(self, state: State, dt: float) -> DampingPotential:
        """Return the potential of one step."""
        old = by_node(state["displacement"])
        return DampingPotential(self._stiffness(state), old, self.time / (self.reach * dt))

    def _stiffness(self, state: State) -> Stiffness:
        factors = state.fields.get("stiffness")
        if self._known is None or self._known[0] is not factors:
            rest = State(0.0, {} if factors is None else {"stiffness": factors})
            at_rest = np.zeros(state["displacement"].size)
            solid = self.elastic.during(rest, 1.0)
            at = None if solid is None else solid.evaluate(at_rest)
            assert at is not None  # an undeformed body is admissible
            self._known = factors, Stiffness(at.hessian(0.0), len(at_rest))
        return self._known[1]


@dataclass(frozen=True, eq=False)
class Stiffness:
    """The tangent K₀ of a body at rest, from its lower triangle."""

    lower: Hessian
    n_dofs: int

    @cached_property
    def matrix(self) -> csr_matrix:
        """K₀, (2 n_nodes, 2 n_nodes)."""
        places = self.lower.rows.ravel(), self.lower.columns.ravel()
        lower = csr_matrix((self.lower.values.ravel(), places), shape=(self.n_dofs, self.n_dofs))
        return (lower + tril(lower, -1).T).tocsr()

    @cached_property
    def diagonal(self) -> Array:
        """Its diagonal, (2 n_nodes,)."""
        return np.asarray(self.matrix.diagonal())


@dataclass(frozen=True)
class DampingPotential(SimplePotential):
    """½ weight (x - old)ᵀ K₀ (x - old)."""

    stiffness: Stiffness
    old: Array
    weight: float

    def evaluate(self, x: Array) -> DampingEvaluation:
        """Return energy and derivatives at x."""
        return DampingEvaluation(self.stiffness, x - self.old, self.weight)


class DampingEvaluation:
    """½ weight xᵀ K₀ x with its derivatives."""

    curved = True

    def __init__(self, stiffness: Stiffness, x: Array, weight: float) -> None:
        self.stiffness, self.weight = stiffness, weight
        self.force = weight * np.asarray(stiffness.matrix @ x)
        self.energy = 0.5 * float(self.force @ x)
        # of the terms that cancel where the body moves as a whole
        self.grain = 1e-15 * weight * float(stiffness.diagonal @ x**2)

    def gradient(self) -> tuple[Array, float]:
        """Return the forces and their sum of squares."""
        return self.force, float(self.force @ self.force)

    def hessian(self, convexity: float) -> Hessian:
        """Return the weighted stiffness, which is positive semi-definite."""
        lower = self.stiffness.lower
        return Hessian(lower.rows, lower.columns, self.weight * lower.values, lasting=True)
