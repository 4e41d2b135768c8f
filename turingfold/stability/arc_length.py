"""Equilibria of a scene beyond limit points, by continuation in arc length instead of time.

Where a path of equilibria turns back in time the body snaps to another one, and a march jumps. The states
between, stable or not, are found with time as an unknown (`corrector`), from a guess along the tangent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from ..arrays import Array
from ..checks import instance, positive, whole
from ..errors import NotConvergedError, SolveError
from ..geometry.body import by_node
from ..growth.measure import largest_growth
from ..scene import Scene
from ..solve.threads import one_thread
from ..state import State
from .corrector import Balanced, Corrector, Direction, Place

AIM = 3.5  # iterations of the corrector
TURN = 0.9  # cosine of the angle by which the path may turn in one step
STRAY = 0.25  # a correction longer than this share of the arc has left the path,
CORNER = 10.0  # except at the smallest arcs, with which bends of the path are passed
SAME = 1e-3  # of a step: closer to an earlier point, the path has come back to it

MORE_TIME = "Give Stepping(seconds=...) more, or go on with the last of them as `start`."
LOOP = "It is a closed loop; from t = 0 one is entered where paths cross, which an imperfection may part."
SMALLER = "Try a smaller `smallest`, smaller elements, or less load."


@dataclass(frozen=True, kw_only=True, eq=False)
class PathPoint:
    """An equilibrium on a path, stable or not.

    state: with the displacement (2, n_nodes) in m.  arc: length of the path up to here (see `equilibria`).
    rate: dt/ds, negative where the path runs back in time.  growth: the largest tangential growth factor.
    energy in J/m.  residual: relative.  negative_pivots: number of directions in which the energy falls.
    """

    state: State
    arc: float
    rate: float
    growth: float
    energy: float
    residual: float
    negative_pivots: int

    def __repr__(self) -> str:
        """Return it in a line; the state would fill pages."""
        kind = f"unstable, {self.negative_pivots} negative pivots" if self.negative_pivots else "stable"
        return f"PathPoint(t = {self.time:.4g}, growth {self.growth:.4f}, {kind})"

    @property
    def time(self) -> float:
        """Time in the scene's units."""
        return self.state.time


