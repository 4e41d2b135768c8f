"""Finite-strain elasticity of the two-layer body on quadratic triangles, grown by F = F* G.

Everything is pulled back to the reference triangle, where the shape functions are the same for all elements:
with H = ∂x/∂ξ, B = D Dᵀ, D = (∂ξ/∂X) G⁻¹ and δ = F*_zz det D,

    I₁ = H:(H B) + F*_zz²,   J* = δ det H,   ∂J*/∂H = δ cof H,

so that forces and tangents of all elements are three matrix products with constant matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array, Integers, add_up
from ..body import Body
from ..checks import one_of
from ..growth import cortex_indicator
from ..scene import Hessian, Operator, SimplePotential, State
from . import material
from .entries import lower, pairs, slope_products
from .material import NeoHookean
from .points import (
    Metric,
    cofactor,
    deformation,
    determinant,
    determinant_along,
    first_invariant,
    first_loss,
    metric,
    tangents,
    times_symmetric,
    von_mises,
)

LAYERS = ("sigmoid", "sharp")
ELEMENTS = ("auto", "quadratic", "mixed")
NEARLY_INCOMPRESSIBLE = 0.49  # Poisson's ratio from which the quadratic element locks


@dataclass(frozen=True, kw_only=True)
class Elastic:
    """Elastic energy ∫ J_G ψ(F*) dA of a gray and a white neo-Hookean layer.

    Where processes write them, "growth" makes it grow and "stiffness" multiplies its moduli.

    layers: "sharp" takes the moduli by element; "sigmoid" blends them by θ(y) = 1/(1 + exp(10 (y/T - 1))).
    Without `white` the whole body is gray.
    element: "quadratic" triangles, "mixed" ones with a bubble and their own pressure, which do not lock, or
    "auto": mixed where a Poisson's ratio is at least 0.49.
    """

    gray: NeoHookean
    white: NeoHookean | None = None
    layers: str = "sharp"
    element: str = "auto"

    def __post_init__(self) -> None:
        one_of("layers", self.layers, LAYERS)
        one_of("element", self.element, ELEMENTS)
        for name, value in (("gray", self.gray), ("white", self.white)):
            if not (isinstance(value, NeoHookean) or (name == "white" and value is None)):
                raise ValueError(
                    f"{name}={value!r} must be a NeoHookean, e.g. NeoHookean.from_young(1389.0, 0.4583)."
                )

    @property
    def reads(self) -> tuple[str, ...]:
        """No field is required; "growth" and "stiffness" are used where they exist."""
        return ()

    @property
    def stress(self) -> float:
        """The largest shear modulus, the scene's unit of stress; Pa."""
        return max(self.gray.mu, self.white.mu if self.white else 0.0)

    @property
    def mixed(self) -> bool:
        """Whether the mixed element is used."""
        ratios = [layer.poisson for layer in (self.gray, self.white) if layer is not None]
        nearly = max(ratios) >= NEARLY_INCOMPRESSIBLE - 1e-12
        return self.element == "mixed" or (self.element == "auto" and nearly)

    def on(self, body: Body) -> Operator:
        """Return the term discretised on `body`."""
        if self.mixed:
            from .mixed import MixedOperator

            return MixedOperator(body, *self.moduli(body))
        return ElasticOperator(body, *self.moduli(body))

    def moduli(self, body: Body) -> tuple[Array, Array]:
        """Return μ and κ at the integration points, each (q, e); Pa."""
        shape = body.quadrature.weights.shape
        if self.white is None:
            return np.full(shape, self.gray.mu), np.full(shape, self.gray.kappa)
        share = cortex_indicator(body, self.layers)
        gray, white = self.gray, self.white
        return white.mu + share * (gray.mu - white.mu), white.kappa + share * (gray.kappa - white.kappa)


def at_points(body: Body, state: State, name: str, *components: int) -> Array | None:
    """Return a field at the integration points, (*components, q, e), or None if no process writes it.

    Raises ValueError for a field of another shape.
    """
    values = state.fields.get(name)
    wanted = (*components, *body.quadrature.weights.shape)
    if values is not None and np.shape(values) != wanted:
        raise ValueError(
            f"the field {name!r} has shape {np.shape(values)}; it must be {wanted}: values at each "
            "integration point, see body.quadrature."
        )
    return values


