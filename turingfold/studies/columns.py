"""The numbers that a study tabulates of each of its points: what they are, and their units."""

from __future__ import annotations

from typing import NamedTuple


class Column(NamedTuple):
    """What a column of a table holds; unit: "m", "J/m", ..., "" for pure numbers."""

    label: str
    unit: str = ""

    @property
    def heading(self) -> str:
        """The label with the unit."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


NUMBERS = {
    "growth": Column("largest growth factor"),
    "folds": Column("sulci"),
    "least_fold_depth": Column("least depth of a sulcus", "m"),
    "gyrification_index": Column("gyrification index"),
    "closed_gyrification_index": Column("gyrification index against the closing"),
    "sulcal_depth": Column("mean depth of sulci", "m"),
    "registration": Column("registration with the pattern"),
    "registration_p": Column("share of phases that register as well"),
    "pattern_half_waves": Column("half waves of the pattern"),
    "energy": Column("energy", "J/m"),
    "min_jacobian": Column("smallest elastic volume ratio"),
    "self_intersections": Column("crossings of the boundary"),
    "saddles": Column("states that are no minimum"),
    "snaps": Column("states reached by a snap"),
    "area_growth": Column("area over that at rest"),
    "elements_through_cortex": Column("elements through the cortex"),
    "steps": Column("steps"),
    "newton_iterations": Column("Newton iterations"),
    "seconds": Column("run time", "s"),
}
