"""Seeded imperfections: smooth noise along the pial surface, the same on every mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import between, one_of, whole
from ..geometry.body import Body
from ..geometry.roughness import noise
from ..state import State

KINDS = ("growth", "stiffness")


@dataclass(frozen=True, kw_only=True)
class Imperfection:
    """Noise that decides where an otherwise uniform cortex folds first, on arc length, not on elements.

    of "growth": multiplies g_t - 1 (reads and rewrites "growth"; list it after the growth);
    of "stiffness": multiplies the moduli (writes "stiffness").  amplitude: standard deviation of the factor.
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
        return ("growth", "noise") if self.of == "growth" else ("stiffness",)

    def start(self, body: Body, state: State, seed: int) -> dict[str, Array]:
        """Return the noise and the field changed by it."""
        share, closed = body.pial_share(body.arc), body.pial_curve.closed
        values = noise(share, self.modes, seed, self.symmetric or body.mirror, closed)
        if self.of == "stiffness":
            return {"stiffness": np.maximum(0.1, 1.0 + self.amplitude * values)}
        return {"noise": values, **self._grown(values, state)}

    def advance(self, body: Body, state: State, dt: float) -> dict[str, Array]:
        """Return the changed growth; stiffness stays as it is."""
        return self._grown(state["noise"], state) if self.of == "growth" else {}

    def _grown(self, values: Array, state: State) -> dict[str, Array]:
        growth = state["growth"].copy()
        growth[0] = np.maximum(1.0 + (growth[0] - 1.0) * (1.0 + self.amplitude * values), 0.1 * growth[0])
        return {"growth": growth}


