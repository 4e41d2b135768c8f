"""The numbers that a study tabulates of each of its points: what they are, and their units."""

from __future__ import annotations

from typing import NamedTuple

from ..results.units import measure_unit


class Column(NamedTuple):
    """What a column of a table holds; unit: "m", "J/m", ..., "" for pure numbers."""

    label: str
    unit: str = ""

    @property
    def heading(self) -> str:
        """The label with the unit."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


LABELS = {
    "growth": "largest growth factor",
    "folds": "sulci",
    "least_fold_depth": "least depth of a sulcus",
    "gyrification_index": "gyrification index",
    "closed_gyrification_index": "gyrification index against the closing",
    "sulcal_depth": "mean depth of sulci",
    "registration": "registration with the pattern",
    "registration_p": "share of phases that register as well",
    "pattern_half_waves": "half waves of the pattern",
    "energy": "energy",
    "min_jacobian": "smallest elastic volume ratio",
    "self_intersections": "crossings of the boundary",
    "saddles": "states that are no minimum",
    "snaps": "states reached by a snap",
    "area_growth": "area over that at rest",
    "elements_through_cortex": "elements through the cortex",
    "steps": "steps",
    "newton_iterations": "Newton iterations",
    "seconds": "run time",
}
NUMBERS = {name: Column(label, measure_unit(name)) for name, label in LABELS.items()}
