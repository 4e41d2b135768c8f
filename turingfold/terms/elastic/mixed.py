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
from ...parts import Operator, Potential, TimeStep
from ...state import State
from ..point_fields import at_points
from .kinematics import metric
from .mixed_energy import MixedEnergy, MixedGeometry
from .mixed_evaluation import MixedEvaluation
from .mixed_points import kinematics


class MixedOperator(MixedGeometry, Operator):
    """The mixed element on one body; mu, kappa at the body's integration points, (q, e), Pa."""

    def during(self, state: State, step: TimeStep) -> MixedPotential:
        """Return the energy with growth and moduli of `state`, starting from its inner unknowns."""
        growth = at_points(self.body, state, "growth", 3)
        factor = at_points(self.body, state, "modulus_factor")
        spread = None if growth is None else self.integration.spread_out(growth)
        grown = metric(self.integration.quadrature, self.integration.tangent, spread)
        share = np.ones_like(self.mu) if factor is None else self.integration.spread_out(factor)
        count = self.body.triangles.shape[1]
        bubble = state.fields.get("bubble", np.zeros((2, count)))
        pressure = state.fields.get("element_pressure", np.zeros((3, count)))
        return MixedPotential(self, grown, share * self.mu, share * self.kappa, bubble, pressure)


class MixedPotential(MixedEnergy, Potential):
    """The energy of one growth state as a function of the nodal displacement; the bubbles have settled."""

    def evaluate(self, x: Array) -> MixedEvaluation | None:
        """Return energy and derivatives at x, or None where J* <= 0 with the last bubbles and without any."""
        for bubble in (self.bubble, np.zeros_like(self.bubble)):
            at = kinematics(self.stretch(x, bubble, self.operator.integration.gradients), self.metric)
            if at is not None:
                return MixedEvaluation(self, x, bubble, self.pressure, at).settled()
        return None
