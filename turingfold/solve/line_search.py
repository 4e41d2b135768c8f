"""How potentials follow a Newton direction, for those that have unknowns of their own inside the elements.

A nearly incompressible solid has a narrow, curved valley of admissible volume: a step along the straight
Newton direction climbs its wall, and a search on the energy alone would cut every step down. A potential
whose evaluations have `along` gives its own merit for the search, and its inner unknowns move with the step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from ..arrays import Array
from ..parts import Evaluation, Potential


class Ray(Protocol):
    """One potential along x + s d."""

    @property
    def start(self) -> float:
        """Merit at s = 0."""

    @property
    def excess(self) -> float:
        """By how much the slope of the merit at s = 0 exceeds that of the energy."""

    @property
    def longest(self) -> float:
        """Step in (0, 1] that keeps the state admissible."""

    def at(self, step: float) -> tuple[float, Evaluation] | None:
        """Return merit and evaluation at s = step, or None where the energy is infinite."""


@runtime_checkable
class Inner(Protocol):
    """An evaluation with inner unknowns."""

    def along(self, direction: Array, decrease: float) -> Ray:
        """Return the ray along `direction` (2 n_nodes,); decrease: slope of the total energy along it."""


class Straight:
    """The ray of a potential without inner unknowns: its energy is the merit."""

    excess = 0.0

    def __init__(self, potential: Potential, at: Evaluation, x: Array, direction: Array) -> None:
        """Compute the step bound."""
        self._potential, self._x, self._direction = potential, x, direction
        self.start = at.energy
        self.longest = potential.largest_step(x, direction)

    def at(self, step: float) -> tuple[float, Evaluation] | None:
        """Return energy and evaluation at s = step, or None where the energy is infinite."""
        there = self._potential.evaluate(self._x + step * self._direction)
        return None if there is None or not np.isfinite(there.energy) else (there.energy, there)


def rays(
    potentials: Sequence[Potential], at: Sequence[Evaluation], x: Array, direction: Array, decrease: float
) -> list[Ray]:
    """Return the ray of each potential from its evaluation at x."""
    return [
        e.along(direction, decrease) if isinstance(e, Inner) else Straight(p, e, x, direction)
        for p, e in zip(potentials, at, strict=True)
    ]


def has_inner(at: Sequence[Evaluation]) -> bool:
    """Return whether one of the evaluations has inner unknowns."""
    return any(isinstance(e, Inner) for e in at)


def reached(along: Sequence[Ray], step: float) -> tuple[float, list[Evaluation]] | None:
    """Return the sum of the merits and the evaluations at s = step, or None where one energy is infinite."""
    there = [ray.at(step) for ray in along]
    found = [pair for pair in there if pair is not None]
    return None if len(found) < len(there) else (sum(merit for merit, _ in found), [at for _, at in found])


def evaluations(potentials: Sequence[Potential], x: Array) -> list[Evaluation] | None:
    """Return all evaluations at x, or None where one energy is infinite."""
    found = []
    for potential in potentials:
        at = potential.evaluate(x)
        if at is None or not np.isfinite(at.energy):
            return None
        found.append(at)
    return found


def total_energy(at: Sequence[Evaluation]) -> float:
    """Return the sum of the energies."""
    return sum(e.energy for e in at)
