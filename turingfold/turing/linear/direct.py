"""Direct solves with the matrices of one or two species: banded LAPACK on thin bands, SuperLU otherwise.

The nodes of a thin band, taken in order along it, make matrices of small bandwidth, which LAPACK factorises
several times faster than a general sparse code. Seconds to factorise the coupled matrix of both species on
one core, banded and SuperLU: 5 409 linear nodes, half bandwidth 19: 0.005, 0.027; 7 943 quadratic nodes,
61: 0.031, 0.055; 20 417 linear nodes, 35: 0.043, 0.171. For one species multigrid does not win on a band:
with 100 856 nodes (seconds to set up and to solve) pyamg's smoothed aggregation takes 0.49 and 0.76, the
banded Cholesky factorisation 0.21 and 0.03, SuperLU 1.16 and 0.04. For both species, 198 848 nodes: SuperLU
4.1 and 0.19, banded 5.8 and 0.22, SuperLU with the nodes in nested dissection 3.9 and 0.17; two levels win.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs, dpbtrf, dpbtrs
from scipy.sparse import csc_array, csr_array, kron
from scipy.sparse.csgraph import dijkstra, reverse_cuthill_mckee
from scipy.sparse.linalg import SuperLU, splu

from ...arrays import Array, Integers

Solver = Callable[[Array], Array]
Blocks = tuple[Array, Array, Array, Array]

NARROW = 80  # half bandwidth up to which the banded factorisation is the faster one


def factorised(matrix: csc_array) -> SuperLU:
    """Factorise a sparse matrix of symmetric sparsity."""
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.1, options={"SymmetricMode": True})


def _bandwidth(rows: Integers, columns: Integers, order: Integers) -> int:
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return int(np.abs(place[rows] - place[columns]).max())


@dataclass(frozen=True, eq=False)
class Sparsity:
    """Where a scalar matrix has entries, shape (n, n) by columns, and the positions of its nodes (2, n)."""

    indices: Integers
    indptr: Integers
    nodes: Array

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.indptr) - 1

    @cached_property
    def columns(self) -> Integers:
        """Column of each entry."""
        return np.repeat(np.arange(self.size), np.diff(self.indptr))

    def matrix(self, values: Array) -> csc_array:
        """Return the sparse matrix with these entries."""
        return csc_array((values, self.indices, self.indptr), shape=(self.size, self.size))

    @cached_property
    def order(self) -> Integers:
        """Nodes in the order, of two tried, that gives the smaller bandwidth."""
        gaps = np.hypot(*(self.nodes[:, self.indices] - self.nodes[:, self.columns]))
        graph = csr_array((gaps, self.indices, self.indptr), shape=(self.size, self.size))
        distance = dijkstra(graph, indices=[0])[0]  # from anywhere to one end, from there along the band
        end = int(np.argmax(np.where(np.isfinite(distance), distance, -1.0)))
        along = dijkstra(graph, indices=[end])[0]
        orders = [np.argsort(along, kind="stable"), reverse_cuthill_mckee(graph, symmetric_mode=True)]
        tried = [np.asarray(order, dtype=np.int64) for order in orders]
        return min(tried, key=lambda order: _bandwidth(self.indices, self.columns, order))

    @cached_property
    def bandwidth(self) -> int:
        """Half bandwidth in that order."""
        return _bandwidth(self.indices, self.columns, self.order)

    @cached_property
    def _places(self) -> Integers:
        place = np.empty_like(self.order)
        place[self.order] = np.arange(self.size)
        return place

    # two species, unknowns u₀ v₀ u₁ v₁ ...

    @property
    def narrow(self) -> bool:
        """Whether the coupled matrix is worth a banded factorisation."""
        return 2 * self.bandwidth + 1 <= NARROW

    @cached_property
    def _coupled(self) -> tuple[csc_array, Integers]:
        # the sparsity, and where each entry is found in the blocks uu, uv, vu, vv laid end to end
        count = len(self.indices)
        numbers = self.matrix(np.arange(1.0, count + 1.0))
        offsets = np.array([[0, count], [2 * count, 3 * count]])
        pattern = csc_array(kron(numbers, np.ones((2, 2)), format="csc"))
        pattern.sort_indices()
        columns = np.repeat(np.arange(2 * self.size), np.diff(pattern.indptr))
        take = pattern.data.astype(np.int64) - 1 + offsets[pattern.indices % 2, columns % 2]
        return pattern, take

    def coupled(self, blocks: Blocks) -> csc_array:
        """Return the matrix of both species from the entries of its four blocks."""
        pattern, take = self._coupled
        return csc_array((np.concatenate(blocks)[take], pattern.indices, pattern.indptr), shape=pattern.shape)

    @cached_property
    def _band_places(self) -> Integers:
        # place of each entry of the four blocks in LAPACK's band storage, column by column
        half = 2 * self.bandwidth + 1
        rows, columns = 2 * self._places[self.indices], 2 * self._places[self.columns]
        pairs = [(rows + i, columns + j) for i in (0, 1) for j in (0, 1)]
        return np.concatenate([2 * half + row - column + (3 * half + 1) * column for row, column in pairs])

    def coupled_solver(self, blocks: Blocks) -> Solver:
        """Factorise the matrix of both species; the solver maps (2, n) to (2, n)."""
        if not self.narrow:
            factors = factorised(self.coupled(blocks))
            return lambda right: np.asarray(factors.solve(right.T.ravel()).reshape(-1, 2).T)
        half, order = 2 * self.bandwidth + 1, self.order
        storage = np.zeros((3 * half + 1) * 2 * self.size)
        storage[self._band_places] = np.concatenate(blocks)
        band = storage.reshape(2 * self.size, 3 * half + 1).T
        lower_upper, pivots, failed = dgbtrf(band, half, half, overwrite_ab=1)
        if failed > 0:
            raise np.linalg.LinAlgError(f"the matrix is singular at unknown {failed}")

        def solve(right: Array) -> Array:
            found, _ = dgbtrs(lower_upper, half, half, right[:, order].T.ravel(), pivots)
            answer = np.empty_like(right)
            answer[:, order] = found.reshape(-1, 2).T
            return answer

        return solve

    def scalar_solver(self, values: Array) -> Solver:
        """Factorise one symmetric positive definite matrix; the solver maps (n,) to (n,)."""
        if self.bandwidth > NARROW:
            factors = factorised(self.matrix(values))
            return lambda right: np.asarray(factors.solve(right))
        half, order = self.bandwidth, self.order
        rows, columns = self._places[self.indices], self._places[self.columns]
        lower = rows >= columns
        band = np.zeros((half + 1, self.size), order="F")
        band[(rows - columns)[lower], columns[lower]] = values[lower]
        factor, failed = dpbtrf(band, lower=1, overwrite_ab=1)
        if failed > 0:
            raise np.linalg.LinAlgError(f"the matrix is not positive definite at unknown {failed}")

        def solve(right: Array) -> Array:
            found, _ = dpbtrs(factor, right[order], lower=1)
            answer = np.empty_like(right)
            answer[order] = found
            return answer

        return solve
