"""A plane section of a brain: its pial and white surfaces, and its holes, as closed curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ..arrays import Array
from ..checks import finite_array
from ..geometry.units import note_large
from .region import even_odd, nearest, segments

Cut = tuple[tuple[float, float], tuple[float, float]]
NEAR = 0.05  # of its length, at most so far from a base is what is cut off along it


@dataclass(frozen=True, eq=False)
class Section:
    """Closed curves (2, n) in m, first points not repeated; inside is what an odd number of them encloses.

    pial: around the tissue, and around what is closed off inside it, such as sulci whose walls touch.
    white: around all that lies below the cortex, holes with it.
    holes: around ventricles.
    plane: "coronal" (x to the right, y up), "sagittal" (x forward, y up), "axial" (x right, y forward).
    position: of the plane along right, anterior or superior; m, None where it is not known.
    source: where the curves come from.
    voxel: edge of the voxels whose steps the curves have; m, None where they have none.
    unit: that the file of the curves states; m, None where it states none.
    cuts: where the edge of an image cuts the tissue, the ends of each part of the curves along it, m; they
    are base_ends of `outline`.
    lacking: area by which each curve encloses less than the voxels in it, m².
    """

    pial: Sequence[Array]
    white: Sequence[Array] = ()
    holes: Sequence[Array] = ()
    plane: str = "coronal"
    position: float | None = None
    source: str = ""
    voxel: float | None = None
    unit: float | None = None
    cuts: Sequence[Cut] = ()
    lacking: float = 0.0

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
        remedy = 'say so by unit="mm" or in the file\'s header' if self.source else "give metres"
        note_large(self.source or "the section", self.pial, remedy, self.unit)

    def cut_off(self, base_ends: Any) -> list[str]:
        """Return a remark on each cut along which no base lies; base_ends: of `outline`."""
        bases = [] if base_ends is None else shapely.linestrings(np.reshape(base_ends, (-1, 2, 2)))
        told = []
        for first, last in self.cuts:
            length = float(np.hypot(last[0] - first[0], last[1] - first[1]))
            near = max(NEAR * length, 2 * (self.voxel or 0.0))
            ends = shapely.points([first, last])
            if not any(shapely.dwithin(base, ends, near).all() for base in bases):
                told.append(
                    f"the image's edge cuts the tissue off along {length:.3g} m, from ({first[0]:.4g}, "
                    f"{first[1]:.4g}) to ({last[0]:.4g}, {last[1]:.4g}) m, which is taken as pial surface; "
                    "take an image that holds it all, or give a base there, with base_ends=section.cuts"
                )
        return told

    def thickness(self) -> tuple[Array, ...]:
        """Return the thickness of the cortex at the points of each pial curve, (n,) of each; m.

        T = (|p - w| + |w - q|) / 2, with w the place of the white surface nearest to the pial point p, and q
        that of the pial surface nearest to w (Fischl & Dale 2000, PNAS 97, 11050). NaN where the way from p
        to w leaves the tissue, as in lobes that the plane cuts above their white matter.
        Raises ValueError for sections without a white surface.
        """
        if not self.white:
            raise ValueError("thickness: the section has no white surface; give it one.")
        found, tissue = [], even_odd(self.pial)
        outer, inner = segments(self.pial), segments(self.white)
        shapely.prepare(tissue)
        for loop in self.pial:
            below = nearest(loop, inner)
            back = nearest(below, outer)
            depth = 0.5 * (np.hypot(*(loop - below)) + np.hypot(*(below - back)))
            for share in (0.25, 0.5, 0.75):
                depth[~shapely.contains_xy(tissue, *(loop + share * (below - loop)))] = np.nan
            found.append(depth)
        return tuple(found)
