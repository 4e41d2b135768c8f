"""What the mixed element computes at its integration points: places, stresses, tangents, tables of integrals.

Each element has 7 shape functions (six quadratic ones and the cubic bubble 27 ξη(1-ξ-η)), 18 integration
points and a linear pressure of its own. The points lie on the corners, on the sides and inside: where
walls crease, the energy sees a triangle, or its bubble, that turns over at a side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from skfem import Basis, ElementTriP2

from ...arrays import Array
from ...geometry.body import Body
from ...geometry.quadrature import Quadrature
from .kinematics import Metric, cofactor, determinant, first_invariant, times_symmetric
from .material import shrink

# The rule of order 6 that has points at corners, middles and quarters of sides and two triples inside: seven
# conditions for seven unknowns, solved numerically. Weights are of a triangle of area 1/2.
QUARTER = 0.25
TRIPLES = (0.0, 0.5, 0.12427226524253289, 0.42505670753484204)  # b of (b, b), (b, 1 - 2b), (1 - 2b, b)
WEIGHTS = (0.003483592350264027, 0.009122099217871209, 0.050592055833536646, 0.08089396335669698)
AT_QUARTERS = 0.0112874779541489
# of its range at the body's points: by how much a linear function goes beyond it at most, and any other
LINEAR, BEYOND = 0.2526, 0.35


@dataclass(frozen=True)
class Integration:
    """The integration points of the mixed element on a body.

    quadrature: of order 6.  tangent: of the nearest pial point, (2, q, e).  gradients: of the 7 shape
    functions, (7, 2q); of the bubble alone, (2, q).  linear: shape functions of the pressure, (3, q).
    shown: gradients at the body's own points, (7, 2p), and linear_shown: (3, p).
    spread, spread_back: from values at the body's points to values here and back, (q, p) and (p, q).
    diagonal_products, cross_products: of gradients, (49, 3q) and (49, 4q), to integrate tangents of one and
    of two components.
    volume: products of pressures' shape functions and gradients, (21, 2q).
    """

    quadrature: Quadrature
    tangent: Array
    gradients: Array
    linear: Array
    shown: Array
    linear_shown: Array
    spread: Array
    spread_back: Array
    diagonal_products: Array
    cross_products: Array
    volume: Array

    @property
    def bubble(self) -> Array:
        """Gradient of the bubble's shape function, (2, q)."""
        return np.asarray(self.gradients[6].reshape(2, -1))

    def spread_out(self, values: Array) -> Array:
        """Return positive values given at the body's points, (..., p, e), at the points here, (..., q, e).

        Their logarithms are extrapolated by quadratic polynomials, which keeps them positive. Where a field
        jumps inside an element these would go far beyond its range: what a linear function does not need
        is brought down smoothly to BEYOND.
        """
        logarithms = np.log(values)
        low, high = logarithms.min(axis=-2, keepdims=True), logarithms.max(axis=-2, keepdims=True)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        found = self.spread @ logarithms - middle
        free = (1 + 2 * LINEAR) * half
        room = 2 * (BEYOND - LINEAR) * half
        over = np.divide(np.abs(found) - free, room, out=np.zeros_like(found), where=room > 0)
        limited = np.where(over > 0, np.copysign(free + room * np.tanh(over), found), found)
        return np.asarray(np.exp(middle + limited))


def integration_on(body: Body) -> Integration:
    """Return the integration points of the mixed element on a body."""
    quadrature = Quadrature.of(Basis(body.mesh, ElementTriP2(), quadrature=_rule()))
    flat = quadrature.points.reshape(2, -1)
    tangent = body.pial_curves.nearest(flat)[1].reshape(quadrature.points.shape)
    here, there = quadrature.shapes, body.quadrature.shapes
    gradients = np.concatenate([quadrature.derivatives, _bubble_slope(_corners(here))[None]])
    shown = np.concatenate([body.quadrature.derivatives, _bubble_slope(_corners(there))[None]])
    q = here.shape[1]
    pairs = gradients[:, None, :, None] * gradients[None, :, None, :]  # (7, 7, m, n, q)
    equal = np.stack([pairs[:, :, 0, 0], pairs[:, :, 0, 1] + pairs[:, :, 1, 0], pairs[:, :, 1, 1]], axis=2)
    return Integration(
        quadrature=quadrature,
        tangent=tangent,
        gradients=gradients.reshape(7, 2 * q),
        linear=_corners(here),
        shown=shown.reshape(7, -1),
        linear_shown=_corners(there),
        spread=here.T @ np.linalg.pinv(there.T),
        spread_back=there.T @ np.linalg.pinv(here.T),
        diagonal_products=equal.reshape(49, 3 * q),
        cross_products=pairs.reshape(49, 4 * q),
        volume=(_corners(here)[:, None, None] * gradients).reshape(21, 2 * q),
    )


def _rule() -> tuple[Array, Array]:
    """Return points, (2, 18), and weights, (18,), of the integration on the reference triangle."""
    points = [pair for b in TRIPLES for pair in ((b, b), (b, 1 - 2 * b), (1 - 2 * b, b))]
    for a in (QUARTER, 1 - QUARTER):
        points += [(a, 0.0), (0.0, a), (a, 1 - a)]
    return np.array(points).T, np.repeat([*WEIGHTS, AT_QUARTERS, AT_QUARTERS], 3)


def _corners(quadratic: Array) -> Array:
    """Return the linear shape functions: a corner's quadratic one, and half those of its edge middles."""
    a, b, c, ab, bc, ca = quadratic
    return np.stack([a + 0.5 * (ab + ca), b + 0.5 * (ab + bc), c + 0.5 * (bc + ca)])


def _bubble_slope(linear: Array) -> Array:
    """Return the gradient of 27 λ₁λ₂λ₃ on the reference triangle, λ₁ = 1 - ξ - η; (2, q)."""
    first, second, third = linear
    return 27.0 * np.stack([third * (first - second), second * (first - third)])


@dataclass(frozen=True)
class Kinematics:
    """Deformation at the points: H = ∂x/∂ξ, H B, C = ∂J*/∂H, (2, 2, q, e); I₁, J* and J*^{-2/3}, (q, e)."""

    H: Array
    HB: Array
    C: Array
    I1: Array
    J: Array
    shrink: Array


def kinematics(H: Array, metric: Metric) -> Kinematics | None:
    """Return what follows from H, or None where J* <= 0 somewhere."""
    J = metric.delta * determinant(H)
    if not J.min() > 0:  # also catches NaN
        return None
    HB = times_symmetric(H, metric.B)
    I1 = first_invariant(H, HB, metric.out2)
    return Kinematics(H, HB, cofactor(H, metric.delta), I1, J, shrink(J))


@dataclass(frozen=True)
class Law:
    """Coefficients at the points, (q, e): P = a H B + b C; c₁, c₂ of the tangent, bulk modulus left out."""

    a: Array
    b: Array
    c1: Array
    c2: Array


def law(mu: Array, at: Kinematics, pressure: Array) -> Law:
    """Return the coefficients of the energy μ/2 (I₁ J^{-2/3} - 3) + p (J - 1) with the given p, (q, e)."""
    a = mu * at.shrink
    return Law(a, pressure - a * at.I1 / (3 * at.J), -2 * a / (3 * at.J), 5 * a * at.I1 / (9 * at.J**2))
