"""Newton's method for an equilibrium whose time is unknown too, in a plane across the path of equilibria.

With forces G(x, t) and tangent K = ∂G/∂x, each iteration solves K a = -G and K b = -∂G/∂t, and goes on by
(a + b δt, δt) with the δt that ends in the plane (Keller 1977). Where the path turns back in time K is
singular, but states are never exactly there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..errors import NotConvergedError, SolveError
from ..parts import Potential
from ..scene import Scene
from ..solve.problem import Configuration, configuration
from ..state import State
from .fundamental_path import FundamentalPath
from .path_dependence import refuse_memory, refuse_motion

ITERATIONS = 10  # a path that needs more is followed by shorter arcs
NUDGE = 2.0**-24  # of time, as a share of the scene's, for ∂G/∂t: errors of the order of 1e-8
SHORTEST = 1e-3  # share of a Newton step that has to be admissible


@dataclass(frozen=True, eq=False)
class Place:
    """Displacement (2 n_nodes,) and time, and the fields that terms have left, to start from."""

    x: Array
    time: float
    left: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Direction:
    """Changes of displacement (2 n_nodes,) and of time per unit of arc."""

    x: Array
    time: float


@dataclass(frozen=True, eq=False)
class Balanced:
    """An equilibrium, stable or not: its `negative` pivots, and the unit `tangent` of the path there."""

    place: Place
    state: State
    energy: float
    residual: float
    negative: int
    tangent: Direction
    iterations: int


@dataclass(frozen=True, eq=False)
class _Forces:
    """Everything at one place: the potentials, forces on the free unknowns, and their relative size."""

    place: Place
    state: State
    at: Configuration
    gradient: Array
    residual: float


class Corrector:
    """Equilibria of a scene. Arcs: ds² = |dx|² / thickness² (mean over the nodes) + dt² / until²."""

    def __init__(self, scene: Scene, until: float) -> None:
        """Discretise the scene; raises ValueError if its states are more than functions of time."""
        refuse_motion(scene)
        self.scene, self.until = scene, until
        self.path = FundamentalPath(scene)
        refuse_memory(self.path.problem, self.path.start.state)
        self.start = Place(self.path.start.x, 0.0, {})
        self.free = self.path.assembler.free
        self._x_weight = 1.0 / (scene.body.nodes.shape[1] * scene.body.thickness**2)
        self._time_weight = 1.0 / scene.until**2

    def product(self, one: Direction, other: Direction) -> float:
        """Return the scalar product that arcs are measured by."""
        return float(self._x_weight * (one.x @ other.x) + self._time_weight * one.time * other.time)

    def distance(self, one: Place, other: Place) -> float:
        """Return the length of the chord between two places."""
        chord = Direction(other.x - one.x, other.time - one.time)
        return float(np.sqrt(self.product(chord, chord)))

    def ahead(self, last: Balanced, arc: float) -> Place:
        """Return the place at this arc along the tangent, within the times from 0 to the last one.

        Raises NotConvergedError if it is not admissible.
        """
        place, there = last.place, self._within(last.place, last.tangent, arc)
        here = configuration(self._potentials(place.time, place.left)[1], place.x)
        if here is None or here.largest_step(there.x - place.x) < 1.0:
            raise NotConvergedError("the path ahead is not admissible", time=place.time)
        return there

    def correct(self, guess: Place, across: Direction) -> Balanced:
        """Return the equilibrium in the plane through `guess` across a direction.

        Times stay between 0 and the last one: a path that leaves them ends there. Raises NotConvergedError
        where Newton's method fails.
        """
        here = self._forces(guess)
        for iteration in range(ITERATIONS + 1):
            tangent = self.path.linearised(here.at)
            by_time = tangent.newton_step(self._gradient_by_time(here))
            if iteration and here.residual <= self.scene.stepping.tolerance:
                return self._balanced(here, by_time, tangent.factors.negative, across, iteration)
            if iteration == ITERATIONS:
                break
            back = tangent.newton_step(here.gradient)
            off = Direction(here.place.x - guess.x + back, here.place.time - guess.time)
            crossing = self.product(across, Direction(by_time, 1.0))
            if not abs(crossing) > 0:
                raise NotConvergedError("the path does not cross the plane", time=here.place.time)
            change = -self.product(across, off) / crossing
            time = min(max(here.place.time + change, 0.0), self.until)
            change = time - here.place.time
            here = self._moved(here, Direction(back + change * by_time, change))
        raise NotConvergedError(
            f"{ITERATIONS} iterations of the corrector were not enough",
            time=here.place.time,
            residual=here.residual,
        )

    def around(self, last: Balanced, arc: float) -> Balanced:
        """Return an equilibrium beyond a corner of the path that lies less than an arc ahead.

        A contact that changes its kind bends the forces, and may turn the path so sharply that planes across
        it do not meet what follows: that goes back along the tangent of the bent forces, and the number of
        negative pivots has changed. Raises NotConvergedError if there is no such corner.
        """
        there = self._forces(self.ahead(last, 2 * arc))
        by_time = self.path.linearised(there.at).newton_step(self._gradient_by_time(there))
        way = self._unit(Direction(by_time, 1.0), last.tangent, -1.0)
        length = 8 * arc
        guess = self._within(last.place, way, length)
        found = self.correct(guess, way)
        if found.negative == last.negative or self.distance(guess, found.place) > length:
            raise NotConvergedError("the path has no corner here", time=last.place.time)
        return found

    def _within(self, place: Place, way: Direction, arc: float) -> Place:
        """Return the place at this arc along a direction, or where it leaves the times from 0 to the last."""
        beyond = place.time + arc * way.time
        time = min(max(beyond, 0.0), self.until)
        if time != beyond:
            arc = (time - place.time) / way.time
        return Place(place.x + arc * way.x, time, place.left)

    def _potentials(self, time: float, left: Mapping[str, Array]) -> tuple[State, tuple[Potential, ...]]:
        state = self.path.problem.processed(self.path.start.state, time).updated(**left)
        return state, self.path.potentials(state, self.scene.until)

    def _forces(self, place: Place) -> _Forces:
        state, potentials = self._potentials(place.time, place.left)
        wanted = self.scene.wanted
        at = configuration(potentials, place.x)
        left = {} if at is None else {k: v for e in at.evaluations for k, v in e.finish(wanted).items()}
        if left:  # what is inside the elements has settled: the tangent is to belong to that
            place = Place(place.x, place.time, left)
            state, potentials = self._potentials(place.time, left)
            at = configuration(potentials, place.x)
        if at is None:
            raise NotConvergedError("a state is not admissible", time=place.time)
        gradient, residual = at.forces(self.free)
        if not np.isfinite(residual):
            raise NotConvergedError("the forces are not finite", time=place.time)
        return _Forces(place, state, at, gradient, residual)

    def _gradient_by_time(self, here: _Forces) -> Array:
        """Return ∂G/∂t on the free unknowns, by a difference to a later time, at the end an earlier one."""
        nudge = NUDGE * self.scene.until
        if here.place.time + nudge > self.scene.until:
            nudge = -nudge
        later = Place(here.place.x, here.place.time + nudge, here.place.left)
        return (self._forces(later).gradient - here.gradient) / nudge

    def _moved(self, here: _Forces, change: Direction) -> _Forces:
        """Return the forces after a Newton step, or the admissible part of one."""
        place, step = here.place, here.at.largest_step(change.x)
        while step > SHORTEST:
            time = place.time + step * change.time
            try:
                return self._forces(Place(place.x + step * change.x, time, place.left))
            except SolveError:
                step *= 0.5
        raise NotConvergedError("the corrector leaves the admissible states at once", time=place.time)

    def _balanced(
        self, here: _Forces, by_time: Array, negative: int, across: Direction, iterations: int
    ) -> Balanced:
        """Return the equilibrium with the path's tangent, on the side of `across`."""
        displacement = here.place.x.reshape(-1, 2).T.copy()
        return Balanced(
            here.place,
            here.state.updated(displacement=displacement),
            here.at.energy,
            here.residual,
            negative,
            self._unit(Direction(by_time, 1.0), across, 1.0),
            iterations,
        )

    def _unit(self, one: Direction, other: Direction, side: float) -> Direction:
        """Return the direction with length 1, on the same side as another one (side 1) or against it (-1)."""
        size = side * np.sqrt(self.product(one, one))
        size = -size if self.product(one, other) < 0 else size
        return Direction(one.x / size, one.time / size)
