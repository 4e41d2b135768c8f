"""Solvers of sparse symmetric systems: CHOLMOD or SuperLU.

CHOLMOD comes with the `fast` extra (cvxopt), SuperLU with scipy. A factorisation succeeds only if the matrix
is positive definite: that is what certifies a stable equilibrium. Multigrid is no match in two dimensions:
pyamg's smoothed aggregation took 31 to 42 times CHOLMOD's time where SuperLU took 4 to 7 times it, at 16 000
to 177 000 unknowns (tests/benchmarks/solvers.py).
"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from ..arrays import Array
from ..errors import NotConvergedError
from .inertia import Factors, Indefinite
from .memory import CHOLMOD, check_memory
from .sparsity import Sparsity
from .threads import limit_loaded


class NotPositiveDefinite(Exception):  # noqa: N818 - an answer, not a failure
    """The matrix has a pivot that is not positive."""


class Solver(Protocol):
    """Factorises symmetric matrices of one sparsity."""

    def factorize(self, values: Array) -> None:
        """Factorise; raises NotPositiveDefinite."""

    def solve(self, b: Array) -> Array:
        """Solve with the last factorisation."""


class Cholmod:
    """Supernodal Cholesky factorisation by CHOLMOD, its symbolic part done once per sparsity."""

    def __init__(self, sparsity: Sparsity) -> None:
        check_memory(sparsity.n, len(sparsity.keys), CHOLMOD)
        known = "cvxopt" in sys.modules
        from cvxopt import cholmod, matrix, spmatrix

        if not known:
            limit_loaded()  # it brings its own BLAS
        self._matrix, self._cholmod = matrix, cholmod
        cholmod.options["supernodal"] = 2
        self._A = spmatrix(1.0, matrix(sparsity.rows), matrix(sparsity.columns), (sparsity.n, sparsity.n))
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
    """Factorisation by SuperLU in symmetric mode; the ordering is found once per sparsity."""

    def __init__(self, sparsity: Sparsity) -> None:
        self._matrices = Indefinite(sparsity)
        self._factors: Factors | None = None

    def factorize(self, values: Array) -> None:
        """Factorise; raises NotPositiveDefinite."""
        try:
            factors = self._matrices.factorize(values)
        except NotConvergedError as error:
            raise NotPositiveDefinite from error
        if factors.negative:
            raise NotPositiveDefinite
        self._factors = factors

    def solve(self, b: Array) -> Array:
        """Solve with the last factorisation."""
        if self._factors is None:
            raise RuntimeError("solve before factorize")
        return self._factors.solve(b)


def solver_for(sparsity: Sparsity, name: str = "auto") -> Solver:
    """Return a solver for a sparsity: "cholmod", "superlu", or "auto", the faster one that is installed."""
    _keep_freed_memory()
    if name == "superlu" or (name == "auto" and find_spec("cvxopt") is None):
        return SuperLu(sparsity)
    return Cholmod(sparsity)


def _keep_freed_memory() -> None:
    """Let the C library keep the blocks that every factorisation takes and gives back.

    glibc returns freed memory to the system above a bound that rises to the largest block freed so far, up to
    32 MB (mallopt(3), M_MMAP_THRESHOLD). Without it each factorisation of 64 000 unknowns faults 35 MB in
    anew, a quarter of its time.
    """
    np.empty(31 * 2**20, dtype=np.uint8)  # freed at once, and never touched
