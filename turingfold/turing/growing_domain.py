"""Patterns on bands that grow evenly: the domain keeps its shape while its size changes by L(t).

On the initial domain, with ρ = L'/L and n growing dimensions:
∂w/∂t = D/L² ∇²w + f(w) − n ρ w; the last term is dilution.
Crampin, Gaffney, Maini (1999) Bull. Math. Biol. 61:1093.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

from ..arrays import Array
from ..checks import finite, positive, whole
from .integrators.rosenbrock import Snapshot, march
from .kinetics.base import Derivatives, Kinetics, Rates, UniformState
from .reaction_diffusion import ReactionDiffusion


@dataclass(frozen=True)
class Diluted(Kinetics):
    """Another kinetics with the loss `rate`·w of both species; negative where the tissue shrinks."""

    kinetics: Kinetics
    rate: float
    published_ratio: ClassVar[float] = 1.0

    def __post_init__(self) -> None:
        """Check the rate."""
        finite("rate", self.rate)

    @property
    def parameters(self) -> dict[str, float]:
        """Those of the kinetics."""
        return self.kinetics.parameters

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p − rate·u and q − rate·v."""
        p, q = self.kinetics.rates(u, v)
        return p - self.rate * u, q - self.rate * v

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v of the diluted rates."""
        p_u, p_v, q_u, q_v = self.kinetics.derivatives(u, v)
        return p_u - self.rate, p_v, q_u, q_v - self.rate

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return those of the kinetics without dilution."""
        return self.kinetics.steady_states()


def march_on_growing_domain(
    system: ReactionDiffusion,
    state: Array,
    size: Callable[[float], float],
    *,
    until: float,
    dimensions: int = 2,
    tolerance: float = 1e-4,
    change: float = 0.02,
) -> Iterator[Snapshot]:
    """Yield the accepted steps of a pattern on an evenly growing domain; states live on the initial domain.

    size: L(t), 1 at the start.  dimensions: n, of those in which the domain grows, 1 or 2.
    change: largest relative change of L per step; within a step the mean of 1/L² and the mean growth rate are
    used, an error of order change² per unit of growth.
    Raises ValueError if a size is not positive, NotConvergedError as `march` does.
    """
    whole("dimensions", dimensions, at_least=1)
    positive("change", change, at_most=0.5)
    positive("until", until)

    time, steps, factorizations, first = 0.0, 0, 0, None
    while time < until:
        stretch = _stretch(size, time, until, change)
        run = march(
            system, state, until=stretch, tolerance=tolerance, first=first and min(first, stretch),
            during=_Growing(system, size, dimensions, time).during,
        )  # fmt: skip
        for moment in run:
            state = moment.state
            counts = steps + moment.steps, factorizations + moment.factorizations
            yield Snapshot(time + moment.time, state, *counts)
        steps, factorizations = counts
        first = stretch / moment.steps
        time = until if time + stretch >= until * (1 - 1e-12) else time + stretch


def _stretch(size: Callable[[float], float], time: float, until: float, change: float) -> float:
    # a time over which the size changes by no more than asked for
    stretch, now = until - time, positive(f"size({time:.6g})", size(time))
    while abs(math.log(positive(f"size({time + stretch:.6g})", size(time + stretch)) / now)) > change:
        stretch *= 0.7
    return stretch


@dataclass(frozen=True, eq=False)
class _Growing:
    """The system seen from the initial domain, its size averaged over one step."""

    system: ReactionDiffusion
    size: Callable[[float], float]
    dimensions: int
    begin: float

    def during(self, time: float, step: float) -> ReactionDiffusion:
        """Return the system for the interval (begin + time, begin + time + step)."""
        start, middle, end = (self.size(self.begin + time + share * step) for share in (0.0, 0.5, 1.0))
        spread = (start**-2 + 4 * middle**-2 + end**-2) / 6  # Simpson's mean of 1/L²
        rate = self.dimensions * math.log(end / start) / step
        return replace(
            self.system,
            kinetics=Diluted(self.system.kinetics, rate),
            d_u=self.system.d_u * spread,
            d_v=self.system.d_v * spread,
        )
