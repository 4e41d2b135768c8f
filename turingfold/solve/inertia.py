"""Signs of the eigenvalues of symmetric sparse matrices, counted by the pivots of a factorisation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from ..arrays import Array, Integers
from ..errors import NotConvergedError
from .memory import SUPERLU, check_memory
from .sparsity import Sparsity


def negative_pivots(sparsity: Sparsity, values: Array) -> int:
    """Return the number of negative eigenvalues of a symmetric matrix (see `sparsity.Sparsity`)."""
    return Indefinite(sparsity).factorize(values).negative


SHIFTS = (1e-10, -1e-10, 1e-8)  # of the diagonal, in units of the largest entry
UNSEEN = 1e-3  # relative change of a solution by such a shift


@dataclass(frozen=True)
class Factors:
    """A factorisation P A Pᵀ = L D Lᵀ; `negative` counts negative entries of D, that is eigenvalues of A."""

    lu: SuperLU
    order: Integers
    negative: int

    def solve(self, b: Array) -> Array:
        """Return A⁻¹ b, for b of shape (n,)."""
        x = np.empty_like(b)
        x[self.order] = self.lu.solve(b[self.order])
        return x


class Indefinite:
    """Factorises symmetric, possibly indefinite matrices of one sparsity by SuperLU, rows in order."""

    def __init__(self, sparsity: Sparsity) -> None:
        """Find the ordering; raises OutOfMemoryError where its factors do not fit into memory."""
        check_memory(sparsity.n, len(sparsity.keys), SUPERLU)
        self._n = sparsity.n
        self._on_diagonal = sparsity.rows == sparsity.columns
        marks = np.arange(1.0, len(sparsity.keys) + 1)  # of the entries, to find them again after reordering
        unit = symmetric(sparsity, np.where(sparsity.rows == sparsity.columns, 1.0 + sparsity.n, 1e-3))
        options = {"SymmetricMode": True}
        ordering = splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        self._order: Integers = np.argsort(ordering.perm_c)
        self._places = symmetric(sparsity, marks)[self._order][:, self._order].tocsc()
        self._places.sort_indices()  # splu would do so in place, and part the entries from their marks
        self._take = self._places.data.astype(np.int64) - 1

    def factorize(self, values: Array) -> Factors:
        """Return the factors; raises NotConvergedError for a singular matrix.

        A pivot that comes out as zero by chance is avoided by a shift of the diagonal far below the smallest
        eigenvalue that is of use; the shift is tried at a few sizes, and must not show in a solution.
        """
        largest, b = float(np.abs(values).max()), np.cos(np.arange(self._n))
        for shift in (0.0, *(share * largest for share in SHIFTS)):
            try:
                found = self._factors(values + shift * self._on_diagonal if shift else values)
            except NotConvergedError as error:
                failed = error
                continue
            if not shift or abs(shift) * np.linalg.norm(found.solve(b)) < UNSEEN * np.linalg.norm(b):
                return found
        raise failed

    def _factors(self, values: Array) -> Factors:
        places = self._places
        matrix = csc_matrix((values[self._take], places.indices, places.indptr), shape=(self._n, self._n))
        try:
            lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise NotConvergedError("the tangent is exactly singular") from error
        if not np.array_equal(lu.perm_r, lu.perm_c):
            raise NotConvergedError("the tangent has a zero pivot")
        return Factors(lu, self._order, int(np.sum(lu.U.diagonal() < 0)))


def symmetric(sparsity: Sparsity, values: Array) -> csc_matrix:
    """Return the whole matrix whose lower triangle is given."""
    row, column = sparsity.rows, sparsity.columns
    below = row != column
    rows = np.concatenate([row, column[below]])
    columns = np.concatenate([column, row[below]])
    entries = np.concatenate([values, values[below]])
    return csc_matrix((entries, (rows, columns)), shape=(sparsity.n, sparsity.n))
