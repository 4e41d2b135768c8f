"""Growth tensors: G = g_t t⊗t + g_n n⊗n + g_z e_z⊗e_z, with t and n of the nearest pial point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from .body import Body
from .checks import finite, one_of, positive
from .histories import History, Linear
from .scene import InadmissibleStateError, State

Array = NDArray[np.float64]

OUT_OF_PLANE = ("fixed", "tangential")
LAYERS = ("sigmoid", "sharp")


def cortex_indicator(body: Body, layers: str = "sigmoid", thickness: float | None = None) -> Array:
    """Return the share of cortex at the integration points, (q, e).

    "sigmoid": θ(y) = 1/(1 + exp(10 (y/T - 1))) (Choi et al. 2025); "sharp": 1 in gray elements, 0 in white ones.
    """
    if layers == "sharp":
        return np.broadcast_to(body.in_cortex.astype(float), body.quadrature.weights.shape)
    return np.asarray(expit(10.0 * (1.0 - body.depth / (thickness or body.thickness))))


@dataclass(frozen=True, kw_only=True)
class TangentialGrowth:
    """Tangential growth of cortex and core, radial growth and isotropic swelling of the core; writes "growth".

    g_t = core·swelling + θ (cortex - core·swelling),  g_n = radial_core·swelling + θ (1 - radial_core·swelling).
    cortex, core, radial_core, swelling_core: factors at the end of the history.
    out_of_plane: "fixed" (g_z = 1) or "tangential" (g_z = g_t, growth of area); the buckling threshold differs.
    modulation: share by which the pattern changes the cortex's growth, g - 1 → (g - 1)(1 + m (2û - 1));
    it is what a pattern without tension can act through. Then "pattern" is read.
    Raises ValueError for factors that are not positive.
    """

    cortex: float = 1.9
    core: float = 1.0
    radial_core: float = 1.0
    swelling_core: float = 1.0
    out_of_plane: str = "fixed"
    layers: str = "sigmoid"
    history: History = Linear()
    modulation: float = 0.0

    def __post_init__(self) -> None:
        for name in ("cortex", "core", "radial_core", "swelling_core"):
            positive(name, getattr(self, name), remedy="1 is no growth, 1.9 growth by 90 %, 0.9 shrinking by 10 %")
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        one_of("layers", self.layers, LAYERS)
        if not isinstance(self.history, History):
            raise ValueError(f"history={self.history!r} must be a growth history such as Linear() or Exponential().")
        if abs(finite("modulation", self.modulation)) > 1:
            raise ValueError(f"modulation={self.modulation:g} must be between -1 and 1; more would make growth shrink.")

    @property
    def reads(self) -> tuple[str, ...]:
        """Nothing, or the pattern if it modulates growth."""
        return ("pattern",) if self.modulation else ()

    @property
    def writes(self) -> tuple[str, ...]:
        """Growth factors along tangent, normal and z, (3, q, e)."""
        return ("growth",)

    def start(self, body: Body, state: State, seed: int) -> dict[str, Array]:
        """Return the growth at the scene's start."""
        return self._at(body, state, state.time)

    def advance(self, body: Body, state: State, dt: float) -> dict[str, Array]:
        """Return the growth one step later."""
        return self._at(body, state, state.time + dt)

    def _at(self, body: Body, state: State, time: float) -> dict[str, Array]:
        cortex, core, radial, swelling = (
            self.history.factor(final, time)
            for final in (self.cortex, self.core, self.radial_core, self.swelling_core)
        )
        share = cortex_indicator(body, self.layers)
        gain = np.full_like(share, cortex)
        if self.modulation:
            pattern = body.at_quadrature(body.cortex, state["pattern"])
            gain = 1.0 + (cortex - 1.0) * (1.0 + self.modulation * (2.0 * pattern - 1.0))
        along = core * swelling + share * (gain - core * swelling)
        across = radial * swelling + share * (1.0 - radial * swelling)
        out = along if self.out_of_plane == "tangential" else np.ones_like(along)
        growth = np.stack([along, across, out])
        if not growth.min() > 0:
            raise InadmissibleStateError(
                f"TangentialGrowth: the growth factor reaches {growth.min():.3g} at t = {time:.4g}, but must stay "
                "positive; use factors closer to 1, a shorter run, or a history that levels off.",
                time=time,
            )
        return {"growth": growth}
