"""Tissue of the human brain slice of document 1, at the 28th gestational week; SI units.

Radius 40.4 mm, cortex 2.5 mm; Young's modulus of gray matter 1389 ± 289 Pa, of white 1895 ± 592 Pa, Poisson's
ratio 0.4583.
"""

from __future__ import annotations

from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic


def tissue(
    *, young_gray: float = 1389.0, young_white: float = 1895.0, poisson: float = 0.4583,
    two_layers: bool = True,
) -> Elastic:  # fmt: skip
    """Return cortex and core, moduli in Pa; without `two_layers` the core is gray matter too."""
    gray = NeoHookean.from_young(young_gray, poisson)
    return Elastic(gray=gray, white=NeoHookean.from_young(young_white, poisson) if two_layers else None)
