"""The Turing pattern of the cortical band as a process: a certified steady pattern that other parts read."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass
from time import perf_counter

import numpy as np
from skfem import MeshTri1

from ..arrays import Array, Integers
from ..checks import one_of, positive, whole
from ..errors import InadmissibleStateError, NotConvergedError, SolveError
from ..geometry.body import Body
from ..parts import Fields, LongEvolution, Process
from ..state import State
from .kinetics.base import Kinetics
from .modes import mode_with
from .pattern import Design, Pattern, pial_line
from .reaction_diffusion import ReactionDiffusion, discretise
from .stability import turing_unstable_at
from .steady import continue_on_finer, settle

WRITTEN = ("activator", "inhibitor", "pattern")
DRIFT = 1e-2  # of the rate at which the pattern forms: it may drift along a closed band that slowly


class Morphogens(Process):
    """A pattern of two species on the cortical band."""

    @property
    def writes(self) -> tuple[str, ...]:
        """Both species, and the activator from 0 to 1."""
        return WRITTEN

    @property
    def keeps(self) -> tuple[str, ...]:
        """All: a pattern is a result in itself."""
        return WRITTEN


@dataclass(frozen=True)
class Turing(Morphogens):
    """Steady Turing pattern on the cortical band, with a chosen number of half waves along it.

    kinetics: the reaction; must be Turing-unstable at `ratio`.
    half_waves: of the pattern along the whole pial surface: the diffusivities are scaled so that the band's
        own Laplace mode with that many is the one that grows fastest. Even numbers put a peak of the
        activator at the apex. The half of a mirror-symmetric body holds half as many.
    ratio: d_inhibitor / d_activator; by default the published one of the kinetics.
    initial: "mode" starts from that mode; "noise" from waves of random strength up to three times shorter,
        and the number of half waves may then come out differently.
    amplitude: of the start, relative to the activator's steady state (absolute where that is 0).
    symmetric: makes the pattern its own mirror image about the body's vertical axis x = 0.

    Round a closed band little but its curvature holds a pattern in its place: there, one may drift at less
    than a hundredth of the rate at which it forms and counts as steady; on open bands none may.

    Writes "activator" and "inhibitor" in the kinetics' units and "pattern", the activator from 0 to 1, each
    of shape (n_band_nodes,). Raises ValueError if the kinetics are not Turing-unstable or the band or its
    mesh cannot hold the half waves, NotConvergedError if no stable pattern is reached.
    """

    kinetics: Kinetics
    half_waves: int = 24
    _: KW_ONLY
    ratio: float | None = None
    initial: str = "mode"
    amplitude: float = 0.05
    symmetric: bool = False

    def __post_init__(self) -> None:
        """Check the options, and the kinetics for a Turing instability."""
        if not isinstance(self.kinetics, Kinetics):
            raise ValueError(f"kinetics={self.kinetics!r} must be a kinetics such as Schnakenberg().")
        whole("half_waves", self.half_waves, at_least=1)
        one_of("initial", self.initial, ("mode", "noise"))
        positive("amplitude", self.amplitude, at_most=0.5)
        if self.symmetric and self.half_waves % 2:
            raise ValueError(
                f"half_waves={self.half_waves} is odd, and an odd number of half waves is not "
                "mirror-symmetric; use an even number or symmetric=False."
            )
        turing_unstable_at(self.kinetics, self.ratio)

    def on(self, body: Body) -> SteadyOnBody:
        """Return the pattern on a body."""
        return SteadyOnBody(self, body)

    def design(self, body: Body) -> Design:
        """Return the diffusivities that suit the body, and the mode they favour."""
        space = discretise(body.cortex.mesh, 2)
        line, middle = pial_line(body)
        mode = mode_with(space, self._half_waves_on(body), line, space.area / body.thickness, body.thickness)
        found = turing_unstable_at(self.kinetics, self.ratio).scaled_to(mode.value)
        shortest = 2 * math.pi / math.sqrt(found.shortest_k2)
        if shortest < 2 * space.edge:
            raise ValueError(
                f"half_waves={self.half_waves}: the shortest wave the activator can make, 2π √(D_a/J_aa) = "
                f"{shortest:.4g} m, needs 2 elements, and the largest has edges of {space.edge:.4g} m; use "
                f"elements of at most {shortest / 2:.4g} m."
            )
        return Design(found, mode, space, line, middle)

    def pattern(self, body: Body, seed: int = 0, *, deadline: float = math.inf) -> Pattern:
        """Return the certified steady pattern on a body; deadline: of `time.perf_counter`, for its search."""
        design = self.design(body)
        begin = self._begin(body, design, seed)
        # linear elements lead to the pattern fastest; where they miss it, the quadratic ones do it alone
        failure: SolveError | None = None
        for search in (_linear_first, _quadratic_only):
            try:
                pattern = search(self, body, design, begin, deadline)
                refuse_negative(self.kinetics, pattern.steady.state)
                self._refuse_other_number(pattern)
                return pattern
            except SolveError as error:
                if perf_counter() > deadline:
                    raise
                failure = error
        assert failure is not None
        raise failure

    def _refuse_other_number(self, pattern: Pattern) -> None:
        found, wanted = pattern.half_waves, pattern.design.mode.half_waves
        if self.initial != "mode" or found == wanted:
            return
        conditions, edge = pattern.design.conditions, pattern.design.space.edge
        raise NotConvergedError(
            f"the steady pattern has {found} half waves along this band where {wanted} were asked for: the "
            f"largest element has edges of {edge:.4g} m, the ratio is {conditions.ratio:.6g}, the "
            f"critical one {conditions.critical_ratio:.6g}; use elements of at most {edge / 2:.3g} m, a "
            "ratio nearer to the critical one, or another number of half waves."
        )

    def _half_waves_on(self, body: Body) -> int:
        if not body.mirror:
            return self.half_waves
        if self.half_waves % 2:
            raise ValueError(
                f"half_waves={self.half_waves} is odd, and the half of a mirror-symmetric body holds half "
                "of an even number; use an even number or the whole body."
            )
        return self.half_waves // 2

    def _begin(self, body: Body, design: Design, seed: int) -> Array:
        # the steady state plus the fastest deviation, with a peak of the activator at the apex
        found = design.conditions
        level = np.array(found.steady_state)
        size = abs(level["uv".index(found.activator)]) or 1.0
        if self.initial == "mode":
            shape = design.mode.shape
            # an odd number on half a body is half of an even one
            if shape[design.middle] < 0 and (body.mirror or design.mode.half_waves % 2 == 0):
                shape = -shape
        else:
            shape = self._noise(body, design, seed)
        shape = shape / np.abs(shape).max()
        return np.asarray(level[:, None] + self.amplitude * size * np.outer(found.fastest_direction, shape))

    def _noise(self, body: Body, design: Design, seed: int) -> Array:
        # waves along the arc, not values at the nodes: the same noise on every mesh
        curve = body.pial_curve
        along = curve.nearest(design.space.nodes)[2] / curve.length
        orders = np.arange(1, 3 * design.mode.half_waves + 1)
        orders = orders[orders % 2 == 0] if self.symmetric and not body.mirror else orders
        strengths = np.random.default_rng(seed).standard_normal(len(orders))
        return np.asarray(strengths @ np.cos(np.pi * np.outer(orders, along)))


class Steady(LongEvolution):
    """A pattern that is there from the start and stays as it is on the undeformed band."""

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return nothing."""
        return {}


