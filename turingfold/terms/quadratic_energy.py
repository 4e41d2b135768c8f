"""Quadratic energies ½ w (x - x₀)·K (x - x₀): springs, mass, damping."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, tril

from ..arrays import Array
from ..parts import Entries, Evaluation, Hessian, Operator, Potential, TimeStep
from ..state import State


@dataclass(frozen=True, eq=False)
class SymmetricMatrix:
    """A sparse symmetric matrix over the degrees of freedom 2·node + component, (2 n_nodes, 2 n_nodes)."""

    whole: csr_matrix

    @classmethod
    def of(cls, matrix: Any) -> SymmetricMatrix:
        """Return it from any sparse matrix; raises ValueError for one that is not symmetric."""
        whole = csr_matrix(matrix)
        if whole.shape[0] != whole.shape[1] or abs(whole - whole.T).max() > 1e-12 * abs(whole).max():
            raise ValueError(f"matrix of shape {whole.shape} must be symmetric, for it is that of an energy.")
        return cls(whole)

    @classmethod
    def from_lower(cls, hessian: Hessian, size: int) -> SymmetricMatrix:
        """Return the matrix whose lower triangle is given."""
        places = hessian.entries.rows.ravel(), hessian.entries.columns.ravel()
        lower = csr_matrix((hessian.values.ravel(), places), shape=(size, size))
        return cls(csr_matrix(lower + tril(lower, -1).T))

    @cached_property
    def diagonal(self) -> Array:
        """Its diagonal, (2 n_nodes,)."""
        return np.asarray(self.whole.diagonal())

    @cached_property
    def lower(self) -> Hessian:
        """Its lower triangle."""
        below = tril(self.whole, format="coo")
        return Hessian(Entries(below.row.astype(np.int64), below.col.astype(np.int64)), below.data)


@dataclass(frozen=True, eq=False)
class Quadratic(Potential, Operator):
    """The energy ½ weight (x - rest)·K (x - rest); what does not change in time is its own operator.

    matrix: K; N/m per m of depth.  rest: x₀, (2 n_nodes,); m.
    """

    matrix: SymmetricMatrix
    rest: Array
    weight: float = 1.0

    def during(self, state: State, step: TimeStep) -> Quadratic:
        """Return itself."""
        return self

    def evaluate(self, x: Array) -> QuadraticEvaluation:
        """Return energy and derivatives at x."""
        return QuadraticEvaluation(self, x)


class QuadraticEvaluation(Evaluation):
    """A quadratic energy at one displacement."""

    def __init__(self, potential: Quadratic, x: Array) -> None:
        self.potential, self.x = potential, x
        matrix, weight, d = potential.matrix, potential.weight, x - potential.rest
        self.force = weight * np.asarray(matrix.whole @ d)
        self.energy = 0.5 * float(self.force @ d)
        # of the products that cancel where the body moves as a whole
        self.round_off = 1e-15 * weight * float(np.abs(matrix.diagonal) @ d**2)

    def gradient(self) -> tuple[Array, float]:
        """Return the forces and their sum of squares."""
        return self.force, float(self.force @ self.force)

    def hessian(self, convexity: float) -> Hessian:
        """Return the weighted matrix as it is: energies of springs, mass and damping are convex."""
        lower = self.potential.matrix.lower
        return Hessian(lower.entries, self.potential.weight * lower.values)
