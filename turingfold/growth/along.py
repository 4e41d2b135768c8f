"""Growth that is given along the pial surface: by values at evenly spaced places."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..checks import finite_array, instance, one_of
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..state import State
from .histories import History, Linear
from .laws import OUT_OF_PLANE, GrowthLaw


@dataclass(frozen=True, kw_only=True)
class GrowthMap(GrowthLaw):
    """Tangential growth of the cortex, different from place to place; writes "growth".

    g_t = 1 + θ (g(s) - 1), g piecewise linear in the arc length s of the nearest pial point.
    cortex: factors at the end of the history at evenly spaced places, from one end of the pial surface,
    counter-clockwise, to the other; round a closed one, where it begins and ends anywhere, the first factor
    follows the last.  out_of_plane: "fixed" (g_z = 1) or "tangential" (g_z = g_t).
    Raises ValueError for fewer than two factors, or one that is not positive.
    """

    cortex: tuple[float, ...]
    out_of_plane: str = "fixed"
    history: History = field(default_factory=Linear)

    def __post_init__(self) -> None:
        values = finite_array("cortex", self.cortex, (None,))
        if values.size < 2 or not values.min() > 0:
            raise ValueError(f"cortex={self.cortex!r} must be two or more positive growth factors.")
        object.__setattr__(self, "cortex", tuple(values.tolist()))
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        instance("history", self.history, History, "Linear() or Exponential()")

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return g_t and g_n = 1 at a time."""
        values = np.array([self.history.factor(final, time) for final in self.cortex])
        share = body.pial_share(body.arc)
        if body.pial_curve.closed:
            local = np.interp(share, np.linspace(0, 1, len(values) + 1), np.append(values, values[0]))
        else:
            local = np.interp(share, np.linspace(0, 1, len(values)), values)
        along = 1.0 + cortex_indicator(body) * (local - 1.0)
        return along, np.ones_like(along)
