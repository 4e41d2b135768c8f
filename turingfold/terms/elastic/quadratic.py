"""Elastic energy on quadratic triangles.

Everything is pulled back to the reference triangle, where the shape functions are the same for all elements:
with H = ∂x/∂ξ, B = D Dᵀ, D = (∂ξ/∂X) G⁻¹ and δ = F*_zz det D,

    I₁ = H:(H B) + F*_zz²,   J* = δ det H,   ∂J*/∂H = δ cof H,

so that forces and tangents of all elements are three matrix products with constant matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import Array, Places, add_up
from ...geometry.body import Body
from ...geometry.triangles import folded_over
from ...parts import Entries, Evaluation, Fields, Hessian, Operator, Potential, TimeStep
from ...state import State
from ..element_matrices import gradient_products, lower, pairs
from ..point_fields import at_points
from . import material
from .kinematics import (
    Metric,
    cauchy,
    cofactor,
    deformation,
    determinant,
    determinant_along,
    first_invariant,
    first_loss,
    metric,
    stress_fields,
    tangents,
    times_symmetric,
    von_mises,
)


class ElasticOperator(Operator):
    """Elasticity on one body: shape function products and entry places, computed once."""

    def __init__(self, body: Body, mu: Array, kappa: Array) -> None:
        self.body, self.mu, self.kappa = body, mu, kappa
        gradients = body.quadrature.derivatives
        q = gradients.shape[2]
        self.gradients = gradients.reshape(6, 2 * q)
        self.diagonal_products = gradient_products(gradients)
        self.cross_products = (gradients[:, None, :, None] * gradients[None, :, None, :]).reshape(36, 4 * q)
        self.entries = Entries(*self._places())
        self.dofs = 2 * body.triangles[None] + np.arange(2)[:, None, None]  # (2, 6, e)
        centred = body.nodes - body.nodes.mean(axis=1, keepdims=True)  # round-off of a body far away
        self._undeformed = self.gradient(centred.T)

    def _places(self) -> tuple[Places, Places]:
        """Return where the 78 different entries of each element matrix go, each (78, e)."""
        triangles = self.body.triangles.astype(np.int32)  # kept with the operator, in half the space
        one, other = pairs(triangles)
        first, second = np.divmod(np.arange(36), 6)
        x = 2 * triangles
        return lower(np.concatenate([one, x[first]]), np.concatenate([other, x[second] + 1]))

    def gradient(self, values: Array) -> Array:
        """Return ∂/∂ξ at the integration points, (2, 2, q, e), of nodal vectors (2 n_nodes,)."""
        at_nodes = np.take(values.reshape(-1, 2).T, self.body.triangles, axis=1)
        return (self.gradients.T @ at_nodes).reshape(2, 2, -1, at_nodes.shape[2])

    def stretch(self, x: Array) -> Array:
        """Return H = ∂x/∂ξ, (2, 2, q, e), of the displacement x (2 n_nodes,)."""
        return self._undeformed + self.gradient(x)

    def during(self, state: State, step: TimeStep) -> ElasticPotential:
        """Return the elastic energy with growth and moduli of `state`."""
        growth = at_points(self.body, state, "growth", 3)
        tangent = None if growth is None else self.body.tangent
        grown = metric(self.body.quadrature, tangent, growth)
        factor = at_points(self.body, state, "modulus_factor")
        mu, kappa = (self.mu, self.kappa) if factor is None else (factor * self.mu, factor * self.kappa)
        return ElasticPotential(self, grown, mu, kappa)


@dataclass(frozen=True)
class ElasticPotential(Potential):
    """The elastic energy of one growth state, as a function of the displacement."""

    operator: ElasticOperator
    metric: Metric
    mu: Array
    kappa: Array

    @cached_property
    def cancelling_energy(self) -> float:
        """The energy ∫ 3μ/2 that cancels in the stress-free state."""
        return 1.5 * float(np.vdot(self.metric.weights, self.mu))

    def evaluate(self, x: Array) -> ElasticEvaluation | None:
        """Return energy and derivatives at x, or None where J* <= 0 somewhere."""
        H = self.operator.stretch(x)
        J = np.asarray(self.metric.delta * determinant(H))
        if not J.min() > 0:  # also catches NaN
            return None
        return ElasticEvaluation(self, x, H, J)


class ElasticEvaluation(Evaluation):
    """Elastic energy at one configuration, with gradient and Hessian on demand."""

    def __init__(self, potential: ElasticPotential, x: Array, H: Array, J: Array) -> None:
        self.potential, self.x, self.H, self.J = potential, x, H, J
        m = potential.metric
        self.HB = times_symmetric(H, m.B)
        self.I1 = first_invariant(H, self.HB, m.out2)
        self.law = potential.mu, potential.kappa, self.I1, J, material.shrink(J)
        density = material.energy(*self.law)
        self.energy = float(np.vdot(m.weights, density))
        self.round_off = 1e-15 * (abs(self.energy) + potential.cancelling_energy)

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        return material.stress_coefficients(*self.law)

    @cached_property
    def _cofactor(self) -> Array:
        return cofactor(self.H, self.potential.metric.delta)

    def gradient(self) -> tuple[Array, float]:
        """Return the nodal forces (2 n_nodes,) and the sum of squares of the shear part of the point forces.

        The shear part alone does not vanish in the stress-free state: it is what round-off is relative to.
        """
        operator, (a, b) = self.potential.operator, self._slopes
        weights = self.potential.metric.weights
        shear = (weights * a) * self.HB
        P = shear + (weights * b) * self._cofactor
        forces = operator.gradients @ P.reshape(2, -1, P.shape[3])  # (2, 6, e)
        total = add_up(operator.dofs, forces, 2 * operator.body.nodes.shape[1])
        return total, float(np.vdot(shear, shear))

    def hessian(self, convexity: float) -> Hessian:
        """Return the tangent, with the share `convexity` of its negative part at each point taken away."""
        operator, m, (a, b) = self.potential.operator, self.potential.metric, self._slopes
        c1, c2 = material.tangent_coefficients(*self.law)
        same, mixed = tangents(m, self.H, self.HB, self._cofactor, (a, b, c1, c2), convexity)
        q, e = a.shape
        values = np.empty((78, e))
        np.matmul(operator.diagonal_products, same.reshape(2, 3 * q, e), out=values[:42].reshape(2, 21, e))
        np.matmul(operator.cross_products, mixed.reshape(4 * q, e), out=values[42:])
        return Hessian(operator.entries, values)

    def largest_step(self, direction: Array) -> float:
        """Return the step in (0, 1] at which det ∂x/∂ξ has lost at most 90 % anywhere."""
        now, linear, square = determinant_along(self.H, self.potential.operator.gradient(direction))
        return first_loss(0.9 * now, linear, square)

    def is_valid(self) -> bool:
        """Return whether all triangles are positive everywhere, not only at the integration points."""
        body = self.potential.operator.body
        return not folded_over(body.mesh, body.nodes + self.x.reshape(-1, 2).T).size

    def finish(self, wanted: frozenset[str]) -> Fields:
        """Return what is wanted of stress (xx, yy, xy, zz; Pa), J* and moduli (μ, κ; Pa), at the points."""
        p, m, found = self.potential, self.potential.metric, {}
        if "cauchy_stress" in wanted:
            F, mean = deformation(self.H, m.D), p.kappa * (self.J - 1.0)
            found["cauchy_stress"] = cauchy(p.mu, mean, F, m.out2, self.I1, self.J)
        if "elastic_volume" in wanted:
            found["elastic_volume"] = self.J
        if "moduli" in wanted:
            found["moduli"] = np.stack([p.mu, p.kappa])
        return found

    def observe(self) -> Fields:
        """Return the 3D Cauchy stress, its von Mises stress and pressure (Pa), and J*, each (q, e)."""
        p, m = self.potential, self.potential.metric
        F, mean = deformation(self.H, m.D), p.kappa * (self.J - 1.0)
        shown = {"von_mises": von_mises(p.mu, F, m.out2, self.I1, self.J), "pressure": -mean}
        return {
            **shown, "jacobian": self.J, **stress_fields(cauchy(p.mu, mean, F, m.out2, self.I1, self.J)),
        }  # fmt: skip

    def measure(self) -> dict[str, float]:
        """Return the smallest J*."""
        return {"min_jacobian": float(self.J.min())}
