"""Patterns that only a large, local disturbance starts: the uniform state is stable, and yet not alone."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from ..checks import finite_array, instance, one_of, positive
from ..geometry.body import Body
from ..parts import Fields
from ..state import State
from .kinetics.base import Kinetics
from .pattern import normalised
from .process import Morphogens, Steady, on_quadratic, refuse_negative
from .reaction_diffusion import ReactionDiffusion, discretise
from .steady import continue_on_finer, settle

UNEVEN = 0.01  # by how much seeds are stronger at the end of the surface
FLAT = 1e-3  # share of the height of the seeds below which nothing is left of them


@dataclass(frozen=True)
class SeededPattern(Morphogens):
    """Steady pattern on the cortical band that grows from local disturbances of a stable uniform state.

    No Turing instability is needed: the spots and stripes of Gray and Scott's model grow, split and spread
    from seeds that are large enough (Pearson, Science 261, 189, 1993), where every small disturbance dies.
    kinetics: the reaction.  d_u, d_v: diffusivities, m² per unit of the kinetics' time.
    disturbed: (u, v) of the seeds.  uniform: (u, v) elsewhere, a steady state of the kinetics; by default its
    first one.
    places: middles of the seeds, in shares of the whole pial surface's length from its start, also of half a
    body.  width: of a seed along the surface, m; it reaches through the whole band. Seeds are stronger by 1 %
    at the surface's end than at its start, as patterns that are their own mirror image may stand still and be
    unstable.
    activator: the species, "u" or "v", that is read as the activator.
    time: longest run, in units of the kinetics' time. Spots push each other apart ever more slowly: where
    disturbances of a pattern grow more slowly than 1/time it counts as steady.

    Writes "activator", "inhibitor" and "pattern", as `Turing` does. Raises ValueError for places outside
    [0, 1], seeds that no node lies in and a uniform state that is none; NotConvergedError where the
    disturbances die or no stable pattern is reached.
    """

    kinetics: Kinetics
    _: KW_ONLY
    d_u: float
    d_v: float
    disturbed: tuple[float, float]
    places: tuple[float, ...]
    width: float
    activator: str = "v"
    uniform: tuple[float, float] | None = None
    time: float = 1e5

    def __post_init__(self) -> None:
        """Check the options."""
        instance("kinetics", self.kinetics, Kinetics, "GrayScott(F=0.04, k=0.06)")
        for name in ("d_u", "d_v", "width", "time"):
            positive(name, getattr(self, name))
        one_of("activator", self.activator, ("u", "v"))
        finite_array("disturbed", self.disturbed, (2,))
        places = finite_array("places", self.places, (None,))
        if places.size == 0 or places.min() < 0 or places.max() > 1:
            raise ValueError(f"places={self.places!r} must be shares of the pial length, from 0 to 1.")
        if self.uniform is None and not self.kinetics.steady_states():
            raise ValueError(f"{type(self.kinetics).__name__} has no steady state; use other parameters.")
        level = finite_array("uniform", self.level, (2,))
        rates = np.array(self.kinetics.rates(*level[:, None])).ravel()
        if np.abs(rates).max() > 1e-6 * max(1.0, np.abs(level).max()):
            raise ValueError(
                f"uniform={self.uniform!r} is not steady, its rates are {rates.tolist()}; the steady states "
                f"are {self.kinetics.steady_states()}."
            )

    @property
    def level(self) -> tuple[float, float]:
        """The uniform state, (u, v)."""
        return self.uniform if self.uniform is not None else self.kinetics.steady_states()[0]

    def on(self, body: Body) -> SeededOnBody:
        """Return the pattern on a body."""
        return SeededOnBody(self, body)


class SeededOnBody(Steady):
    """A pattern of one body."""

    def __init__(self, pattern: SeededPattern, body: Body) -> None:
        """Make the linear and quadratic elements of the band."""
        self.pattern = pattern
        mesh = body.cortex.mesh
        self.linear, self.quadratic = (
            ReactionDiffusion(discretise(mesh, degree), pattern.kinetics, pattern.d_u, pattern.d_v)
            for degree in (1, 2)
        )
        self.mesh = mesh
        curve = body.pial_curve
        along = curve.nearest(self.linear.space.nodes)[2]
        self.along = along / curve.length
        whole = curve.length * (2.0 if body.mirror else 1.0)
        if max(pattern.places) * whole > curve.length * (1 + 1e-12):
            raise ValueError(f"places={pattern.places!r}: half a body has the shares 0 to 0.5.")
        apart = np.abs(along[:, None] - whole * np.array(pattern.places))
        if curve.closed:
            apart = np.minimum(apart, curve.length - apart)
        self.seeds = apart <= 0.5 * pattern.width
        if not self.seeds.any(axis=0).all():
            raise ValueError(
                f"width={pattern.width:g} m: no node of the band lies in a seed so narrow; make it wider "
                f"than an element, {self.linear.space.edge:.3g} m."
            )

    def start(self, state: State, seed: int) -> Fields:
        """Return the steady pattern's fields."""
        own = self.pattern
        level = np.array(own.level)[:, None]
        strength = self.seeds.any(axis=1) * (1.0 + UNEVEN * self.along)
        begin = level + strength * (np.array(own.disturbed)[:, None] - level)
        drift = 1 / own.time
        settled = settle(
            self.linear, begin, until=own.time, steps=20_000, tolerated=drift, deadline=self.deadline,
            least=FLAT * np.ptp(begin, axis=1),
        )  # fmt: skip
        guess = on_quadratic(settled.state, self.mesh)
        found = continue_on_finer(
            self.quadratic, settled, guess, tolerated=drift, deadline=self.deadline
        ).state
        refuse_negative(own.kinetics, found)
        activator, inhibitor = found if own.activator == "u" else found[::-1]
        return {"activator": activator, "inhibitor": inhibitor, "pattern": normalised(activator)}
