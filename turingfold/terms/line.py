"""Loads along a line of a body: integration along it, and forces that do not change with the displacement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Integers, add_up
from ..geometry.body import Body
from ..geometry.curve import Curve
from ..parts import Entries, Evaluation, Hessian, Potential

Number = TypeVar("Number", np.float64, np.int64)

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)
# derivative of the quadratic shape functions (start, middle, end) and their values at the Gauss points
DERIVATIVES = np.stack([GAUSS - 0.5, -2 * GAUSS, GAUSS + 0.5])
SHAPES = np.stack([0.5 * GAUSS * (GAUSS - 1), 1 - GAUSS**2, 0.5 * GAUSS * (GAUSS + 1)])


class Line:
    """A line of a body's nodes, with g integration points on each of its m edges.

    nodes: in order along the line, (n,); n is even where it closes.  edges: start, middle and end of each,
    (3, m).  dofs: 2·node + component of these, (3, 2, m).  speed: ds/dξ, (g, m).  tangent: (2, g, m).
    """

    def __init__(self, body: Body, nodes: Integers) -> None:
        self.nodes, self.n_dofs = nodes, body.nodes.size
        self.curve = Curve(body.nodes[:, nodes], closed=len(nodes) % 2 == 0)
        self.edges = self.by_edge(nodes)
        self.dofs = 2 * self.edges[:, None] + np.arange(2)[None, :, None]
        along = np.einsum("kim,kg->igm", self.curve.segments, DERIVATIVES)
        self.speed = np.hypot(*along)
        self.tangent = along / self.speed

    def by_edge(self, values: NDArray[Number]) -> NDArray[Number]:
        """Return values at the line's nodes, (n,), by start, middle and end of its edges, (3, m)."""
        path = np.append(values, values[:1]) if self.curve.closed else values
        return np.stack([path[:-2:2], path[1:-1:2], path[2::2]])

    def nodal(self, forces: Array) -> Array:
        """Add contributions (3, 2, m) of the edges up to a vector (2 n_nodes,)."""
        return add_up(self.dofs, forces, self.n_dofs)


@dataclass(frozen=True)
class DeadLoad(Potential):
    """Forces that do not change with the displacement, (2 n_nodes,): energy -f·x."""

    forces: Array

    def evaluate(self, x: Array) -> DeadEvaluation:
        """Return energy and gradient at x."""
        return DeadEvaluation(self.forces, x)


class DeadEvaluation(Evaluation):
    """Energy of dead loads at one displacement; it has no curvature."""

    has_hessian = False

    def __init__(self, forces: Array, x: Array) -> None:
        work = forces * x
        self.forces, self.energy = forces, -float(work.sum())
        self.round_off = 1e-15 * float(np.abs(work).sum())

    def gradient(self) -> tuple[Array, float]:
        """Return minus the forces and their sum of squares."""
        return -self.forces, float(self.forces @ self.forces)

    def hessian(self, convexity: float) -> Hessian:
        """Return no entries."""
        none = np.zeros(0, dtype=np.int64)
        return Hessian(Entries(none, none), np.zeros(0), constant=False)
