"""Swelling of a coated gel: the coat takes up solvent that diffuses in from the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import erfc

from ..arrays import Array
from ..checks import one_of, positive
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..state import State
from .laws import OUT_OF_PLANE, GrowthLaw


@dataclass(frozen=True, kw_only=True)
class SurfaceSwelling(GrowthLaw):
    """Isotropic swelling of the coat as solvent reaches it; writes "growth".

    g = 1 + θ(y) (final - 1) c(y, t) along tangent and normal, θ(y) = 1/(1 + exp(10 (y/T - 1))) the coat, and
    c = erfc(y/√(4 D t)) the solvent that has come to depth y from a surface that is kept wet.
    final: stretch of the wet coat.  diffusivity: D, m² per unit of time.
    out_of_plane: "fixed" (g_z = 1, plane strain) or "tangential" (g_z = g).
    """

    final: float = 2.0
    diffusivity: float
    out_of_plane: str = "fixed"

    def __post_init__(self) -> None:
        positive("final", self.final, remedy="1 is no swelling, 2 doubles every length")
        positive("diffusivity", self.diffusivity)
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return the stretch at a time, twice."""
        reached = np.sqrt(4 * self.diffusivity * time)
        wet = erfc(body.depth / reached) if time > 0 else np.zeros_like(body.depth)
        stretch = 1.0 + cortex_indicator(body) * (self.final - 1.0) * wet
        return stretch, stretch
