"""Growth tensors: G = g_t t⊗t + g_n n⊗n + g_z e_z⊗e_z, with t and n of the nearest pial point."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..checks import between, finite, instance, one_of, positive
from ..errors import InadmissibleStateError
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..state import State
from .histories import History, Linear
from .zones import Zone, checked_zones, gain, local_thickness

OUT_OF_PLANE = ("fixed", "tangential")
LAYERS = ("sigmoid", "sharp")
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(16)


class GrowthLaw(ABC):
    """A process that gives growth as a function of time, whatever the steps taken; writes "growth".

    out_of_plane: "fixed" (g_z = 1, plane strain) or "tangential" (g_z = g_t, growth of area).
    """

    out_of_plane: str

    @property
    def reads(self) -> tuple[str, ...]:
        """Nothing."""
        return ()

    @property
    def writes(self) -> tuple[str, ...]:
        """Growth factors along tangent, normal and z, (3, q, e)."""
        return ("growth",)

    def start(self, body: Body, state: State, seed: int) -> dict[str, Array]:
        """Return the growth at the scene's start."""
        return self._field(body, state, state.time)

    def advance(self, body: Body, state: State, dt: float) -> dict[str, Array]:
        """Return the growth one step later."""
        return self._field(body, state, state.time + dt)

    @abstractmethod
    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return the tangential and the normal growth factor at a time, each (q, e)."""

    def _field(self, body: Body, state: State, time: float) -> dict[str, Array]:
        along, across = self.factors(body, state, time)
        out = along if self.out_of_plane == "tangential" else np.ones_like(along)
        growth = np.stack([along, across, out])
        if not growth.min() > 0:
            raise InadmissibleStateError(
                f"{type(self).__name__}: the growth factor reaches {growth.min():.3g} at t = {time:.4g} but "
                "must be positive; use factors closer to 1, a shorter run, or a history that levels off.",
                time=time,
            )
        return {"growth": growth}


@dataclass(frozen=True, kw_only=True)
class TangentialGrowth(GrowthLaw):
    """Tangential growth of cortex and core, radial growth and isotropic swelling of the core; writes
    "growth".

    g_t = core·swelling + θ (cortex - core·swelling),
    g_n = radial_core·swelling + θ (radial_cortex - radial_core·swelling).
    cortex, core, radial_cortex, radial_core, swelling_core: factors at the end of the history.
    out_of_plane: "fixed" (g_z = 1) or "tangential" (g_z = g_t, growth of area); the buckling threshold
    differs.
    modulation: share by which the pattern changes the cortex's growth, g - 1 → (g - 1)(1 + m (2û - 1));
    it is what a pattern without tension can act through. Then "pattern" is read.
    zones: regions where g_t - 1 and g_n - 1, or the cortical thickness, are multiplied by factors.
    thinning: share of its thickness that the cortex loses per unit of time, T(t) = T (1 - thinning·t).
    Raises ValueError for factors that are not positive, and for a changing thickness of sharp layers.
    """

    cortex: float = 1.9
    core: float = 1.0
    radial_core: float = 1.0
    swelling_core: float = 1.0
    out_of_plane: str = "fixed"
    layers: str = "sigmoid"
    history: History = field(default_factory=Linear)
    modulation: float = 0.0
    radial_cortex: float = 1.0
    zones: tuple[Zone, ...] = ()
    thinning: float = 0.0

    def __post_init__(self) -> None:
        for name in ("cortex", "core", "radial_cortex", "radial_core", "swelling_core"):
            positive(name, getattr(self, name), remedy="1 is no growth, 1.9 growth by 90 %")
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        one_of("layers", self.layers, LAYERS)
        instance("history", self.history, History, "Linear() or Exponential()")
        if abs(finite("modulation", self.modulation)) > 1:
            raise ValueError(
                f"modulation={self.modulation:g} must be between -1 and 1, or growth would shrink."
            )
        object.__setattr__(self, "zones", checked_zones(self.zones))
        between("thinning", self.thinning, 0.0, 1.0)
        if self.layers == "sharp" and (self.thinning or any(zone.thickness != 1.0 for zone in self.zones)):
            raise ValueError('layers="sharp" follow the mesh at any thickness; use layers="sigmoid" here.')

    @property
    def reads(self) -> tuple[str, ...]:
        """Nothing, or the pattern if it modulates growth."""
        return ("pattern",) if self.modulation else ()

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return g_t and g_n at a time."""
        cortex, core, deep, outer, swelling = (
            self.history.factor(final, time)
            for final in (self.cortex, self.core, self.radial_core, self.radial_cortex, self.swelling_core)
        )
        thickness = local_thickness(body, self.zones) * thinned(self.thinning, time)
        share = cortex_indicator(body, self.layers, thickness)
        most = np.full_like(share, cortex)
        if self.modulation:
            pattern = body.at_quadrature(body.cortex, state["pattern"])
            most = 1.0 + (cortex - 1.0) * (1.0 + self.modulation * (2.0 * pattern - 1.0))
        along = core * swelling + share * (most - core * swelling)
        across = deep * swelling + share * (outer - deep * swelling)
        local = gain(body, self.zones)
        return 1.0 + local * (along - 1.0), 1.0 + local * (across - 1.0)


@dataclass(frozen=True, kw_only=True)
class RateGrowth(GrowthLaw):
    """Tangential growth at a constant relative rate in a cortex that thins; writes "growth".

    dG/dt = rate θ(y/T(t)) (I - n⊗n) G, so g_t = exp(rate ∫ θ dt), with T(t) = T (1 - thinning·t): the law of
    the public code of Choi et al. 2025, which has rate = 1.9 and T = 0.1 - 0.05 t of the radius. It passes
    g_t = 1.9 at t = 0.338 and reaches 6.69 at t = 1.
    radial_rate: the same along the normal, 0 there.  zones: regions with other rates or thickness.
    out_of_plane: "fixed" (g_z = 1) or "tangential" (g_z = g_t).
    """

    rate: float = 1.9
    thinning: float = 0.5
    radial_rate: float = 0.0
    zones: tuple[Zone, ...] = ()
    out_of_plane: str = "fixed"

    def __post_init__(self) -> None:
        between("rate", self.rate, -10.0, 10.0, "it is relative growth per unit of time")
        between("radial_rate", self.radial_rate, -10.0, 10.0, "it is relative growth per unit of time")
        between("thinning", self.thinning, 0.0, 1.0)
        object.__setattr__(self, "zones", checked_zones(self.zones))
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return g_t and g_n at a time."""
        # the whole history again, so that growth does not depend on the steps taken
        thinned(self.thinning, time)  # the cortex must last until then
        thickness = local_thickness(body, self.zones)
        spent = np.zeros_like(thickness)
        for node, weight in zip(0.5 * (1.0 + GAUSS), 0.5 * WEIGHTS, strict=True):
            now = thickness * thinned(self.thinning, time * float(node))
            spent += time * weight * cortex_indicator(body, "sigmoid", now)
        spent *= gain(body, self.zones)
        return np.exp(self.rate * spent), np.exp(self.radial_rate * spent)


def thinned(thinning: float, time: float) -> float:
    """Return the share of the cortical thickness left at `time`; raises InadmissibleStateError at none."""
    left = 1.0 - thinning * time
    if not left > 0:
        raise InadmissibleStateError(
            f"thinning={thinning:g} leaves no cortex at t = {time:.4g}; it must be less than {1 / time:.4g} "
            "for a run of that length.",
            time=time,
        )
    return left


