"""Nearly incompressible elasticity: quadratic triangles with a bubble and a discontinuous linear pressure.

The Crouzeix-Raviart element: where κ is large, the volume of an element can only be controlled on average, and a
linear pressure p in each element does so. Eliminated, it leaves the energy

    E(x, b) = ∫ J_G μ/2 (I₁* J*^{-2/3} - 3) dA + ½ rᵀ A⁻¹ r,   r_k = ∫ J_G N_k (J* - 1) dA,
    A_kl = ∫ J_G N_k N_l / κ dA,   p = A⁻¹ r,

and as J* is affine in the bubble displacement b and the rest of the energy convex in it, the minimum over b exists
and is unique in each element. What the minimiser sees is min_b E, a function of the nodes alone.

Newton's method on it would need the pressure to follow κ (J* - 1), which a straight step overshoots. So the tangent
is built with a pressure that is an unknown of its own, p ← A⁻¹ (r + ∂r/∂x dx), and the search along a step compares
values of the augmented Lagrangian of the condition r = A p (`mixed_ray`, `MixedRay`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ..body import Body
from ..scene import Hessian, State
from . import material
from .elastic import Metric, _first_loss, metric
from .mixed_points import Kinematics, Law, deformation, kinematics, law, points_on, tangents, von_mises

Array = NDArray[np.float64]

NODES = np.r_[0:6, 7:13]  # unknowns of an element: six nodes and the bubble, first component first
BUBBLE = np.array([6, 13])
SETTLED = 1e-11  # force on a bubble at which it counts as zero, relative to the shear forces on it
ROUND_OFF = 1e-14  # movement of a bubble at which it counts as none, relative to its element
PATIENCE = 40  # iterations allowed for the bubbles
PENALTY = 20.0  # weight of the volume condition in the search, in shear moduli


class MixedOperator:
    """Nearly incompressible elasticity on one body; mu, kappa at the body's integration points, (q, e), Pa."""

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
        """Return the displacements of an element's nodes relative to its first one, and its bubble, (2, 7, e).

        Without the common part, round-off is relative to the element and not to the body: it is multiplied by κ.
        """
        nodes = x[self.dofs].reshape(2, 6, -1)
        return np.concatenate([nodes - nodes[:, :1], bubble[:, None]], axis=1)

    def rest_stretch(self, slopes: Array) -> Array:
        """Return ∂X/∂ξ, (2, 2, q, e), for slopes of the 7 shape functions, (7, 2q)."""
        corners = self.body.nodes[:, self.body.triangles]
        flat = slopes[:6].T @ (corners - corners[:, :1])
        return np.asarray(flat.reshape(2, 2, -1, corners.shape[2]))

    def during(self, state: State, dt: float) -> MixedPotential:
        """Return the elastic energy with the growth and stiffness in `state`, starting from its inner unknowns."""
        growth, stiffness = state.fields.get("growth"), state.fields.get("stiffness")
        if self._grown is None or self._grown[0] is not growth:
            spread = None if growth is None else self.points.spread_out(growth)
            self._grown = growth, metric(cast(Body, self.points), spread)
        share = np.ones_like(self.mu) if stiffness is None else self.points.spread_out(stiffness)
        bubble, pressure = state.fields.get("bubble"), state.fields.get("element_pressure")
        if bubble is None:
            bubble = np.zeros((2, self.body.triangles.shape[1]))
        return MixedPotential(self, self._grown[1], share * self.mu, share * self.kappa, bubble, pressure)


