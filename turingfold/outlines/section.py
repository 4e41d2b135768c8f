"""A plane section of a brain: its pial and white surfaces, and its holes, as closed curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import finite_array
from .units import note_large


@dataclass(frozen=True, eq=False)
class Section:
    """Closed curves (2, n) in m, first points not repeated; inside is what an odd number of them encloses.

    pial: around the tissue, and around what is closed off inside it, such as sulci whose walls touch.
    white: around all that lies below the cortex, holes with it.
    holes: around ventricles.
    plane: "coronal" (x to the right, y up), "sagittal" (x forward, y up), "axial" (x right, y forward).
    position: of the plane along right, anterior or superior; m, None where it is not known.
    source: where the curves come from.
    """

    pial: Sequence[Array]
    white: Sequence[Array] = ()
    holes: Sequence[Array] = ()
    plane: str = "coronal"
    position: float | None = None
    source: str = ""

    def __post_init__(self) -> None:
        for name in ("pial", "white", "holes"):
            given = getattr(self, name)
            if isinstance(given, np.ndarray) and given.ndim == 2:
                raise ValueError(f"{name} must be a list of curves; put the one curve in a list.")
            curves = tuple(finite_array(f"{name}[{k}]", c, (2, None)) for k, c in enumerate(given))
            for k, curve in enumerate(curves):
                if curve.shape[1] < 3:
                    raise ValueError(f"{name}[{k}] has {curve.shape[1]} points; give three or more.")
            object.__setattr__(self, name, curves)
        if not self.pial:
            raise ValueError("pial holds no curve; give at least one closed curve.")
        note_large(self.source or "the section", self.pial, "give metres")
