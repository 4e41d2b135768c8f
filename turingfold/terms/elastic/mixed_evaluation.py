"""The mixed element at one configuration and along a Newton step; `mixed` says what it computes and why."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...arrays import Array
from ...geometry.triangles import folded_over
from ...parts import Condensed, Fields, Hessian, SearchLine
from .kinematics import cauchy, deformation, determinant, stress_fields, tangents, von_mises
from .mixed_energy import MixedEnergy
from .mixed_points import Kinematics, Law, kinematics, law

NODES = np.r_[0:6, 7:13]  # unknowns of an element: six nodes and the bubble, first component first
BUBBLE = np.array([6, 13])
SETTLED = 1e-11  # force on a bubble at which it counts as zero, relative to the shear forces on it
ROUND_OFF = 1e-14  # movement of a bubble at which it counts as none, relative to its element
PATIENCE = 40  # iterations allowed for the bubbles
PENALTY = 20.0  # weight of the volume condition in the search, in shear moduli


class MixedEvaluation(Condensed):
    """The energy at one configuration; gradient and Hessian on demand."""

    def __init__(
        self, potential: MixedEnergy, x: Array, bubble: Array, pressure: Array, at: Kinematics
    ) -> None:
        """Compute the energy of every element."""
        self.potential, self.x, self.bubble, self.at = potential, x, bubble, at
        self.pressure = pressure
        weights = potential.metric.weights
        N = potential.operator.integration.linear
        self.volume = N @ (weights * (at.J - 1))  # r, (3, e)
        self.own_pressure = _times(potential.bulk, self.volume)
        self.shear_energies = 0.5 * (weights * potential.mu * (at.I1 * at.shrink - 3.0)).sum(0)
        self.energies = self.shear_energies + 0.5 * (self.volume * self.own_pressure).sum(0)
        self.energy = float(self.energies.sum())
        self.round_off = 1e-15 * (abs(self.energy) + potential.cancelling_energy)

    @cached_property
    def _own_law(self) -> Law:
        N = self.potential.operator.integration.linear
        return law(self.potential.mu, self.at, N.T @ self.own_pressure)

    @cached_property
    def _forces(self) -> tuple[Array, Array]:
        """Forces on the 7 shape functions, (2, 7, e), and the shear part of point forces, (2, 2, q, e)."""
        weights, l = self.potential.metric.weights, self._own_law
        shear = (weights * l.a) * self.at.HB
        P = shear + (weights * l.b) * self.at.C
        return self.potential.operator.integration.gradients @ P.reshape(2, -1, P.shape[3]), shear

    def gradient(self) -> tuple[Array, float]:
        """Return the nodal forces (2 n_nodes,) and the sum of squares of the shear part of point forces."""
        operator = self.potential.operator
        forces, shear = self._forces
        nodal = np.zeros(2 * operator.body.nodes.shape[1])
        nodal += np.bincount(operator.dofs.ravel(), forces[:, :6].ravel(), minlength=len(nodal))
        return nodal, float(np.vdot(shear, shear))

    # the bubbles

    @cached_property
    def _along_bubble(self) -> tuple[Array, Array]:
        """H B and C times the gradient of the bubble's shape function, each (2, q, e)."""
        beta = self.potential.operator.integration.bubble[:, :, None]
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
        return np.asarray(np.abs(self.at.H).max((0, 1, 2)))

    @cached_property
    def _bubble_move(self) -> Array:
        """Newton's step of the bubbles alone, (2, e)."""
        potential, l = self.potential, self._own_law
        weights, points = potential.metric.weights, potential.operator.integration
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
        """Return the evaluation after a Newton step of the bubbles, shorter where it raises the energy."""
        move, C = self._bubble_move, self._along_bubble[1]
        loss = -(C * move[:, None]).sum(0) / self.at.J  # J* is affine in the bubble
        step = 1 / np.maximum(1.0, loss.max(0) / 0.9)
        long = np.abs(move).max(0) / self._sizes
        while True:
            there = self.displaced(step * move)
            # steps below this are in the quadratic range, where round-off hides what they gain
            higher = (there.energies > self.energies) & (step * long > 1e-6)
            if not higher.any():
                return there
            step = np.where(higher, 0.5 * step, step)

    def displaced(self, move: Array) -> MixedEvaluation:
        """Return the evaluation with the bubbles moved by (2, e) within the admissible range."""
        H = self.at.H + move[:, None, None] * self.potential.operator.integration.bubble[:, :, None]
        at = kinematics(H, self.potential.metric)
        assert at is not None  # the step keeps a tenth of J*
        return MixedEvaluation(self.potential, self.x, self.bubble + move, self.pressure, at)

    # the tangent

    def hessian(self, convexity: float) -> Hessian:
        """Return the tangent with the bubbles condensed, blended towards its positive semi-definite part."""
        operator = self.potential.operator
        K = self._stiffness if convexity == 0 else self._integrated(convexity)
        nodes, bubble = K[NODES], K[BUBBLE]
        condensed = nodes[:, NODES] - np.einsum(
            "ipe,iqe->pqe", nodes[:, BUBBLE].transpose(1, 0, 2), _solved(bubble[:, BUBBLE], bubble[:, NODES])
        )
        return Hessian(operator.entries, condensed[operator.low, operator.high])

    @cached_property
    def _stiffness(self) -> Array:
        return self._integrated(0.0)

    def _integrated(self, convexity: float) -> Array:
        """Return the element matrices of all 14 unknowns, component by component, (14, 14, e)."""
        potential, points = self.potential, self.potential.operator.integration
        at, l = self.at, law(potential.mu, self.at, points.linear.T @ self.pressure)
        same, mixed = tangents(potential.metric, at.H, at.HB, at.C, (l.a, l.b, l.c1, l.c2), convexity)
        q, e = at.J.shape
        K: Array = np.einsum("kie,kje->ije", self.volume_slope, _times(potential.bulk, self.volume_slope))
        equal = (points.diagonal_products @ same.reshape(2, 3 * q, e)).reshape(2, 7, 7, e)
        other = (points.cross_products @ mixed.reshape(4 * q, e)).reshape(7, 7, e)
        K[:7, :7] += equal[0]
        K[7:, 7:] += equal[1]
        K[:7, 7:] += other
        K[7:, :7] += other.transpose(1, 0, 2)
        return K

    @cached_property
    def volume_slope(self) -> Array:
        """∂r/∂(all 14 unknowns), (3, 14, e)."""
        points, (q, e) = self.potential.operator.integration, self.at.J.shape
        weighted = self.potential.metric.weights * self.at.C
        product = points.volume @ weighted.reshape(2, 2 * q, e)
        return np.ascontiguousarray(product.reshape(2, 3, 7, e).transpose(1, 0, 2, 3)).reshape(3, 14, e)

    def follow(self, direction: Array) -> Array:
        """Return how the bubbles move with the nodes along direction (2 n_nodes,), (2, e)."""
        K = self._stiffness[BUBBLE]
        force = np.einsum("ipe,pe->ie", K[:, NODES], direction[self.potential.operator.dofs])
        return -_solved(K[:, BUBBLE], force)

    def largest_step(self, direction: Array) -> float:
        """Return the step in (0, 1] at which det ∂x/∂ξ has lost at most 90 %, with the bubbles at rest."""
        return self.potential.longest(self.at.H, direction, np.zeros_like(self.bubble))

    def is_valid(self) -> bool:
        """Return whether all triangles with their bubbles are positive everywhere."""
        body = self.potential.operator.body
        return not folded_over(body.mesh, body.nodes + self.x.reshape(-1, 2).T, self.bubble).size

    def finish(self, wanted: frozenset[str]) -> Fields:
        """Return bubbles (2, e), m, and pressures at the elements' corners (3, e), Pa, to start from next.

        Also what is wanted of stress (xx, yy, xy, zz; Pa), J* and moduli (μ, κ; Pa), at the body's points.
        """
        found = {"bubble": self.bubble, "element_pressure": self.own_pressure}
        back = self.potential.operator.integration.spread_back
        if {"cauchy_stress", "elastic_volume"} & wanted:
            F, out2, I1, J, pressure = self._shown
            if "cauchy_stress" in wanted:
                found["cauchy_stress"] = cauchy(back @ self.potential.mu, -pressure, F, out2, I1, J)
            if "elastic_volume" in wanted:
                found["elastic_volume"] = J
        if "moduli" in wanted:
            found["moduli"] = np.stack([back @ self.potential.mu, back @ self.potential.kappa])
        return found

    def observe(self) -> Fields:
        """Return the 3D Cauchy stress, its von Mises stress and pressure, Pa, and J* at the body's points."""
        F, out2, I1, J, pressure = self._shown
        mu = self.potential.operator.integration.spread_back @ self.potential.mu
        shown = {"von_mises": von_mises(mu, F, out2, I1, J), "pressure": pressure, "jacobian": J}
        return shown | stress_fields(cauchy(mu, -pressure, F, out2, I1, J))

    def measure(self) -> dict[str, float]:
        """Return the smallest J* at the body's points: it has no limit at the end of a clamp, a corner."""
        return {"min_jacobian": float(self._shown[3].min())}

    @property
    def _shown(self) -> tuple[Array, Array, Array, Array, Array]:
        """F*, F*_zz², I₁, J* and pressure at the body's integration points."""
        potential, points = self.potential, self.potential.operator.integration
        H = potential.stretch(self.x, self.bubble, points.shown)
        back = points.spread_back
        F, out2 = deformation(H, back @ potential.metric.D), back @ potential.metric.out2
        I1, J = (F**2).sum(1).sum(0) + out2, determinant(F) * np.sqrt(out2)
        return F, out2, I1, J, -np.einsum("kq,ke->qe", points.linear_shown, self.own_pressure)

    def along(self, direction: Array, decrease: float) -> MixedSearchLine:
        """Return the search line along `direction` (2 n_nodes,); decrease: slope of all energy along it."""
        return MixedSearchLine(self, direction, decrease)