@dataclass(frozen=True)
class MixedPotential:
    """The energy of one growth state as a function of the nodal displacement; the bubbles have settled.

    bubble: where the search for them starts, (2, e).  pressure: for the tangent, (3, e); None: A⁻¹ r.
    """

    operator: MixedOperator
    metric: Metric
    mu: Array
    kappa: Array
    bubble: Array
    pressure: Array | None

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
        """Return energy and derivatives at x, or None where an element has no bubble with J* > 0 near the last."""
        H = self.stretch(x, self.bubble, self.operator.points.slopes)
        at = kinematics(H, self.metric)
        return None if at is None else MixedEvaluation(self, x, self.bubble, self.pressure, at).settled()

    def largest_step(self, x: Array, direction: Array) -> float:
        """Return the step in (0, 1] at which det ∂x/∂ξ has lost at most 90 % anywhere, the bubbles at rest."""
        at = self.evaluate(x)
        return 1.0 if at is None else self.longest(at.at.H, direction, np.zeros_like(self.bubble))

    def longest(self, H: Array, direction: Array, bubble: Array) -> float:
        """Return that step for nodes moving along direction and bubbles moving along bubble."""
        dH = self.change(direction, bubble, self.operator.points.slopes)
        now = H[0, 0] * H[1, 1] - H[0, 1] * H[1, 0]
        linear = H[0, 0] * dH[1, 1] + dH[0, 0] * H[1, 1] - H[0, 1] * dH[1, 0] - dH[0, 1] * H[1, 0]
        square = dH[0, 0] * dH[1, 1] - dH[0, 1] * dH[1, 0]
        return _first_loss(0.9 * now, linear, square)

    def finish(self, x: Array) -> dict[str, Array]:
        """Return the bubbles (2, e), m, and the pressures at the element corners (3, e), Pa, to start from."""
        at = self.evaluate(x)
        return {} if at is None else {"bubble": at.bubble, "element_pressure": at.own_pressure}

    def observe(self, x: Array) -> dict[str, Array]:
        """Return von Mises stress, pressure (from the 3D Cauchy stress, Pa) and J* at the body's points, (p, e)."""
        at = self.evaluate(x)
        if at is None:
            return {}
        points = self.operator.points
        H = self.stretch(x, at.bubble, points.shown)
        back = points.spread_back
        F = deformation(H, back @ self.metric.D)
        out2 = back @ self.metric.out2
        J = (F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]) * np.sqrt(out2)
        pressure = -np.einsum("kq,ke->qe", points.linear_shown, at.own_pressure)
        return {"von_mises": von_mises(back @ self.mu, F, out2, J), "pressure": pressure, "jacobian": J}

    def measure(self, x: Array) -> dict[str, float]:
        """Return the smallest J*."""
        at = self.evaluate(x)
        return {"min_jacobian": float(at.at.J.min()) if at is not None else float("nan")}


