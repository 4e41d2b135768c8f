"""The Turing pattern of the cortical band as a process: a certified steady pattern that others read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..checks import one_of, positive, whole
from ..scene import State
from .kinetics import Array, Kinetics
from .modes import Mode, mode_with, scaled
from .reaction_diffusion import Discretisation, Integers, ReactionDiffusion, discretise
from .stability import Conditions, conditions
from .steady import SteadyState, refine, settle

if TYPE_CHECKING:
    from ..body import Body


@dataclass(frozen=True)
class Turing:
    """Steady Turing pattern on the cortical band, with a chosen number of half waves along it.

    kinetics: the reaction; must be Turing-unstable at `ratio`.
    half_waves: of the pattern along the whole pial surface; the diffusivities are scaled so that the band's own
        Laplace mode with that many half waves is the one that grows fastest. Even numbers give a symmetric
        pattern with a peak of the activator at the apex; the half of a mirror-symmetric body holds half as many.
    ratio: d_inhibitor / d_activator; default the kinetics' published one.
    start: "mode" starts from that mode, "noise" from random values at the nodes (the number of half waves may
        then differ from the fastest by some).
    amplitude: of the start, relative to the steady state (absolute where that is 0).
    symmetric: make the pattern mirror-symmetric about the middle of the pial surface; needs even half_waves.
    elements: 2 for isoparametric quadratic elements, 1 for linear ones.

    Writes "activator" and "inhibitor" (kinetics' units) and "pattern", the activator from 0 to 1, each of
    shape (n_band_nodes,). Raises ValueError if the kinetics are not Turing-unstable or the band cannot hold the
    half waves, NotConvergedError if no stable pattern is reached.
    """

    kinetics: Kinetics
    half_waves: int = 24
    _: KW_ONLY
    ratio: float | None = None
    initial: str = "mode"
    amplitude: float = 0.05
    symmetric: bool = False
    degree: int = 2

    reads: ClassVar[tuple[str, ...]] = ()
    writes: ClassVar[tuple[str, ...]] = ("activator", "inhibitor", "pattern")

    def __post_init__(self) -> None:
        """Check the options, and the kinetics for a Turing instability."""
        if not isinstance(self.kinetics, Kinetics):
            raise ValueError(f"kinetics={self.kinetics!r} must be a kinetics such as Schnakenberg().")
        whole("half_waves", self.half_waves, at_least=1)
        one_of("initial", self.initial, ("mode", "noise"))
        positive("amplitude", self.amplitude, at_most=0.5)
        if self.degree not in (1, 2):
            raise ValueError(f"degree={self.degree!r} must be 1 or 2.")
        if self.symmetric and self.half_waves % 2:
            raise ValueError(
                f"half_waves={self.half_waves} is odd, and an odd number of half waves is not mirror-symmetric; "
                "use an even number or symmetric=False."
            )
        at_ratio(self.kinetics, self.ratio)

    def start(self, body: Body, state: State, seed: int) -> dict[str, Array]:
        """Return the steady pattern's fields."""
        pattern = self.pattern(body, seed)
        activator, inhibitor = pattern.activator_first
        low, high = activator.min(), activator.max()
        return {"activator": activator, "inhibitor": inhibitor, "pattern": (activator - low) / (high - low)}

    def advance(self, body: Body, state: State, dt: float) -> dict[str, Array]:
        """Return nothing: the pattern is steady on the undeformed band."""
        return {}

    def design(self, body: Body) -> Design:
        """Return the diffusivities for this body, the mode they favour, and the band's discretisation."""
        along = self.half_waves
        if body.mirror:
            if along % 2:
                raise ValueError(f"half_waves={along} must be even on the half of a mirror-symmetric body.")
            along //= 2
        space = discretise(body.cortex.mesh, 1)
        line = _pial_line(body, space.size)
        mode = mode_with(space, along, line, space.area / body.thickness, body.thickness)
        found = at_ratio(self.kinetics, self.ratio).scaled_to(mode.value)
        _check_resolution(found, space.edge)
        return Design(found, mode, space, line)

    def pattern(self, body: Body, seed: int = 0) -> Pattern:
        """Return the certified steady pattern on a body."""
        design = self.design(body)
        found = design.conditions
        coarse = ReactionDiffusion(design.space, self.kinetics, found.d_u, found.d_v)
        shape = self._start_shape(body, design, seed)
        level = np.array(found.steady_state)
        activator = level[0 if found.activator == "u" else 1]
        size = self.amplitude * (abs(activator) if activator else 1.0)
        begin = level[:, None] + size * np.outer(found.fastest_direction, shape)
        settled = settle(coarse, begin)
        if self.degree == 1:
            return Pattern(design, coarse, settled)
        fine = ReactionDiffusion(discretise(body.cortex.mesh, 2), self.kinetics, found.d_u, found.d_v)
        return Pattern(design, fine, refine(fine, settled, _to_quadratic(body, settled.state)))
