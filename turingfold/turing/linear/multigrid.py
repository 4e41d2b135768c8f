"""Large systems of two species: a coarse space of aggregates, on which the long waves are solved directly.

A Turing system is indefinite only in its long waves, which a space with a ninth of the unknowns holds as
well as the mesh; Gauss-Seidel sweeps take care of the short ones, which diffusion dominates.  Smoothed
aggregation: Vaněk, Mandel, Brezina (1996) Computing 56:179.

Processor seconds of seven RODAS4 steps on band problem A to t = 20, tolerance 1e-3, linear elements, two
levels against factorisations: 20 727 nodes 1.35, 1.30; 62 172 nodes 4.2, 5.6; 198 848 nodes 15.6, 32.3.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import csc_array, csr_array, csr_matrix, diags_array

from ...arrays import Array
from .direct import Solver

KEPT = 40  # directions remembered from one right side to the next


def prolongation(stiffness: csc_array) -> csr_array:
    """Return the interpolation from smoothed aggregates to the nodes, shape (n_nodes, n_aggregates)."""
    from pyamg.aggregation.aggregate import standard_aggregation

    rows = csr_matrix(stiffness)
    aggregates, _ = standard_aggregation(rows)
    scaled = diags_array(1 / stiffness.diagonal()) @ rows
    largest = float(abs(scaled).sum(axis=1).max())  # bounds the eigenvalues
    tentative = csr_array(aggregates, dtype=np.float64)
    return csr_array(tentative - 4 / (3 * largest) * (scaled @ tentative))


class TwoLevel:
    """Solve with the coupled matrix, (2, n) to (2, n): preconditioned conjugate residuals, directions kept.

    matrix: unknowns u₀ v₀ u₁ v₁ ...  interpolate: (n, n_coarse).  coarse: solver there, (2, n_coarse).
    tolerance: of the residual relative to the right side.
    direct: factorises the matrix; called once where the iterations do not converge, and used from then on.
    """

    def __init__(
        self,
        matrix: csc_array,
        interpolate: csr_array,
        coarse: Solver,
        tolerance: float,
        direct: Callable[[], Solver],
    ) -> None:
        self.matrix = csr_matrix(matrix)
        self.interpolate, self.restrict = interpolate, csr_array(interpolate.T)
        self.coarse, self.tolerance, self.direct = coarse, tolerance, direct
        self.ways = np.empty((KEPT, matrix.shape[0]))
        self.images = np.empty_like(self.ways)  # orthonormal: matrix @ ways.T = images.T @ upper
        self.upper = np.zeros((KEPT, KEPT))
        self.count = 0
        self.factors: Solver | None = None

    def __call__(self, right: Array) -> Array:
        """Return the solution for one right side."""
        if self.factors is None:
            found = self._iterate(right.T.ravel())
            if found is not None:
                return np.asarray(found.reshape(-1, 2).T)
            self.factors = self.direct()
        return self.factors(right)

    def _iterate(self, right: Array) -> Array | None:
        enough = self.tolerance * float(np.linalg.norm(right))
        parts = np.zeros(KEPT)
        parts[: self.count] = self.images[: self.count] @ right
        residual = right - parts[: self.count] @ self.images[: self.count]
        while np.linalg.norm(residual) > enough:
            new = self.count
            if new == KEPT:
                return None
            self.ways[new] = self._cycle(residual)
            image = self.matrix @ self.ways[new]
            past = self.images[:new] @ image
            image -= past @ self.images[:new]
            length = float(np.linalg.norm(image))
            self.upper[:new, new], self.upper[new, new] = past, length
            self.images[new] = image / length
            parts[new] = self.images[new] @ residual
            residual -= parts[new] * self.images[new]
            self.count += 1
        weights = solve_triangular(self.upper[: self.count, : self.count], parts[: self.count])
        return np.asarray(weights @ self.ways[: self.count])

    def _cycle(self, right: Array) -> Array:
        from pyamg.relaxation.relaxation import gauss_seidel

        found = np.zeros_like(right)
        gauss_seidel(self.matrix, found, right, sweep="forward")
        left = (right - self.matrix @ found).reshape(-1, 2)
        found += (self.interpolate @ self.coarse((self.restrict @ left).T).T).ravel()
        gauss_seidel(self.matrix, found, right, sweep="backward")
        return found
