"""Seeded imperfections: smooth noise along the pial surface, the same on every mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import between, one_of, whole
from ..geometry.body import Body
from ..geometry.roughness import noise
from ..parts import Evolution, Fields, Process
from ..state import State

KINDS = ("growth", "moduli")


@dataclass(frozen=True, kw_only=True)
class Imperfection(Process):
    """Noise that decides where an otherwise uniform cortex folds first, on arc length, not on elements.

    of "growth": multiplies g_t - 1 (reads and rewrites "growth"; list it after the growth);
    of "moduli": multiplies the moduli (writes "modulus_factor").
    amplitude: standard deviation of the factor.
    modes: the shortest wave length is 2 L/modes, for symmetric noise L/modes.  symmetric: about the apex;
    always so on half a body.
    Raises ValueError for amplitudes outside [0, 0.3].
    """

    amplitude: float = 0.01
    of: str = "growth"
    modes: int = 80
    symmetric: bool = False

    def __post_init__(self) -> None:
        between("amplitude", self.amplitude, 0.0, 0.3, "it is the standard deviation of a factor around 1")
        one_of("of", self.of, KINDS)
        whole("modes", self.modes, at_least=1)

    @property
    def reads(self) -> tuple[str, ...]:
        """The growth it changes."""
        return ("growth",) if self.of == "growth" else ()

    @property
    def writes(self) -> tuple[str, ...]:
        """The field it changes, and the noise that goes on changing growth, (q, e)."""
        return ("growth", "noise") if self.of == "growth" else ("modulus_factor",)

    @property
    def keeps(self) -> tuple[str, ...]:
        """The noise."""
        return ("noise",)

    def on(self, body: Body) -> ImperfectionOnBody:
        """Return the imperfection on a body."""
        return ImperfectionOnBody(self, body)


@dataclass(frozen=True)
class ImperfectionOnBody(Evolution):
    """An imperfection on one body."""

    imperfection: Imperfection
    body: Body

    def start(self, state: State, seed: int) -> Fields:
        """Return the noise and the field changed by it."""
        own, body = self.imperfection, self.body
        share, closed = body.pial_share(body.arc), body.pial_curve.closed
        values = noise(share, own.modes, seed, own.symmetric or body.mirror, closed)
        if own.of == "moduli":
            return {"modulus_factor": np.maximum(0.1, 1.0 + own.amplitude * values)}
        return {"noise": values, **self._grown(values, state)}

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return the changed growth; moduli stay as they are."""
        return self._grown(before["noise"], now) if self.imperfection.of == "growth" else {}

    def _grown(self, values: Array, state: State) -> Fields:
        growth, amplitude = state["growth"].copy(), self.imperfection.amplitude
        growth[0] = np.maximum(1.0 + (growth[0] - 1.0) * (1.0 + amplitude * values), 0.1 * growth[0])
        return {"growth": growth}