@dataclass(frozen=True, eq=False)
class EquilibriumPath:
    """Points in the order in which they were found."""

    points: tuple[PathPoint, ...]

    def __repr__(self) -> str:
        """Return it in a line; the states would fill pages."""
        turns = ", ".join(f"{time:.4g}" for time in self.limit_points) or "none"
        end = f", to t = {self.points[-1].time:.4g}" if self.points else ""
        return f"EquilibriumPath({len(self.points)} points{end}, limit points at t: {turns})"

    def of(self, name: str) -> Array:
        """Return a number of each point by its name, such as "time" or "energy", (n_points,)."""
        return np.array([float(getattr(point, name)) for point in self.points])

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each point is a minimum of the energy, (n_points,)."""
        return np.array([point.negative_pivots == 0 for point in self.points])

    @property
    def limit_points(self) -> Array:
        """Times at which the path turns back, in order; by cubic interpolation from the points around."""
        return np.array([time for _, time in self._turns])

    def at_limit_points(self, values: Array) -> Array:
        """Return what has these `values` at the points, (n_points,), where the path turns back.

        It is interpolated by a cubic spline over the arc.
        """
        if not self._turns:
            return np.array([])
        return np.asarray(CubicSpline(self.of("arc"), values)([arc for arc, _ in self._turns]))

    @cached_property
    def _turns(self) -> list[tuple[float, float]]:
        """Arc and time at each limit point."""
        arc, time, rate = self.of("arc"), self.of("time"), self.of("rate")
        found = []
        for k in np.flatnonzero(rate[1:] * rate[:-1] < 0):
            near = slice(k, k + 2)
            curve = CubicHermiteSpline(arc[near], time[near], rate[near])
            found += [(float(s), float(curve(s))) for s in curve.derivative().roots(extrapolate=False)]
        return found


class PathStoppedError(NotConvergedError):
    """A path that could not be followed; `path` holds its points so far."""

    def __init__(self, message: str, path: EquilibriumPath, *, time: float, residual: float) -> None:
        """Keep what was found."""
        super().__init__(message, time=time, residual=residual)
        self.path = path


@one_thread
def equilibria(
    scene: Scene, *, arc: float = 0.05, smallest: float = 1e-4, largest: float = 2.0, steps: int = 200,
    until: float | None = None, start: PathPoint | None = None, backward: bool = False,
    progress: Callable[[PathPoint], object] | None = None,
) -> EquilibriumPath:  # fmt: skip
    """Return the equilibria that are connected with the scene's start, through limit points.

    The load is the scene's time. Arcs are measured by ds² = |du|²/thickness² (mean over the nodes) +
    dt²/scene.until². Without SelfContact walls may pass through each other. `scene.stepping.solver` plays no
    part: factors always come from SuperLU, whose pivots count the directions in which the energy falls.
    arc: length of the first step; later ones aim at three or four iterations of the corrector each.
    smallest, largest: bounds of the steps, in units of the first.  steps: most points after the start.
    until: time at which to stop, the scene's end by default; the path also stops where it returns to t = 0.
    start: a point to go on from.  backward: from there, the way that it came.
    progress: is called with each new point.
    Raises ValueError for parts that remember how a state was reached (drag, inertia, a pattern that evolves),
    PathStoppedError where a step fails at the smallest arc, `scene.stepping.seconds` are over, or the path
    comes back to an earlier point.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    first = positive("arc", arc)
    if positive("largest", largest) < 1:
        raise ValueError(f"largest={largest:g} must be at least 1, the first step; use a smaller arc.")
    bounds = first * positive("smallest", smallest, at_most=1.0), first * largest
    whole("steps", steps, at_least=1)
    end = scene.until if until is None else positive("until", until, at_most=scene.until)
    if start is None and backward:
        raise ValueError("backward=True needs a start, such as path.points[-1]: nothing comes before t = 0.")
    if start is not None:
        _check_start(start, scene, end)
    began = perf_counter()
    try:
        corrector = Corrector(scene, end)
        last = _first(corrector, start, backward)
    except SolveError as error:
        raise _failed([], error) from error
    points, length = [_point(last, 0.0 if start is None else start.arc)], first
    for _ in range(steps):
        if last.place.time == (end if last.tangent.time > 0 else 0.0):
            break
        if perf_counter() - began > scene.stepping.seconds:
            over = f"the time limit of {scene.stepping.seconds:g} s is reached"
            raise _stopped(points, over, MORE_TIME, points[-1])
        met, length = _ahead(corrector, last, points, (bounds[0], length))
        try:
            last, covered, length = _step(corrector, last, length, bounds)
        except SolveError as error:
            raise _failed(points, error) from error
        points.append(_point(last, points[-1].arc + covered))
        if progress is not None:
            progress(points[-1])
        if met is not None and corrector.distance(_place(met), last.place) <= SAME * covered:
            back = f"it has come back to its point at arc {met.arc:.6g}"
            raise _stopped(points, back, LOOP, points[-1])
    return EquilibriumPath(tuple(points))


def _check_start(start: PathPoint, scene: Scene, end: float) -> None:
    instance("start", start, PathPoint, "path.points[-1]")
    if start.time > end:
        raise ValueError(f"start is at t = {start.time:g}, beyond until={end:g}; give a later `until`.")
    given, needed = start.state["displacement"].shape, scene.body.nodes.shape
    if given != needed:
        raise ValueError(
            f"start holds a displacement of shape {given}, but the scene's body has nodes of shape {needed}; "
            "give a point of a path on the same mesh."
        )