class MixedEvaluation:
    """The energy at one configuration; gradient and Hessian on demand."""

    def __init__(
        self, potential: MixedPotential, x: Array, bubble: Array, pressure: Array | None, at: Kinematics
    ) -> None:
        """Compute the energy of every element."""
        self.potential, self.x, self.bubble, self.at, self.curved = potential, x, bubble, at, True
        weights = potential.metric.weights
        N = potential.operator.points.linear
        self.volume = N @ (weights * (at.J - 1))  # r, (3, e)
        self.own_pressure = _times(potential.bulk, self.volume)
        self._given, self.pressure = pressure, self.own_pressure if pressure is None else pressure
        shear = material.energy(potential.mu, np.zeros_like(at.J), at.I1, at.J)
        self.shear_energies = (weights * shear).sum(0)
        self.energies = self.shear_energies + 0.5 * (self.volume * self.own_pressure).sum(0)

    @cached_property
    def energy(self) -> float:
        """E, J/m."""
        return float(self.energies.sum())

    @cached_property
    def grain(self) -> float:
        """Differences of energy below this are round-off."""
        return 1e-15 * (abs(self.energy) + self.potential.rest)

    @cached_property
    def _own_law(self) -> Law:
        N = self.potential.operator.points.linear
        return law(self.potential.mu, self.at, N.T @ self.own_pressure)

    @cached_property
    def _forces(self) -> tuple[Array, Array]:
        """Forces on the 7 shape functions, (2, 7, e), and the shear part of the point forces, (2, 2, q, e)."""
        weights, l = self.potential.metric.weights, self._own_law
        shear = (weights * l.a) * self.at.HB
        P = shear + (weights * l.b) * self.at.C
        return self.potential.operator.points.slopes @ P.reshape(2, -1, P.shape[3]), shear

    def gradient(self) -> tuple[Array, float]:
        """Return the nodal forces (2 n_nodes,) and the sum of squares of the shear part of the point forces."""
        operator = self.potential.operator
        forces, shear = self._forces
        nodal = np.bincount(
            operator.dofs.ravel(), forces[:, :6].ravel(), minlength=2 * operator.body.nodes.shape[1]
        )
        return nodal, float(np.vdot(shear, shear))

    # the bubbles

    @cached_property
    def _along_bubble(self) -> tuple[Array, Array]:
        """H B and C times the gradient of the bubble's shape function, each (2, q, e)."""
        beta = self.potential.operator.points.bubble[:, :, None]
        return (self.at.HB * beta).sum(1), (self.at.C * beta).sum(1)

    @property
    def bubbles_rest(self) -> bool:
        """Whether no force is left on the bubbles, or none that round-off would let them follow."""
        weights = self.potential.metric.weights
        size = np.abs(weights * self._own_law.a * self._along_bubble[0]).sum(1).max(0)
        if (np.abs(self._forces[0][:, 6]) <= SETTLED * size).all():
            return True
        return bool((np.abs(self._bubble_move).max(0) <= ROUND_OFF * self._sizes).all())

    @cached_property
    def _sizes(self) -> Array:
        return np.abs(self.at.H).max((0, 1, 2))

    @cached_property
    def _bubble_move(self) -> Array:
        """Newton's step of the bubbles alone, (2, e)."""
        potential, l = self.potential, self._own_law
        weights, points = potential.metric.weights, potential.operator.points
        S, C = self._along_bubble
        beta, (xx, xy, yy) = points.bubble[:, :, None], potential.metric.B
        stretch = xx * beta[0] ** 2 + 2 * xy * beta[0] * beta[1] + yy * beta[1] ** 2
        # c₁(S⊗C + C⊗S) + c₂ C⊗C = K⊗C + C⊗K with K = c₁ S + ½ c₂ C
        K = weights * (l.c1 * S + 0.5 * l.c2 * C)
        one = (K[:, None] * C[None]).sum(2)
        G = np.einsum("kq,iqe->kie", points.linear, weights * C)
        stiffness = one + one.transpose(1, 0, 2) + np.einsum("kie,kje->ije", G, _times(potential.bulk, G))
        stiffness += np.eye(2)[:, :, None] * (weights * l.a * stretch).sum(0)
        return -_solved(stiffness, self._forces[0][:, 6])

    def settled(self) -> MixedEvaluation | None:
        """Return the evaluation with the bubbles where the energy is least, or None if they are not found."""
        now = self
        for _ in range(PATIENCE):
            if now.bubbles_rest:
                return now
            now = now.relaxed()
        return None

    def relaxed(self) -> MixedEvaluation:
        """Return the evaluation after one Newton step of the bubbles, shortened where it would raise the energy."""
        move, C = self._bubble_move, self._along_bubble[1]
        loss = -(C * move[:, None]).sum(0) / self.at.J  # J* is affine in the bubble
        step = 1 / np.maximum(1.0, loss.max(0) / 0.9)
        long = np.abs(move).max(0) / self._sizes
        while True:
            there = self._moved(step * move)
            # steps below this are in the quadratic range, where round-off hides what they gain
            higher = (there.energies > self.energies) & (step * long > 1e-6)
            if not higher.any():
                return there
            step = np.where(higher, 0.5 * step, step)

    def _moved(self, move: Array) -> MixedEvaluation:
        H = self.at.H + move[:, None, None] * self.potential.operator.points.bubble[:, :, None]
        at = kinematics(H, self.potential.metric)
        assert at is not None  # the step keeps a tenth of J*
        return MixedEvaluation(self.potential, self.x, self.bubble + move, self._given, at)

    # the tangent

    def hessian(self, convexity: float) -> Hessian:
        """Return the tangent with the bubbles condensed, blended towards its positive semi-definite part."""
        operator = self.potential.operator
        K = self._stiffness if convexity == 0 else self._integrated(convexity)
        nodes, bubble = K[NODES], K[BUBBLE]
        condensed = nodes[:, NODES] - np.einsum("ipe,iqe->pqe", nodes[:, BUBBLE].transpose(1, 0, 2), _solved(
            bubble[:, BUBBLE], bubble[:, NODES]
        ))
        return Hessian(operator.rows, operator.columns, condensed[operator.low, operator.high], lasting=True)

    @cached_property
    def _stiffness(self) -> Array:
        return self._integrated(0.0)

    def _integrated(self, convexity: float) -> Array:
        """Return the element matrices of all 14 unknowns, component by component, (14, 14, e)."""
        potential, points = self.potential, self.potential.operator.points
        at_points = law(potential.mu, self.at, points.linear.T @ self.pressure)
        same, mixed = tangents(self.at, potential.metric, at_points, convexity)
        q, e = self.at.J.shape
        K = np.einsum("kie,kje->ije", self.volume_slope, _times(potential.bulk, self.volume_slope))
        equal = (points.same @ same.reshape(2, 3 * q, e)).reshape(2, 7, 7, e)
        other = (points.mixed @ mixed.reshape(4 * q, e)).reshape(7, 7, e)
        K[:7, :7] += equal[0]
        K[7:, 7:] += equal[1]
        K[:7, 7:] += other
        K[7:, :7] += other.transpose(1, 0, 2)
        return K

    @cached_property
    def volume_slope(self) -> Array:
        """∂r/∂(all 14 unknowns), (3, 14, e)."""
        points, (q, e) = self.potential.operator.points, self.at.J.shape
        weighted = self.potential.metric.weights * self.at.C
        product = points.volume @ weighted.reshape(2, 2 * q, e)
        return np.ascontiguousarray(product.reshape(2, 3, 7, e).transpose(1, 0, 2, 3)).reshape(3, 14, e)

    def follow(self, direction: Array) -> Array:
        """Return how the bubbles move with the nodes along direction (2 n_nodes,), (2, e)."""
        K = self._stiffness[BUBBLE]
        force = np.einsum("ipe,pe->ie", K[:, NODES], direction[self.potential.operator.dofs])
        return -_solved(K[:, BUBBLE], force)

    def along(self, direction: Array, decrease: float) -> MixedRay:
        """Return the ray along `direction` (2 n_nodes,); decrease: slope of the total energy along it."""
        return MixedRay(self, direction, decrease)


