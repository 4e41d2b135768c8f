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

import numpy as np

from ...arrays import Array
from ...errors import InadmissibleStateError
from ...geometry.body import Body
from ...state import State
from ..point_fields import at_points
from .kinematics import Metric, deformation, determinant, metric, von_mises
from .mixed_energy import MixedEnergy, MixedGeometry
from .mixed_evaluation import MixedEvaluation
from .mixed_points import kinematics


class MixedOperator(MixedGeometry):
    """The mixed element on one body; mu, kappa at the body's integration points, (q, e), Pa."""

    grounds = False

    def __init__(self, body: Body, mu: Array, kappa: Array) -> None:
        """Compute what does not change with growth."""
        super().__init__(body, mu, kappa)
        self._grown: tuple[Array | None, Metric] | None = None

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


class MixedPotential(MixedEnergy):
    """The energy of one growth state as a function of the nodal displacement; the bubbles have settled."""

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
