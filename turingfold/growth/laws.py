"""Growth tensors: G = g_t t⊗t + g_n n⊗n + g_z e_z⊗e_z, with t and n of the nearest pial point."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..checks import between, finite, instance, one_of, positive
from ..errors import InadmissibleStateError
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..parts import Evolution, Fields, Process
from ..state import State
from .ages import Ages
from .histories import History, Linear
from .zones import Zone, checked_zones, gain, local_thickness

OUT_OF_PLANE = ("fixed", "tangential")
FACTOR = "it is a factor: 1 is no growth, 1.9 growth by 90 %"
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(16)


def check_factor(name: str, value: float) -> None:
    """Raise ValueError for a growth factor outside 0.3 to 5, beyond which no tissue of this model goes."""
    positive(name, value, remedy=FACTOR)
    between(name, value, 0.3, 5.0, f"per cent or a fraction? {FACTOR}")


class GrowthLaw(Process):
    """A process that gives growth factors as a function of time; writes "growth".

    Growth laws of one scene multiply, factor by factor.
    out_of_plane: "fixed" (g_z = 1, plane strain) or "tangential" (g_z = g_t, growth of area).
    """

    out_of_plane: str

    @property
    def optional(self) -> tuple[str, ...]:
        """The growth by an earlier law, which it multiplies."""
        return ("growth",)

    @property
    def writes(self) -> tuple[str, ...]:
        """Growth factors along tangent, normal and z, (3, q, e)."""
        return ("growth",)

    def on(self, body: Body) -> GrowthOnBody:
        """Return the law on a body; raises ValueError for another `out_of_plane` than there is."""
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        return GrowthOnBody(self, body)

    @abstractmethod
    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return the tangential and the normal growth factor at a time, each (q, e).

        state: the fields of earlier processes at that time.
        """


@dataclass(frozen=True)
class GrowthOnBody(Evolution):
    """A growth law on one body."""

    law: GrowthLaw
    body: Body

    def start(self, state: State, seed: int) -> Fields:
        """Return the growth at the scene's start."""
        return self._at(state)

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return the growth at a time."""
        return self._at(now)

    def _at(self, state: State) -> Fields:
        law, time = self.law, state.time
        found = law.factors(self.body, state, time)
        if not isinstance(found, tuple) or len(found) != 2:
            raise ValueError(
                f"{type(law).__name__}.factors returned {str(found)[:60]}; it must be two arrays, the "
                "tangential and the normal factor."
            )
        along, across = found
        out = along if law.out_of_plane == "tangential" else np.ones_like(along)
        return {"growth": multiplied(type(law).__name__, np.stack([along, across, out]), state)}


def multiplied(law: str, growth: Array, state: State) -> Array:
    """Return growth factors times those of earlier laws; raises InadmissibleStateError if not positive."""
    if not growth.min() > 0:
        raise InadmissibleStateError(
            f"{law}: the growth factor reaches {growth.min():.3g} at t = {state.time:.4g} but must be "
            "positive; use factors closer to 1, a shorter run, or a history that levels off.",
            time=state.time,
        )
    found = growth * state["growth"] if "growth" in state else growth
    return _by_element(found) if found.ndim == 3 else found  # whose shape is refused where it is used


def _by_element(growth: Array) -> Array:
    """Return growth factors, (3, q, e), of which those that are the same all over each element are kept once.

    Of a sharp cortex that is a sixth of the memory of each state.
    """
    first = growth[:, :1]
    return np.broadcast_to(first.copy(), growth.shape) if (growth == first).all() else growth


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
    Raises ValueError for factors outside 0.3 to 5, beyond which no tissue of this model goes.
    """

    cortex: float = 1.9
    core: float = 1.0
    radial_core: float = 1.0
    swelling_core: float = 1.0
    out_of_plane: str = "fixed"
    history: History = field(default_factory=Linear)
    modulation: float = 0.0
    radial_cortex: float = 1.0
    zones: tuple[Zone, ...] = ()
    thinning: float = 0.0

    def __post_init__(self) -> None:
        for name in ("cortex", "core", "radial_cortex", "radial_core", "swelling_core"):
            check_factor(name, getattr(self, name))
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        instance("history", self.history, History, "Linear() or Exponential()")
        if abs(finite("modulation", self.modulation)) > 1:
            raise ValueError(
                f"modulation={self.modulation:g} must be between -1 and 1, or growth would shrink."
            )
        object.__setattr__(self, "zones", checked_zones(self.zones))
        between("thinning", self.thinning, 0.0, 1.0)

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
        share = cortex_indicator(body, thickness_at(body, self.zones, self.thinning, time))
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
    ages: what ages the scene's time stands for, such as Days(duration=0.44); growth does not depend on it.
    out_of_plane: "fixed" (g_z = 1) or "tangential" (g_z = g_t).
    """

    rate: float = 1.9
    thinning: float = 0.5
    radial_rate: float = 0.0
    zones: tuple[Zone, ...] = ()
    out_of_plane: str = "fixed"
    ages: Ages | None = None

    def __post_init__(self) -> None:
        if self.ages is not None:
            instance("ages", self.ages, Ages, "Days(duration=0.44)")
        between("rate", self.rate, -10.0, 10.0, "it is relative growth per unit of time")
        between("radial_rate", self.radial_rate, -10.0, 10.0, "it is relative growth per unit of time")
        between("thinning", self.thinning, 0.0, 1.0)
        object.__setattr__(self, "zones", checked_zones(self.zones))
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return g_t and g_n at a time."""
        if self.ages is not None:
            self.ages.check(time)
        # the whole history again, so that growth does not depend on the steps taken
        thinned(self.thinning, time)  # the cortex must last until then
        spent = np.zeros_like(body.quadrature.weights)
        for node, weight in zip(0.5 * (1.0 + GAUSS), 0.5 * WEIGHTS, strict=True):
            now = thickness_at(body, self.zones, self.thinning, time * float(node))
            spent += time * weight * cortex_indicator(body, now)
        spent *= gain(body, self.zones)
        return np.exp(self.rate * spent), np.exp(self.radial_rate * spent)


def thickness_at(body: Body, zones: tuple[Zone, ...], thinning: float, time: float) -> Array | None:
    """Return the cortical thickness at the integration points, (q, e) in m; None where it is the body's."""
    if not thinning and all(zone.thickness == 1.0 for zone in zones):
        return None
    return local_thickness(body, zones) * thinned(thinning, time)


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
