"""An equilibrium, what finding it cost, and what it leaves for the next one."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from ..arrays import Array, Integers
from .linear import Solver
from .problem import Configuration
from .sparsity import Sparsity


@dataclass
class Effort:
    """What was spent: iterations, factorisations, and seconds by kind of work."""

    iterations: int = 0
    factorizations: int = 0
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, part: str, since: float) -> float:
        """Book the time since `since` to a part of the work and return the present time."""
        now = perf_counter()
        self.seconds[part] = self.seconds.get(part, 0.0) + now - since
        return now


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """An equilibrium: its configuration, relative residual, and the inertia of its tangent.

    negative_pivots: the number of independent directions in which the energy, with the incremental terms of
    inertia and drag where there are any, falls; 0 at a minimum. Where no walls touch, it may be that of a
    place NEAR it: in strain, three thousandths of the way from the last one.
    """

    at: Configuration
    residual: float
    negative_pivots: int

    @property
    def x(self) -> Array:
        """Displacement, (2 n_nodes,)."""
        return self.at.x

    @property
    def energy(self) -> float:
        """Energy; J per m of depth."""
        return self.at.energy

    @property
    def stable(self) -> bool:
        """Whether it is a minimum."""
        return self.negative_pivots == 0


@dataclass(frozen=True, eq=False)
class Memory:
    """What a restart needs for the same bits.

    changing: places of the matrix that contact brought in.  convexity: level of convexity that was needed.
    point: displacement where the kept tangent was made.  missed: by how much the last prediction missed its
    equilibrium, as a share of the way to it.
    """

    changing: Integers
    convexity: int
    point: Array | None
    missed: float


@dataclass(frozen=True, eq=False)
class Tangent:
    """A factorised tangent and the displacement where it was made; of use until the next is factorised.

    constant: the number of its Hessians if their places are constant, else 0, as where walls touch.
    """

    point: Array
    constant: int
    sparsity: Sparsity
    values: Array
    solver: Solver

    def length(self, d: Array) -> float:
        """Return the length √(d·K d) of displacements of the free unknowns, which weighs them by strain."""
        return float(np.sqrt(max(float(d @ self.sparsity.product(self.values)(d)), 0.0)))
