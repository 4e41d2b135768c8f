"""Line search: how far to go along a Newton direction."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..parts import Evaluation, Potential, SearchLine


class Straight(SearchLine):
    """The search line of a potential whose unknowns are the nodes alone: its energy is the merit."""

    def __init__(self, potential: Potential, at: Evaluation, x: Array, direction: Array) -> None:
        """Compute the step bound."""
        self._potential, self._x, self._direction = potential, x, direction
        self.start = at.energy
        self.longest = at.largest_step(direction)

    def at(self, step: float) -> tuple[float, Evaluation] | None:
        """Return energy and evaluation at s = step, or None where the energy is infinite."""
        there = self._potential.evaluate(self._x + step * self._direction)
        return None if there is None or not np.isfinite(there.energy) else (there.energy, there)
