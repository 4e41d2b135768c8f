"""Barriers against two directions that turn past each other, as those of two walls or of a triangle's sides.

A pair has some nodes and, at each of its places, two directions α and β that are linear in them. A measure of
both over its bound, z(α, β), is kept above zero; where it is small it has the sign of β × α. Energies and
lengths are in the caller's units.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Booleans, Integers


def barrier_slope(z: Array | float) -> Array:
    """Return the derivative of b(z) = -(z - 1)² ln z."""
    return np.asarray(-2 * (z - 1) * np.log(z) - (z - 1) ** 2 / z)


def cross(directions: Array) -> Array:
    """Return β × α of directions (2, ..., 2)."""
    alpha, beta = directions
    return np.asarray(beta[..., 0] * alpha[..., 1] - beta[..., 1] * alpha[..., 0])


def dot(directions: Array) -> Array:
    """Return α · β of directions (2, ..., 2)."""
    return np.asarray(np.sum(directions[0] * directions[1], axis=-1))


@dataclass(frozen=True, eq=False)
class PairBarrier(ABC):
    """Energy Σ w b(z) of pairs with 0 < z < 1.

    nodes: of each pair, (n, c).  shares: of the nodes in α and β at each place, (2, p, n).  bound: of the
    measure, where z is 1, (p, c).  weight: w, (p, c).  floor: of β × α, 0 or (p, c).
    """

    nodes: Integers
    shares: Array
    bound: Array
    weight: Array
    floor: Array | float = 0.0

    @abstractmethod
    def measure(self, directions: Array) -> Array:
        """Return what is compared with the bound, (...), for directions (2, ..., 2)."""

    @abstractmethod
    def derivatives(self, directions: Array) -> tuple[Array, Array]:
        """Return the first, (k, 4), and second, (k, 4, 4), derivatives of the measure in (α, β)."""

    def closing(self, directions: Array) -> Booleans:
        """Return whether directions, (2, ..., 2), that are parallel are so because the pair has closed."""
        return np.ones(directions.shape[1:-1], dtype=bool)

    def directions(self, points: Array) -> Array:
        """Return α and β at each place, (2, p, c, 2), of nodes at `points` (m, 2)."""
        found = self.shares @ points[self.nodes].reshape(len(self.nodes), -1)
        return found.reshape(*self.shares.shape[:2], -1, 2)

    def at(self, points: Array) -> ClosePairs:
        """Return the pairs and places that the barrier acts on where the nodes are at `points`, (m, 2)."""
        directions = self.directions(points)
        measure = self.measure(directions)
        place, pair = np.nonzero((measure > 0) & (measure < self.bound))
        z = measure[place, pair] / self.bound[place, pair]
        return ClosePairs(self, place, pair, directions[:, place, pair], z)

    def largest_step(self, start: Array, end: Array, share: float = 0.9) -> float:
        """Return `share` of the way to where a pair first closes, at most 1; exactly.

        β × α is quadratic along the way. Pairs that are closed already are not seen.
        """
        first, last = self.directions(start), self.directions(end)
        way = last - first
        constant, square = cross(first) - self.floor, cross(way)
        linear = cross(last) - self.floor - constant - square
        # where all Bernstein coefficients are positive, there is no root
        some = np.minimum(np.minimum(constant, constant + 0.5 * linear), constant + linear + square) <= 0
        first, way, constant, linear, square = (
            values[..., some] if values.ndim == 2 else values[:, some]
            for values in (first, way, constant, linear, square)
        )
        discriminant = linear**2 - 4 * square * constant
        half = -0.5 * (linear + np.copysign(np.sqrt(np.maximum(discriminant, 0.0)), linear))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            steps = np.stack([half / square, constant / half])  # the roots, without cancellation
        met = (discriminant >= 0) & (steps > 0) & (steps <= 1)
        steps = np.where(met, steps, 0.0)
        met &= linear + 2 * square * steps <= 0  # from open to closed, not the other way
        met &= self.closing(first[:, None] + steps[..., None] * way[:, None])
        return min(1.0, share * float(np.min(steps, initial=np.inf, where=met)))


@dataclass(frozen=True, eq=False)
class ClosePairs:
    """The k pairs and places that a barrier acts on; z in (0, 1)."""

    barrier: PairBarrier
    place: Integers
    pair: Integers
    directions: Array
    z: Array

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not self.z.size

    @property
    def energy(self) -> float:
        """Σ w b(z)."""
        return float(-self._weight @ ((self.z - 1) ** 2 * np.log(self.z)))

    def add_forces(self, forces: Array) -> None:
        """Add the gradient of the energy to that of the nodes, (m, 2)."""
        slope = self._weight / self._bound * barrier_slope(self.z)
        first = self.barrier.derivatives(self.directions)[0].reshape(-1, 2, 2)
        by_node = np.einsum("k,kax,akn->nkx", slope, first, self._shares)
        np.add.at(forces, self.barrier.nodes[:, self.pair], by_node)

    def hessian(self, definite: bool) -> tuple[Integers, Integers, Array]:
        """Return rows, columns (2 m + x) and values of the second derivatives, each (k, 2 n, 2 n).

        definite: whether negative eigenvalues of each pair, in terms of α and β, are set to zero.
        """
        z, bound = self.z, self._bound
        curvature = -2 * np.log(z) - 4 * (z - 1) / z + (z - 1) ** 2 / z**2
        first, second = self.barrier.derivatives(self.directions)
        inner = (self._weight * curvature / bound**2)[:, None, None] * first[:, :, None] * first[:, None]
        inner = inner + (self._weight * barrier_slope(z) / bound)[:, None, None] * second
        if definite:
            values, vectors = np.linalg.eigh(inner)
            inner = np.einsum("kie,ke,kje->kij", vectors, np.maximum(values, 0.0), vectors)
        blocks = inner.reshape(-1, 2, 2, 2, 2)
        by_node = np.einsum("akn,kaxby,bkm->knxmy", self._shares, blocks, self._shares, optimize=True)
        size = 2 * len(self.barrier.nodes)
        dofs = (2 * self.barrier.nodes[:, self.pair].T[..., None] + np.arange(2)).reshape(-1, size)
        rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None])
        return rows, columns, by_node.reshape(-1, size, size)

    @property
    def _weight(self) -> Array:
        return self.barrier.weight[self.place, self.pair]

    @property
    def _bound(self) -> Array:
        return self.barrier.bound[self.place, self.pair]

    @property
    def _shares(self) -> Array:
        return self.barrier.shares[:, self.place]
