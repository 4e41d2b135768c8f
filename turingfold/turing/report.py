"""What linear theory predicts for a kinetics on a body: a table, and the dispersion relation with modes."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.body import Body
from .kinetics.base import Kinetics
from .modes import Mode, largest_isolating_ratio, spectrum
from .process import Turing
from .stability import Conditions, conditions_at_ratio, dispersion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, VERMILION, GREY = "#0072b2", "#d55e00", "#777777"


@dataclass(frozen=True, eq=False)
class StabilityReport:
    """Conditions, the Laplace modes of a band up to twice the growing ones, and the half waves designed for.

    Without a body, or where nothing grows, there are no modes and diffusivities are relative to the
    activator's.
    """

    conditions: Conditions
    modes: tuple[Mode, ...] = ()
    half_waves: int = 0

    @property
    def growing(self) -> tuple[Mode, ...]:
        """The modes that grow."""
        low, high = self.conditions.band
        return tuple(mode for mode in self.modes if low < mode.value < high)

    @property
    def isolated(self) -> bool:
        """Whether the mode designed for is the only one that grows."""
        return len(self.growing) == 1

    def __str__(self) -> str:
        """Return the conditions and a line per mode that grows."""
        lines = [str(self.conditions)]
        if self.modes:
            rates = self._rates(self.growing)
            lines.append(f"  modes of the band that grow ({len(self.growing)}):")
            lines += [
                f"    {mode.half_waves:>3} half waves along   k² = {mode.value:.6g}   rate {rate:.6g}"
                for mode, rate in zip(self.growing, rates, strict=True)
            ]
            lines.append(f"  {self._isolation()}")
        return "\n".join(lines)

    def _isolation(self) -> str:
        if self.isolated:
            return f"{self.half_waves} half waves grow alone"
        mode = next(mode for mode in self.modes if mode.half_waves == self.half_waves)
        try:
            largest = largest_isolating_ratio(self.conditions, mode, list(self.modes))
        except ValueError as error:
            return str(error)
        return f"{self.half_waves} half waves grow alone at ratios up to {largest:.6g}"

    def _rates(self, modes: tuple[Mode, ...]) -> list[float]:
        found = self.conditions
        values = np.array([mode.value for mode in modes])
        return [float(rate) for rate in dispersion(found.kinetics, found.d_u, found.d_v, values)]

    def draw(self, axes: Axes) -> None:
        """Draw the growth rate against the wave number, with the modes of the band as points."""
        found = self.conditions
        fastest = float(np.abs(found.jacobian).max() / min(found.d_u, found.d_v))
        limits = (found.band[1], 4 * found.fastest_k2, 4 * found.critical_k2, fastest)
        top = next(limit for limit in limits if limit > 0)  # NaN where there is none
        k = np.linspace(0.0, np.sqrt(1.6 * top), 400)
        rates = dispersion(found.kinetics, found.d_u, found.d_v, k**2)
        axes.plot(k, rates, color=BLUE, label="dispersion relation")
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        if self.modes:
            shown = tuple(mode for mode in self.modes if mode.value <= 1.6 * top)
            heights = np.array(self._rates(shown))
            places = np.sqrt([mode.value for mode in shown])
            grows = heights > 0
            axes.plot(
                places[grows], heights[grows], "o", color=VERMILION, label="modes of the band that grow"
            )
            axes.plot(places[~grows], heights[~grows], "o", mfc="none", mec=GREY, label="modes that decay")
            for mode, height in zip(shown, heights, strict=True):
                if mode.half_waves == self.half_waves and height > 0:
                    axes.annotate(
                        f"{mode.half_waves} half waves", (np.sqrt(mode.value), height),
                        xytext=(0, 7), textcoords="offset points", ha="center",
                    )  # fmt: skip
        peak = max(abs(found.fastest_rate), 1e-3 * float(np.abs(rates).max()))
        axes.set_ylim(-4 * peak, 2 * peak)
        axes.set_xlabel("wave number k (1/m)" if self.modes else "wave number k (1/√D$_a$)")
        axes.set_ylabel("growth rate (1/kinetic time)")
        ratio = "" if isnan(found.ratio) else f", ratio {found.ratio:g}"
        critical = "" if isnan(found.critical_ratio) else f" (critical {found.critical_ratio:.4g})"
        axes.set_title(f"{type(found.kinetics).__name__}{ratio}{critical}")
        axes.legend(frameon=False, fontsize=8)


def stability_report(
    kinetics: Kinetics, ratio: float | None = None, body: Body | None = None, half_waves: int = 24
) -> StabilityReport:
    """Examine a kinetics at a ratio, and on a body if one is given, with the diffusivities for the half
    waves.

    Raises ValueError as `Turing` does where the body cannot hold them.
    """
    found = conditions_at_ratio(kinetics, ratio)
    if body is None or not found.unstable:
        return StabilityReport(found)
    design = Turing(kinetics, half_waves=half_waves, ratio=ratio).design(body)
    modes = spectrum(design.space, 1.6 * design.conditions.band[1], design.line)
    return StabilityReport(design.conditions, tuple(modes), design.mode.half_waves)
