"""Integration points on quadratic triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from skfem import Basis

from ..arrays import Array


@dataclass(frozen=True)
class Quadrature:
    """The body's integration points, q of them in each of e elements; the rule has positive weights only.

    derivatives: of the 6 shape functions in the reference triangle, shape (6, 2, q).
    shapes: the shape functions, (6, q).  inverse: ∂ξ/∂X, (2, 2, q, e).  weights: area of each point, (q, e).
    """

    points: Array
    shapes: Array
    derivatives: Array
    inverse: Array
    weights: Array

    @classmethod
    def of(cls, basis: Basis) -> Quadrature:
        """Return the integration points of a basis of quadratic triangles."""
        mapping, points = basis.mapping, basis.X
        values = [basis.elem.lbasis(points, i) for i in range(6)]
        return cls(
            points=np.ascontiguousarray(np.swapaxes(mapping.F(points), 1, 2)),
            shapes=np.stack([shape for shape, _ in values]),
            derivatives=np.stack([slope for _, slope in values]),
            inverse=np.ascontiguousarray(np.swapaxes(mapping.invDF(points), 2, 3)),
            weights=np.ascontiguousarray(basis.dx.T),
        )
