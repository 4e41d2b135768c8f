"""Nearly incompressible elasticity: quadratic triangles with a bubble and a discontinuous linear pressure.

The Crouzeix-Raviart element: where κ is large, the volume of an element can only be controlled on average,
and a linear pressure p in each element does so. Eliminated, it leaves the energy

    E(x, b) = ∫ J_G μ/2 (I₁* J*^{-2/3} - 3) dA + ½ rᵀ A⁻¹ r,   r_k = ∫ J_G N_k (J* - 1) dA,
    A_kl = ∫ J_G N_k N_l / κ dA,   p = A⁻¹ r,

and as J* is affine in the bubble displacement b and the rest of the energy convex in it, the minimum over b
exists and is unique in each element. What the minimiser sees is min_b E, a function of the nodes alone.

Newton's method on it would need the pressure to follow κ (J* - 1), which a straight step overshoots. So the
tangent is built with a pressure that is an unknown of its own, p ← A⁻¹ (r + ∂r/∂x dx), and the search along a
step compares values of the augmented Lagrangian of the condition r = A p (`MixedRay`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array
from ..body import Body
from ..scene import InadmissibleStateError, State
from .elastic import at_points
from .mixed_evaluation import MixedEvaluation
from .mixed_points import kinematics, points_on
from .points import Metric, deformation, determinant, determinant_along, first_loss, metric, von_mises


class MixedOperator:
    """The mixed element on one body; mu, kappa at the body's integration points, (q, e), Pa."""

    grounds = False

    def __init__(self, body: Body, mu: Array, kappa: Array) -> None:
        """Compute the integration points and the places of the entries."""
        self.body, self.points = body, points_on(body)
        self.mu, self.kappa = self.points.spread_out(mu), self.points.spread_out(kappa)
        self.dofs = (2 * body.triangles[None] + np.arange(2)[:, None, None]).reshape(12, -1)
        self.low, self.high = np.tril_indices(12)
        one, other = self.dofs[self.low], self.dofs[self.high]
        self.rows, self.columns = np.maximum(one, other), np.minimum(one, other)
        self._grown: tuple[Array | None, Metric] | None = None

    def moves(self, x: Array, bubble: Array) -> Array:
        """Return the moves of each element's nodes relative to its first one, and the bubble's, (2, 7, e).

        Without the common part round-off, which κ multiplies, is relative to the element and not to the body.
        """
        nodes = x[self.dofs].reshape(2, 6, -1)
        return np.concatenate([nodes - nodes[:, :1], bubble[:, None]], axis=1)

    def rest_stretch(self, slopes: Array) -> Array:
        """Return ∂X/∂ξ, (2, 2, q, e), for slopes of the 7 shape functions, (7, 2q)."""
        corners = self.body.nodes[:, self.body.triangles]
        flat = slopes[:6].T @ (corners - corners[:, :1])
        return np.asarray(flat.reshape(2, 2, -1, corners.shape[2]))

    def during(self, state: State, dt: float) -> MixedPotential:
        """Return the energy with the growth and stiffness in `state`, starting from its inner unknowns."""
        growth, stiffness = at_points(self.body, state, "growth", 3), at_points(self.body, state, "stiffness")
        if self._grown is None or self._grown[0] is not growth:
            spread = None if growth is None else self.points.spread_out(growth)
            self._grown = growth, metric(self.points.quadrature, self.points.tangent, spread)
        share = np.ones_like(self.mu) if stiffness is None else self.points.spread_out(stiffness)
        count = self.body.triangles.shape[1]
        bubble = state.fields.get("bubble", np.zeros((2, count)))
        pressure = state.fields.get("element_pressure", np.zeros((3, count)))
        return MixedPotential(self, self._grown[1], share * self.mu, share * self.kappa, bubble, pressure)


