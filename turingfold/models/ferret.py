"""The ferret brain of Choi et al. 2025 in units of its radius and of its shear modulus.

One material; the cortex is a tenth of the radius, grows at the rate 1.9 and thins to T (1 - t/2). P32 is
t = 0.44, where it has grown by e^{0.84} = 2.3 along its surface.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..growth.zones import HalfPlane, Zone
from ..readers.read import read_outline
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic

P32 = 0.44
VARIABLE = "FERRET_OUTLINES"  # of the environment, names the folder of outlines
BOTTOM = Zone(region=HalfPlane(point=(0, -0.4), normal=(0, 1), edge=0.2, ramp="straight"), growth=0.0)
"""No growth at the bottom (y < -0.4), with a ramp of 0.2."""


def tissue(*, bulk: float = 5.0) -> Elastic:
    """Return the material of cortex and core: shear modulus 1, bulk modulus `bulk`."""
    return Elastic(gray=NeoHookean(mu=1.0, kappa=bulk))


def circle(count: int = 240) -> Array:
    """Return points of the unit circle, (2, count)."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)])


def published_outline(folder: Path, side: str, stage: int) -> Array:
    """Return the coronal section of a hemisphere ("left", "right") at a stage from 1 to 4; (2, n), in radii.

    folder: where coronal_q25_left_stage1.csv and so on are: they do not come with turingfold.
    Raises FileNotFoundError without them, with how to make them.
    """
    file = folder / f"coronal_q25_{side}_stage{stage}.csv"
    if not file.is_file():
        what = f"there is no folder {folder}" if not folder.is_dir() else f"there is no file {file}"
        what = what if VARIABLE in os.environ else f"{VARIABLE} is not set"
        raise FileNotFoundError(
            f"{what}. This case reads outlines that do not come with turingfold: "
            "coronal_q25_left_stage1.csv, ..._left_stage4.csv and those of right, each a closed curve with "
            "the columns x,y, in units of the brain's radius. Cut them, at a quarter of the length, from the "
            "surfaces in data/continuous of github.com/garyptchoi/ferret-brain-morphogenesis (Choi et al. "
            "2025), put them into a folder, and set the environment variable FERRET_OUTLINES to it. For "
            "outlines of your own: outline(read_outline(FILE).single(), thickness=...)"
        )
    return read_outline(file, unit=1.0).single()