class SteadyOnBody(Steady):
    """A steady pattern on one body."""

    def __init__(self, turing: Turing, body: Body) -> None:
        """Keep both."""
        self.turing, self.body = turing, body

    def start(self, state: State, seed: int) -> Fields:
        """Return the steady pattern's fields."""
        pattern = self.turing.pattern(self.body, seed, deadline=self.deadline)
        return {
            "activator": pattern.activator,
            "inhibitor": pattern.inhibitor,
            "pattern": pattern.normalised,
        }


def _linear_first(turing: Turing, body: Body, design: Design, begin: Array, deadline: float) -> Pattern:
    """Run to the pattern on linear elements, and solve for it on quadratic ones from there."""
    found, mesh = design.conditions, body.cortex.mesh
    linear = ReactionDiffusion(discretise(mesh, 1), turing.kinetics, found.d_u, found.d_v)
    quadratic = ReactionDiffusion(design.space, turing.kinetics, found.d_u, found.d_v)
    drift = _tolerated_drift(body, design)
    settled = settle(linear, begin[:, : mesh.nvertices], tolerated=drift, deadline=deadline)
    guess = on_quadratic(settled.state, mesh)
    if turing.symmetric and not body.mirror:
        guess = 0.5 * (guess + guess[:, mirrored(quadratic.space.nodes)])
    steady = continue_on_finer(quadratic, settled, guess, tolerated=drift, deadline=deadline)
    return Pattern(design, quadratic, steady)


def on_quadratic(vertices: Array, mesh: MeshTri1) -> Array:
    """Return values of linear elements, (2, n_vertices), at the nodes of quadratic ones, (2, n_nodes)."""
    return np.concatenate([vertices, vertices[:, mesh.facets].mean(axis=1)], axis=1)


def _quadratic_only(turing: Turing, body: Body, design: Design, begin: Array, deadline: float) -> Pattern:
    """Run to the pattern on quadratic elements."""
    found = design.conditions
    system = ReactionDiffusion(design.space, turing.kinetics, found.d_u, found.d_v)
    settled = settle(system, begin, tolerated=_tolerated_drift(body, design), deadline=deadline)
    return Pattern(design, system, settled)


def _tolerated_drift(body: Body, design: Design) -> float:
    # along a closed band the pattern may be shifted: hardly anything but its curvature resists that
    return DRIFT * design.conditions.fastest_rate if body.pial_curve.closed else 0.0


def refuse_negative(kinetics: Kinetics, state: Array, time: float = 0.0) -> None:
    """Raise InadmissibleStateError where a concentration is negative."""
    if kinetics.non_negative and state.min() < 0:
        species, node = np.unravel_index(np.argmin(state), state.shape)
        raise InadmissibleStateError(
            f"{'uv'[species]} is {state.min():.3g} at node {node} of the band, and "
            f"{type(kinetics).__name__} needs "
            "concentrations of at least 0: its peaks are too narrow for the mesh; use smaller elements.",
            time=time,
        )


def mirrored(nodes: Array) -> Integers:
    """Return for each node the one at its mirror image about x = 0; raise ValueError if there is none."""
    from scipy.spatial import cKDTree

    found, partner = cKDTree(nodes.T).query(nodes.T * [-1.0, 1.0])
    distance = np.asarray(found)
    if distance.max() > 1e-6 * np.ptp(nodes):
        raise ValueError(
            f"symmetric=True: the mesh is not its own mirror image about x = 0 (a node is "
            f"{distance.max():.3g} m from the nearest image); use semicircle or semiellipse, or "
            "symmetric=False."
        )
    return np.asarray(partner, dtype=np.int64)
