"""Triangles that are about to turn over anywhere: a barrier on det F, of which most need but a bound.

det F of a quadratic triangle is a quadratic polynomial between its six Bernstein coefficients. Where these
leave no doubt nothing else is computed; in other triangles det F is kept above zero at places, close together
on the sides and wider apart inside, where the elastic energy looks, too. `Inversion` acts on the sides at the
boundary long before, so that walls stay smooth; this one only keeps what is nearly lost.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Integers
from ..geometry.triangles import bernstein
from .inversion import Inversion, derivatives
from .pair_barrier import ClosePairs, barrier_slope, cross

LEAST, FLOOR = 0.02, 0.004  # det F below which the barrier acts, and that it has at each place
# folded bodies come down to 0.023, where `Inversion` keeps triangles at the boundary open
SIDE, INSIDE = 32, 4  # parts of a side between places, and of those as many between places inside
PLACES = np.array([
    (i, j) for i in range(SIDE + 1) for j in range(SIDE + 1 - i)
    if i * j * (SIDE - i - j) == 0 or i % INSIDE == j % INSIDE == 0
]) / SIDE  # fmt: skip
NEARLY = 0.99  # of the way to where a triangle turns over: steps may come close, as the energy says how far


class Turning:
    """Triangles of nodes (6, e) that are at `rest`, (n, 2); stiffness: as of contact."""

    def __init__(self, triangles: Integers, rest: Array, stiffness: float) -> None:
        self.triangles, self.rest, self.stiffness = triangles, rest, stiffness
        self.shares = derivatives(PLACES)
        self.bound = LEAST * bernstein(rest.T[:, triangles]).max(axis=0)

    def at(self, points: Array) -> ClosePairs:
        """Return the triangles and places that the barrier acts on, nodes at `points`, (n, 2)."""
        return self._of(self._doubtful(points)).at(points)

    def largest_step(self, start: Array, end: Array) -> float:
        """Return nearly the share of the way at whose end no triangle is turned over, at most 1."""
        step, bound = 1.0, 0.0
        while bound < 1.0:
            there = start + step * (end - start)
            bound = self._of(self._doubtful(there)).largest_step(start, there, NEARLY)
            step *= bound
        return step

    def _doubtful(self, points: Array) -> Integers:
        moved = np.take(points.T, self.triangles, axis=1)
        return np.flatnonzero((bernstein(moved) < self.bound).any(axis=0))

    def _of(self, triangles: Integers) -> Inversion:
        """Return the barrier on some triangles, (k,)."""
        nodes = self.triangles[:, triangles]
        at_rest = cross(np.einsum("apn,nkx->apkx", self.shares, self.rest[nodes]))
        weight = 0.5 * self.stiffness * at_rest / len(PLACES) * LEAST / -barrier_slope(0.5)  # of the area
        return Inversion(nodes, self.shares, (LEAST - FLOOR) * at_rest, weight, FLOOR * at_rest)