class ElasticOperator:
    """Elasticity on one body: shape function products and entry places, computed once."""

    grounds = False

    def __init__(self, body: Body, mu: Array, kappa: Array) -> None:
        self.body, self.mu, self.kappa = body, mu, kappa
        slopes = body.quadrature.derivatives
        q = slopes.shape[2]
        self.slopes = slopes.reshape(6, 2 * q)
        self.same = slope_products(slopes)
        self.mixed = (slopes[:, None, :, None] * slopes[None, :, None, :]).reshape(36, 4 * q)
        self.rows, self.columns = self._places()
        self.dofs = 2 * body.triangles[None] + np.arange(2)[:, None, None]  # (2, 6, e)
        self._grown: tuple[Array | None, Metric] | None = None
        self._undeformed = self.gradient(body.nodes.T)
        self._stretched: tuple[Array, Array] | None = None

    def _places(self) -> tuple[Integers, Integers]:
        """Return where the 78 different entries of each element matrix go, each (78, e)."""
        one, other = pairs(self.body.triangles)
        first, second = np.divmod(np.arange(36), 6)
        x = 2 * self.body.triangles
        return lower(np.concatenate([one, x[first]]), np.concatenate([other, x[second] + 1]))

    def gradient(self, values: Array) -> Array:
        """Return ∂/∂ξ at the integration points, (2, 2, q, e), of nodal vectors (2 n_nodes,)."""
        at_nodes = np.take(values.reshape(-1, 2).T, self.body.triangles, axis=1)
        return (self.slopes.T @ at_nodes).reshape(2, 2, -1, at_nodes.shape[2])

    def stretch(self, x: Array) -> Array:
        """Return ∂x/∂ξ at the displacement x (2 n_nodes,); a step is bounded where it was evaluated last."""
        if self._stretched is None or not np.array_equal(self._stretched[0], x):
            self._stretched = x.copy(), self._undeformed + self.gradient(x)
        return self._stretched[1]

    def during(self, state: State, dt: float) -> ElasticPotential:
        """Return the elastic energy with the growth and stiffness in `state`."""
        growth = at_points(self.body, state, "growth", 3)
        if self._grown is None or self._grown[0] is not growth:
            tangent = None if growth is None else self.body.tangent
            self._grown = growth, metric(self.body.quadrature, tangent, growth)
        stiffness = at_points(self.body, state, "stiffness")
        mu, kappa = (
            (self.mu, self.kappa) if stiffness is None else (stiffness * self.mu, stiffness * self.kappa)
        )
        return ElasticPotential(self, self._grown[1], mu, kappa)


@dataclass(frozen=True)
class ElasticPotential(SimplePotential):
    """The elastic energy of one growth state, as a function of the displacement."""

    operator: ElasticOperator
    metric: Metric
    mu: Array
    kappa: Array

    @cached_property
    def rest(self) -> float:
        """The energy ∫ 3μ/2 that cancels in the stress-free state."""
        return 1.5 * float(np.vdot(self.metric.weights, self.mu))

    def stretch(self, x: Array) -> Array:
        """Return H = ∂x/∂ξ, shape (2, 2, q, e), of the displacement x (2 n_nodes,)."""
        return self.operator.stretch(x)

    def evaluate(self, x: Array) -> ElasticEvaluation | None:
        """Return energy and derivatives at x, or None where J* <= 0 somewhere."""
        H = self.stretch(x)
        J = self._jacobian(H)
        if not J.min() > 0:  # also catches NaN
            return None
        return ElasticEvaluation(self, H, J)

    def _jacobian(self, H: Array) -> Array:
        return np.asarray(self.metric.delta * determinant(H))

    def largest_step(self, x: Array, direction: Array) -> float:
        """Return the step in (0, 1] at which det ∂x/∂ξ has lost at most 90 % anywhere."""
        now, linear, square = determinant_along(self.stretch(x), self.operator.gradient(direction))
        return first_loss(0.9 * now, linear, square)

    def observe(self, x: Array) -> dict[str, Array]:
        """Return von Mises stress, pressure (from the 3D Cauchy stress, Pa) and J*, each (q, e)."""
        at = self.evaluate(x)
        if at is None:
            return {}
        stress = von_mises(self.mu, deformation(at.H, self.metric.D), self.metric.out2, at.I1, at.J)
        return {"von_mises": stress, "pressure": -self.kappa * (at.J - 1.0), "jacobian": at.J}

    def measure(self, x: Array) -> dict[str, float]:
        """Return the smallest J*."""
        return {"min_jacobian": float(self._jacobian(self.stretch(x)).min())}


class ElasticEvaluation:
    """Elastic energy at one configuration, with gradient and Hessian on demand."""

    def __init__(self, potential: ElasticPotential, H: Array, J: Array) -> None:
        self.potential, self.H, self.J = potential, H, J
        self.curved = True
        m = potential.metric
        self.HB = times_symmetric(H, m.B)
        self.I1 = first_invariant(H, self.HB, m.out2)
        self.law = potential.mu, potential.kappa, self.I1, J, material.shrink(J)
        density = material.energy(*self.law)
        self.energy = float(np.vdot(m.weights, density))
        self.grain = 1e-15 * (abs(self.energy) + potential.rest)

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        return material.slopes(*self.law)

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
        forces = operator.slopes @ P.reshape(2, -1, P.shape[3])  # (2, 6, e)
        total = add_up(operator.dofs, forces, 2 * operator.body.nodes.shape[1])
        return total, float(np.vdot(shear, shear))

    def hessian(self, convexity: float) -> Hessian:
        """Return the tangent, with the share `convexity` of its negative part at each point taken away."""
        operator, m, (a, b) = self.potential.operator, self.potential.metric, self._slopes
        c1, c2 = material.curvatures(*self.law)
        same, mixed = tangents(m, self.H, self.HB, self._cofactor, (a, b, c1, c2), convexity)
        q, e = a.shape
        values = np.empty((78, e))
        np.matmul(operator.same, same.reshape(2, 3 * q, e), out=values[:42].reshape(2, 21, e))
        np.matmul(operator.mixed, mixed.reshape(4 * q, e), out=values[42:])
        return Hessian(operator.rows, operator.columns, values, lasting=True)