@dataclass(frozen=True)
class MixedPotential:
    """The energy of one growth state as a function of the nodal displacement; the bubbles have settled.

    bubble: where the search for them starts, (2, e).  pressure: that of the tangent, (3, e); zero at rest, it
    follows the Newton steps (`along`). The tangent is the second derivative of the energy where it is A⁻¹ r.
    """

    operator: MixedOperator
    metric: Metric
    mu: Array
    kappa: Array
    bubble: Array
    pressure: Array

    @cached_property
    def bulk(self) -> Array:
        """A⁻¹, (3, 3, e)."""
        N = self.operator.points.linear
        A = np.einsum("kq,lq,qe->ekl", N, N, self.metric.weights / self.kappa)
        return np.ascontiguousarray(np.moveaxis(np.linalg.inv(A), 0, 2))

    @cached_property
    def rest(self) -> float:
        """The energy ∫ 3μ/2 that cancels in the stress-free state."""
        return 1.5 * float(np.vdot(self.metric.weights, self.mu))

    def stretch(self, x: Array, bubble: Array, slopes: Array) -> Array:
        """Return H = ∂x/∂ξ, (2, 2, q, e), of the nodal displacement x (2 n_nodes,) and the bubbles."""
        return self.operator.rest_stretch(slopes) + self.change(x, bubble, slopes)

    def change(self, x: Array, bubble: Array, slopes: Array) -> Array:
        """Return the gradients (2, 2, q, e) of a nodal displacement (2 n_nodes,) and of bubbles alone."""
        moves = self.operator.moves(x, bubble)
        return np.asarray((slopes.T @ moves).reshape(2, 2, -1, moves.shape[2]))

    def evaluate(self, x: Array) -> MixedEvaluation | None:
        """Return energy and derivatives at x, or None where J* <= 0 with the last bubbles and without any."""
        for bubble in (self.bubble, np.zeros_like(self.bubble)):
            at = kinematics(self.stretch(x, bubble, self.operator.points.slopes), self.metric)
            if at is not None:
                return MixedEvaluation(self, x, bubble, self.pressure, at).settled()
        return None

    def largest_step(self, x: Array, direction: Array) -> float:
        """Return the step in (0, 1] at which det ∂x/∂ξ has lost at most 90 %, with the bubbles at rest."""
        at = self.evaluate(x)
        return 1.0 if at is None else self.longest(at.at.H, direction, np.zeros_like(self.bubble))

    def longest(self, H: Array, direction: Array, bubble: Array) -> float:
        """Return that step for nodes moving along direction and bubbles moving along bubble."""
        dH = self.change(direction, bubble, self.operator.points.slopes)
        now, linear, square = determinant_along(H, dH)
        return first_loss(0.9 * now, linear, square)

    def finish(self, x: Array) -> dict[str, Array]:
        """Return the bubbles (2, e), m, and pressures at the elements' corners (3, e), Pa, to start from."""
        at = self.evaluate(x)
        if at is None:
            raise InadmissibleStateError("the bubbles of the mixed elements are not found")
        return {"bubble": at.bubble, "element_pressure": at.own_pressure}

    def observe(self, x: Array) -> dict[str, Array]:
        """Return von Mises stress and pressure (3D Cauchy stress, Pa) and J* at the body's points, (p, e)."""
        at = self.evaluate(x)
        if at is None:
            return {}
        points = self.operator.points
        H = self.stretch(x, at.bubble, points.shown)
        back = points.spread_back
        F = deformation(H, back @ self.metric.D)
        out2 = back @ self.metric.out2
        I1, J = (F**2).sum(1).sum(0) + out2, determinant(F) * np.sqrt(out2)
        pressure = -np.einsum("kq,ke->qe", points.linear_shown, at.own_pressure)
        stress = von_mises(back @ self.mu, F, out2, I1, J)
        return {"von_mises": stress, "pressure": pressure, "jacobian": J}

    def measure(self, x: Array) -> dict[str, float]:
        """Return the smallest J*."""
        at = self.evaluate(x)
        return {"min_jacobian": float(at.at.J.min()) if at is not None else float("nan")}