def _ahead(
    corrector: Corrector, last: Balanced, points: list[PathPoint], bounds: tuple[float, float]
) -> tuple[PathPoint | None, float]:
    """Return an earlier point before which the path has come again, if there is one, and the step to take.

    A step as long as the way to that point along the tangent ends in it, if the path is a closed loop.
    bounds: of the step; the longer one is taken where no point is ahead.
    """
    for point in points[:-1]:
        if point.rate * last.tangent.time > 0:
            place = _place(point)
            chord = Direction(place.x - last.place.x, place.time - last.place.time)
            along = corrector.product(chord, last.tangent)
            straight = along >= (1 - STRAY) * corrector.distance(last.place, place)
            if straight and bounds[0] <= along <= bounds[1]:
                return point, along
    return None, bounds[1]


def _place(point: PathPoint) -> Place:
    return Place(by_node(point.state["displacement"]), point.time, {})


def _first(corrector: Corrector, start: PathPoint | None, backward: bool) -> Balanced:
    """Return the equilibrium to begin with, its tangent pointing the way to go."""
    place, way = corrector.start, 1.0
    if start is not None:
        left = {k: v for k, v in start.state.fields.items() if k not in corrector.path.start.state}
        place = replace(_place(start), left=left)
        way = np.sign(start.rate) * (-1.0 if backward else 1.0)
    return corrector.correct(place, Direction(np.zeros_like(place.x), way))


def _step(
    corrector: Corrector, last: Balanced, length: float, bounds: tuple[float, float]
) -> tuple[Balanced, float, float]:
    """Return the next equilibrium, the length of the chord to it, and that of the step to try after it."""
    smallest, largest = bounds
    while True:
        try:
            found = _attempt(corrector, last, length, careful=length >= 2 * smallest)
        except SolveError as error:
            length *= 0.5
            if length >= smallest:
                continue
            try:
                found = corrector.around(last, smallest)
            except SolveError:
                raise error from None
        onward = length * min(max(AIM / found.iterations, 0.5), 2.0)
        covered = corrector.distance(last.place, found.place)
        return found, covered, min(max(onward, smallest), largest)


def _attempt(corrector: Corrector, last: Balanced, length: float, careful: bool) -> Balanced:
    """Return the equilibrium near the place ahead; careful: refuse one far off, or a turn of the path.

    Where the number of negative pivots changes by one the path turns back in time, or another one branches
    off. A turn so sharp that the tangent before and after are nearly the same line is told from a branch by
    small arcs only.
    """
    guess, across = corrector.ahead(last, length), last.tangent
    if guess.time in (0.0, corrector.until):  # where the path ends: the time is known
        across = Direction(np.zeros_like(guess.x), across.time)
    found = corrector.correct(guess, across)
    if corrector.distance(guess, found.place) > (STRAY if careful else CORNER) * length:
        raise NotConvergedError("the corrector leaves the path", time=found.place.time)
    if careful and corrector.product(found.tangent, last.tangent) < TURN:
        raise NotConvergedError("the path turns too fast", time=found.place.time)
    if (found.negative - last.negative) % 2 and found.tangent.time * last.tangent.time > 0:
        if careful:
            raise NotConvergedError("the path may have turned back", time=found.place.time)
        try:
            return corrector.around(last, length)
        except SolveError:  # there is no turn: it is a branch
            return found
    return found


def _point(found: Balanced, arc: float) -> PathPoint:
    return PathPoint(
        state=found.state,
        arc=arc,
        rate=found.tangent.time,
        growth=largest_growth(found.state),
        energy=found.energy,
        residual=found.residual,
        negative_pivots=found.negative,
    )


def _failed(points: list[PathPoint], error: SolveError) -> PathStoppedError:
    far = "" if np.isnan(error.residual) else f" (residual {error.residual:.2g})"
    return _stopped(points, f"{error}{far}", SMALLER, error)


def _stopped(points: list[PathPoint], why: str, remedy: str, at: PathPoint | SolveError) -> PathStoppedError:
    """Return the error of a path that stopped after these points, `at` its last one or by an error."""
    where = f"t = {points[-1].time:.6g}, growth {points[-1].growth:.4g}" if points else "its start"
    return PathStoppedError(
        f"The path of equilibria stopped after {len(points)} points at {where}: {why}. The points so far are "
        f"kept. {remedy}",
        EquilibriumPath(tuple(points)),
        time=points[-1].time if points else at.time,
        residual=at.residual,
    )
