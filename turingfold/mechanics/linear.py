"""Sparse symmetric systems: entries gathered into a kept pattern, factorised by CHOLMOD or SuperLU.

CHOLMOD comes with the `fast` extra (cvxopt), SuperLU with scipy. A factorisation succeeds only if the matrix is
positive definite: that is what certifies a stable equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from ..scene import Hessian

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


class NotPositiveDefinite(Exception):  # noqa: N818 - an answer, not a failure
    """The matrix has a pivot that is not positive."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """Places of the lower triangle, by column and then row: `keys` = column n + row in increasing order."""

    n: int
    keys: Integers

    @cached_property
    def columns(self) -> Integers:
        """Column of each entry."""
        return self.keys // self.n

    @cached_property
    def rows(self) -> Integers:
        """Row of each entry."""
        return self.keys % self.n

    @cached_property
    def starts(self) -> Integers:
        """First entry of each column, and the number of entries."""
        return np.searchsorted(self.columns, np.arange(self.n + 1))

    def lower(self, values: Array) -> csc_matrix:
        """Return the lower triangle as a sparse matrix."""
        return csc_matrix((values, self.rows, self.starts), shape=(self.n, self.n))

    def times(self, values: Array, x: Array) -> Array:
        """Return the product of the symmetric matrix with x."""
        lower = self.lower(values)
        diagonal = values[self.rows == self.columns] if self._full_diagonal else lower.diagonal()
        return np.asarray(lower @ x + lower.T @ x - diagonal * x)

    @cached_property
    def _full_diagonal(self) -> bool:
        return int(np.sum(self.rows == self.columns)) == self.n


class Gatherer:
    """Adds the Hessians of all terms into one pattern over the free degrees of freedom.

    The pattern is kept, and so is its symbolic factorisation, as long as it has a place for every entry; places
    that contacts needed before stay in it until they outnumber the present ones.
    """

    def __init__(self, n_dofs: int, fixed: Integers) -> None:
        free = np.ones(n_dofs, dtype=bool)
        free[fixed] = False
        self.free = np.flatnonzero(free)
        self._number = np.where(free, np.cumsum(free) - 1, -1)
        self._lasting: dict[int, tuple[Hessian, Integers]] = {}
        self._base = np.zeros(0, dtype=np.int64)
        self._extra = np.zeros(0, dtype=np.int64)
        self.pattern: Pattern | None = None

    def gather(self, hessians: list[Hessian]) -> tuple[Pattern, Array]:
        """Return the pattern and the values of the sum of the Hessians."""
        keys = [None if h.lasting and id(h.rows) in self._lasting else self._keys(h) for h in hessians]
        self._make_room(hessians, keys)
        pattern = self.pattern
        assert pattern is not None
        values = np.zeros(len(pattern.keys) + 1)  # the last place collects what belongs to fixed unknowns
        for hessian, own in zip(hessians, keys, strict=True):
            slots = self._slots(pattern, own) if own is not None else self._lasting[id(hessian.rows)][1]
            if own is not None and hessian.lasting:
                self._lasting[id(hessian.rows)] = hessian, slots
            values += np.bincount(slots, hessian.values.ravel(), minlength=len(values))
        return pattern, values[:-1]

    def _keys(self, hessian: Hessian) -> Integers:
        row, column = self._number[hessian.rows.ravel()], self._number[hessian.columns.ravel()]
        key = np.minimum(row, column) * len(self.free) + np.maximum(row, column)
        key[(row < 0) | (column < 0)] = -1
        return key

    def _make_room(self, hessians: list[Hessian], keys: list[Integers | None]) -> None:
        lasting = [k for h, k in zip(hessians, keys, strict=True) if h.lasting and k is not None]
        passing = [k for h, k in zip(hessians, keys, strict=True) if not h.lasting and k is not None]
        wanted = np.unique(np.concatenate(passing)) if passing else self._extra[:0]
        wanted = wanted[wanted >= 0]
        if lasting:
            self._base = np.union1d(self._base, np.concatenate(lasting))
            self._base = self._base[self._base >= 0]
        elif self.pattern is not None and np.isin(wanted, self.pattern.keys, assume_unique=True).all():
            return
        kept = self._extra if len(self._extra) < 4 * len(wanted) else self._extra[:0]
        self._extra = np.union1d(kept, np.setdiff1d(wanted, self._base, assume_unique=True))
        self.pattern = Pattern(len(self.free), np.union1d(self._base, self._extra))
        for mark, (hessian, _) in list(self._lasting.items()):
            self._lasting[mark] = hessian, self._slots(self.pattern, self._keys(hessian))

    @staticmethod
    def _slots(pattern: Pattern, keys: Integers) -> Integers:
        slots = np.searchsorted(pattern.keys, keys)
        slots[keys < 0] = len(pattern.keys)
        return slots


class Solver(Protocol):
    """Factorises symmetric matrices of one pattern."""

    def factorize(self, values: Array) -> None:
        """Factorise; raises NotPositiveDefinite."""

    def solve(self, b: Array) -> Array:
        """Solve with the last factorisation."""


class Cholmod:
    """Supernodal Cholesky factorisation by CHOLMOD, its symbolic part done once per pattern."""

    def __init__(self, pattern: Pattern) -> None:
        from cvxopt import cholmod, matrix, spmatrix

        self._matrix, self._cholmod = matrix, cholmod
        cholmod.options["supernodal"] = 2
        n = pattern.n
        self._A = spmatrix(1.0, pattern.rows.tolist(), pattern.columns.tolist(), (n, n))
        self._factor = cholmod.symbolic(self._A)

    def factorize(self, values: Array) -> None:
        """Factorise; raises NotPositiveDefinite."""
        self._A.V = self._matrix(values)
        try:
            self._cholmod.numeric(self._A, self._factor)
        except ArithmeticError as error:
            raise NotPositiveDefinite from error

    def solve(self, b: Array) -> Array:
        """Solve with the last factorisation."""
        x = self._matrix(b)
        self._cholmod.solve(self._factor, x)
        return np.array(x).ravel()


class SuperLu:
    """LU factorisation by SuperLU in symmetric mode; the ordering is found once per pattern."""

    def __init__(self, pattern: Pattern) -> None:
        below = pattern.rows != pattern.columns
        self._n = pattern.n
        self._take = np.concatenate([np.arange(len(below)), np.flatnonzero(below)])
        self._rows = np.concatenate([pattern.rows, pattern.columns[below]])
        self._columns = np.concatenate([pattern.columns, pattern.rows[below]])
        self._order: Integers | None = None
        self._lu: SuperLU | None = None

    def factorize(self, values: Array) -> None:
        """Factorise; raises NotPositiveDefinite."""
        full = csc_matrix((values[self._take], (self._rows, self._columns)), shape=(self._n, self._n))
        options = {"SymmetricMode": True}
        if self._order is None:
            order = splu(full, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).perm_c
            self._order = np.argsort(order)
        full = full[self._order][:, self._order]
        try:
            lu = splu(full.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:  # exactly singular
            raise NotPositiveDefinite from error
        if not ((lu.U.diagonal() > 0).all() and np.array_equal(lu.perm_r, lu.perm_c)):
            raise NotPositiveDefinite
        self._lu = lu

    def solve(self, b: Array) -> Array:
        """Solve with the last factorisation."""
        assert self._lu is not None and self._order is not None
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(b[self._order])
        return x


def solver_for(pattern: Pattern) -> Solver:
    """Return the fastest solver installed for the pattern."""
    return Cholmod(pattern) if find_spec("cvxopt") else SuperLu(pattern)
