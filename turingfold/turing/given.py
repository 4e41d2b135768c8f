"""A pattern that is given along the pial surface, where it was measured or is to be found by a fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import finite_array, one_of
from ..geometry.body import Body
from ..geometry.surface_table import BETWEEN, Places, checked_places, evenly, values_at
from ..parts import Evolution, Fields, Process
from ..state import State


@dataclass(frozen=True, kw_only=True)
class PatternMap(Process):
    """A pattern û(s) in place of a Turing pattern's, s the nearest pial point; writes "pattern".

    û weighs the tension of axons and other loads: 0 where they do not pull, 1 where they pull with their
    strength. Each value is a parameter of `sensitivity` and `fit`: "PatternMap.values.3".
    values: û, two or more; pure numbers.
    places, between: as of `GrowthMap`.
    Raises ValueError for fewer than two values or what is not finite, and for places off the surface.
    """

    values: tuple[float, ...]
    places: Places | None = None
    between: str = "linear"

    def __post_init__(self) -> None:
        values = finite_array("values", self.values, (None,))
        if values.size < 2:
            raise ValueError(f"values={self.values!r} must be two or more numbers.")
        object.__setattr__(self, "values", tuple(values.tolist()))
        if self.places is not None:
            object.__setattr__(self, "places", checked_places(self.places, values.size, "values"))
        one_of("between", self.between, BETWEEN)

    @property
    def reads(self) -> tuple[str, ...]:
        """Nothing."""
        return ()

    @property
    def writes(self) -> tuple[str, ...]:
        """The pattern, at the nodes of the cortical band."""
        return ("pattern",)

    def on(self, body: Body) -> PatternOnBody:
        """Return the pattern on a body; raises ValueError for places off its surface, none on half a body."""
        places = self.places or evenly(body, len(self.values), "PatternMap")
        nodes = body.nodes[:, body.cortex.nodes]
        return PatternOnBody(values_at(body, places, np.array(self.values), self.between, nodes))


@dataclass(frozen=True, eq=False)
class PatternOnBody(Evolution):
    """A pattern that stays; pattern: (n_band_nodes,)."""

    pattern: Array

    def start(self, state: State, seed: int) -> Fields:
        """Return the pattern."""
        return {"pattern": self.pattern}

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return nothing: it stays."""
        return {}