class MixedRay:
    """The energy along x + s dx, b + s db, as the search sees it.

    The merit is the augmented Lagrangian of r = A p with the pressure p⁺ = A⁻¹ (r + ∂r) to which Newton's step
    leads, ∫ shear energy + p⁺ᵀ r + ½ ε mᵀ A⁻¹ m, m = r - A p⁺. With ε = 1 that is the energy; with ε of the
    order of μ/κ the walls of the valley of admissible volume are no steeper than the rest of the energy.
    """

    def __init__(self, start: MixedEvaluation, direction: Array, decrease: float) -> None:
        """Choose ε such that the merit falls along the step whenever the energy does."""
        potential = start.potential
        self._from, self._direction = start, direction
        self._bubble = start.follow(direction)
        moves = potential.operator.moves(direction, self._bubble)
        change = np.einsum("kie,ie->ke", start.volume_slope, moves.reshape(14, -1))
        self._target = start.volume + change  # A p⁺
        self._pressure = _times(potential.bulk, self._target)
        stiff = (change * _times(potential.bulk, change)).sum(0)
        rest = -decrease - float(stiff.sum())  # curvature of everything but the volume
        needed = min(1.0, -2 * rest / float(stiff.sum())) if rest < 0 else 0.0
        ratio = (potential.mu / potential.kappa).max(0)
        self._epsilon = np.maximum(needed, np.minimum(1.0, PENALTY * ratio))
        self.start = self._merit(start)
        self.slope = float(start.gradient()[0] @ direction + ((1 - self._epsilon) * stiff).sum())
        self.longest = potential.longest(start.at.H, direction, self._bubble)

    def _merit(self, at: MixedEvaluation) -> float:
        miss = at.volume - self._target
        penalty = 0.5 * self._epsilon * (miss * _times(self._from.potential.bulk, miss)).sum(0)
        return float((at.shear_energies + (self._pressure * at.volume).sum(0) + penalty).sum())

    def at(self, step: float) -> tuple[float, MixedEvaluation] | None:
        """Return merit at s = step and the evaluation there, once its bubbles have settled; None if inadmissible."""
        start, potential = self._from, self._from.potential
        x, bubble = start.x + step * self._direction, start.bubble + step * self._bubble
        pressure = start.pressure + step * (self._pressure - start.pressure)
        H = potential.stretch(x, bubble, potential.operator.points.slopes)
        at = kinematics(H, potential.metric)
        if at is None:
            return None
        moved = MixedEvaluation(potential, x, bubble, pressure, at)
        settled = moved.settled()
        return None if settled is None else (self._merit(moved), settled)


def _times(matrices: Array, vectors: Array) -> Array:
    """Return A v of every element: (n, m, e) times (m, ..., e)."""
    return np.asarray(np.einsum("kle,l...e->k...e", matrices, vectors))


def _solved(matrices: Array, b: Array) -> Array:
    """Return A⁻¹ b of every element, A of shape (2, 2, e), b of shape (2, ..., e)."""
    (p, q), (r, s) = matrices
    return np.asarray(np.stack([s * b[0] - q * b[1], p * b[1] - r * b[0]]) / (p * s - q * r))
