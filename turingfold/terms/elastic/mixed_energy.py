"""The data of the mixed element's energy on one body; `mixed` says what it computes and why."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import Array
from ...geometry.body import Body
from ...parts import Entries
from .kinematics import Metric, determinant_along, first_loss
from .mixed_points import integration_on


class MixedGeometry:
    """The mixed element on one body; mu, kappa at the body's integration points, (q, e), Pa."""

    def __init__(self, body: Body, mu: Array, kappa: Array) -> None:
        """Compute the integration points and the places of the entries."""
        self.body, self.integration = body, integration_on(body)
        self.mu, self.kappa = self.integration.spread_out(mu), self.integration.spread_out(kappa)
        self.dofs = (2 * body.triangles[None] + np.arange(2)[:, None, None]).reshape(12, -1)
        self.low, self.high = np.tril_indices(12)
        one, other = self.dofs[self.low], self.dofs[self.high]
        self.entries = Entries(np.maximum(one, other), np.minimum(one, other))

    def moves(self, x: Array, bubble: Array) -> Array:
        """Return the moves of each element's nodes relative to its first one, and the bubble's, (2, 7, e).

        Without the common part round-off, which κ multiplies, is relative to the element and not to the body.
        """
        nodes = x[self.dofs].reshape(2, 6, -1)
        return np.concatenate([nodes - nodes[:, :1], bubble[:, None]], axis=1)

    def reference_jacobian(self, gradients: Array) -> Array:
        """Return ∂X/∂ξ, (2, 2, q, e), for gradients of the 7 shape functions, (7, 2q)."""
        corners = self.body.nodes[:, self.body.triangles]
        flat = gradients[:6].T @ (corners - corners[:, :1])
        return np.asarray(flat.reshape(2, 2, -1, corners.shape[2]))


@dataclass(frozen=True)
class MixedEnergy:
    """The energy of one growth state as a function of the nodal displacement; the bubbles have settled.

    bubble: where the search for them starts, (2, e).  pressure: that of the tangent, (3, e); zero at rest, it
    follows the Newton steps (`along`). The tangent is the second derivative of the energy where it is A⁻¹ r.
    """

    operator: MixedGeometry
    metric: Metric
    mu: Array
    kappa: Array
    bubble: Array
    pressure: Array

    @cached_property
    def bulk(self) -> Array:
        """A⁻¹, (3, 3, e)."""
        N = self.operator.integration.linear
        A = np.einsum("kq,lq,qe->ekl", N, N, self.metric.weights / self.kappa)
        return np.ascontiguousarray(np.moveaxis(np.linalg.inv(A), 0, 2))

    @cached_property
    def cancelling_energy(self) -> float:
        """The energy ∫ 3μ/2 that cancels in the stress-free state."""
        return 1.5 * float(np.vdot(self.metric.weights, self.mu))

    def stretch(self, x: Array, bubble: Array, gradients: Array) -> Array:
        """Return H = ∂x/∂ξ, (2, 2, q, e), of the nodal displacement x (2 n_nodes,) and the bubbles."""
        return self.operator.reference_jacobian(gradients) + self.change(x, bubble, gradients)

    def change(self, x: Array, bubble: Array, gradients: Array) -> Array:
        """Return the gradients (2, 2, q, e) of a nodal displacement (2 n_nodes,) and of bubbles alone."""
        moves = self.operator.moves(x, bubble)
        return np.asarray((gradients.T @ moves).reshape(2, 2, -1, moves.shape[2]))

    def longest(self, H: Array, direction: Array, bubble: Array) -> float:
        """Return that step for nodes moving along direction and bubbles moving along bubble."""
        dH = self.change(direction, bubble, self.operator.integration.gradients)
        now, linear, square = determinant_along(H, dH)
        return first_loss(0.9 * now, linear, square)
