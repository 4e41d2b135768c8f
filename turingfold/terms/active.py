"""Active stress: tissue that pulls along the tangent of the pial surface, such as a layer of axons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Integers, add_up
from ..checks import finite, finite_array
from ..geometry.body import Body
from ..parts import Entries, Evaluation, Hessian, Load, Operator, Potential, TimeStep
from ..state import State
from .doubts import of_stress
from .element_matrices import gradient_products, lower, pairs


@dataclass(frozen=True, kw_only=True)
class ActiveStress(Load):
    """Energy ∫ σ/2 (|F t|² - 1) dA of a layer under active tangential stress: P = σ (F t)⊗t.

    stress: σ in Pa; it pulls the layer together if positive.  depth: of the layer's two sides below the pial
    surface, in units of the cortical thickness; (1, 2) is as much white matter as there is cortex above it.
    follows_pattern: σ is multiplied by û of the nearest pial point, and "pattern" is read.
    Raises ValueError for depths that are negative or out of order.
    """

    stress: float
    depth: tuple[float, float] = (1.0, 2.0)
    follows_pattern: bool = False

    def __post_init__(self) -> None:
        finite("stress", self.stress, "give it in Pa; positive pulls the layer together")
        low, high = finite_array("depth", self.depth, (2,)).tolist()
        if not 0 <= low < high:
            raise ValueError(f"depth=({low:g}, {high:g}) must be two depths in increasing order, from 0 on.")
        object.__setattr__(self, "depth", (low, high))

    @property
    def reads(self) -> tuple[str, ...]:
        """The pattern, if the stress follows it."""
        return ("pattern",) if self.follows_pattern else ()

    def doubt(self, body: Body, shear_modulus: float) -> str:
        """Return words for a stress far beyond μ."""
        words = of_stress("ActiveStress: stress", self.stress, shear_modulus)
        return words and f"{words}; it is in Pa."

    def on(self, body: Body) -> ActiveOperator:
        """Return the term discretised on `body`."""
        return ActiveOperator(body, self)


class ActiveOperator(Operator):
    """Active stress on one body: only the elements of its layer."""

    def __init__(self, body: Body, term: ActiveStress) -> None:
        quadrature = body.quadrature
        low, high = (share * body.thickness for share in term.depth)
        inside = (body.depth >= low) & (body.depth < high)
        self.elements = np.flatnonzero(inside.any(axis=0))
        if not len(self.elements):
            raise ValueError(f"depth={term.depth}: no part of the body lies there; choose a thicker layer.")
        within = np.s_[..., self.elements]
        self.body, self.follows_pattern = body, term.follows_pattern
        self.triangles = body.triangles[within]
        inverse, tangent = quadrature.inverse[within], body.tangent[within]
        # t in the reference triangle, so that F t = ∂x/∂ξ τ
        self.along = inverse[:, 0] * tangent[0] + inverse[:, 1] * tangent[1]
        self.weights = term.stress * (inside * quadrature.weights)[within]
        self.gradients = quadrature.derivatives
        self.products = gradient_products(self.gradients)
        self.entries = Entries(*lower(*pairs(self.triangles)))

    def during(self, state: State, step: TimeStep) -> ActivePotential:
        """Return the energy with the pattern in `state`."""
        if not self.follows_pattern:
            return ActivePotential(self, self.weights)
        body = self.body
        along_pial = body.spread(body.cortex, state["pattern"])[body.pial]
        pattern = np.interp(body.arc[:, self.elements], body.pial_arc, along_pial)
        return ActivePotential(self, self.weights * pattern)


@dataclass(frozen=True)
class ActivePotential(Potential):
    """The energy of active stress as a function of the displacement; `weights`: σ dA, (q, elements)."""

    operator: ActiveOperator
    weights: Array

    def evaluate(self, x: Array) -> ActiveEvaluation:
        """Return energy and derivatives at x."""
        operator = self.operator
        at_nodes = (operator.body.nodes + x.reshape(-1, 2).T)[:, operator.triangles]
        fibre = np.einsum("iae,amq,mqe->iqe", at_nodes, operator.gradients, operator.along, optimize=True)
        return ActiveEvaluation(self, fibre)


class ActiveEvaluation(Evaluation):
    """Energy of active stress at one configuration; `fibre` is F t, (2, q, layer's elements)."""

    def __init__(self, potential: ActivePotential, fibre: Array) -> None:
        self.potential, self.fibre = potential, fibre
        density = 0.5 * potential.weights * ((fibre**2).sum(0) - 1.0)
        self.energy = float(density.sum())
        self.round_off = 1e-15 * float(np.abs(potential.weights).sum())

    def gradient(self) -> tuple[Array, float]:
        """Return ∫ σ (F t)·(∂v t) dA and the sum of squares of the point forces."""
        operator = self.potential.operator
        pull = self.potential.weights * self.fibre
        forces = np.einsum("iqe,mqe,amq->iae", pull, operator.along, operator.gradients, optimize=True)
        dofs: Integers = 2 * operator.triangles[None] + np.arange(2)[:, None, None]
        return add_up(dofs, forces, 2 * operator.body.nodes.shape[1]), float(np.vdot(pull, pull))

    def hessian(self, convexity: float) -> Hessian:
        """Return ∫ σ (∂v t)·(∂w t) dA: constant, and semi-definite for a pulling stress as it is."""
        operator, weights = self.potential.operator, self.potential.weights
        weights = np.where(weights < 0, (1.0 - convexity) * weights, weights)
        x, y = operator.along
        points = np.stack([weights * x * x, weights * x * y, weights * y * y])
        values = operator.products @ points.reshape(-1, points.shape[2])
        return Hessian(operator.entries, np.concatenate([values, values]))
