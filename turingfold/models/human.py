"""The human brain slice of document 1, 28th gestational week: its tissue, and what acts on it; SI units.

Radius 40.4 mm, cortex 2.5 mm; Young's modulus of gray matter 1389 ± 289 Pa, of white 1895 ± 592 Pa, Poisson's
ratio 0.4583.
"""

from __future__ import annotations

from ..geometry.body import Body
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic
from ..terms.tension import AxonalTension
from ..turing.kinetics.named import kinetics_named
from ..turing.process import Turing

HALF_WAVE = 2.115  # width of a half wave in thicknesses of the cortex: 24 of them in Figure 3, π 40.4/2.5/24


def half_waves(body: Body, width: float = HALF_WAVE) -> int:
    """Return the even number of half waves along the pial surface nearest to L/(width T), at least 2.

    width: of a half wave, in thicknesses of the cortex.
    """
    along = body.pial_curves.length * (2 if body.mirror else 1)
    return max(2, 2 * round(along / (2 * width * body.thickness)))


def tissue(
    *, young_gray: float = 1389.0, young_white: float = 1895.0, poisson: float = 0.4583,
    two_layers: bool = True,
) -> Elastic:  # fmt: skip
    """Return cortex and core, moduli in Pa; without `two_layers` the core is gray matter too."""
    gray = NeoHookean.from_young(young_gray, poisson)
    return Elastic(gray=gray, white=NeoHookean.from_young(young_white, poisson) if two_layers else None)


def pattern_and_pull(
    *, kinetics: str = "Schnakenberg", half_waves: int = 24, strength: float = 0.5, pattern: bool = True,
    tension: bool = True, patches: int | None = None, ramp: float = 0.1,
) -> tuple[tuple[Turing, ...], tuple[AxonalTension, ...]]:  # fmt: skip
    """Return the morphogens, and the tension of axons along the gray-white interface; empty where it is off.

    Without a pattern the axons pull equally at `patches` places, by default as many as it has waves.
    strength: N/m.  ramp: time over which the tension rises.
    """
    morphogens = (Turing(kinetics_named(kinetics), half_waves=half_waves),) if pattern else ()
    places = 0 if pattern else patches or max(1, half_waves // 2)
    pull = (AxonalTension(strength=strength, patches=places, ramp=ramp),) if tension else ()
    return morphogens, pull