class MixedSearchLine(SearchLine):
    """The energy along x + s dx, b + s db, as the search sees it.

    The merit is the augmented Lagrangian of r = A p with the pressure p⁺ = A⁻¹ (r + ∂r) that a Newton step
    leads to, ∫ shear energy + p⁺ᵀ r + ½ ε mᵀ A⁻¹ m, m = r - A p⁺. With ε = 1 that is the energy; with ε of
    the order of μ/κ the walls of the valley of admissible volume are no steeper than the rest of the energy.
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
        others = -decrease - float(stiff.sum())  # curvature of everything but the volume
        needed = min(1.0, -2 * others / float(stiff.sum())) if others < 0 else 0.0
        ratio = (potential.mu / potential.kappa).max(0)
        self._epsilon = np.maximum(needed, np.minimum(1.0, PENALTY * ratio))
        self.start = self._merit(start)
        self.excess = float(((1 - self._epsilon) * stiff).sum())
        self.longest = potential.longest(start.at.H, direction, self._bubble)

    def _merit(self, at: MixedEvaluation) -> float:
        miss = at.volume - self._target
        penalty = 0.5 * self._epsilon * (miss * _times(self._from.potential.bulk, miss)).sum(0)
        return float((at.shear_energies + (self._pressure * at.volume).sum(0) + penalty).sum())

    def at(self, step: float) -> tuple[float, MixedEvaluation] | None:
        """Return merit at s = step and the evaluation there with settled bubbles; None if inadmissible."""
        start, potential = self._from, self._from.potential
        x, bubble = start.x + step * self._direction, start.bubble + step * self._bubble
        pressure = start.pressure + step * (self._pressure - start.pressure)
        H = potential.stretch(x, bubble, potential.operator.integration.gradients)
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
