"""Buckling: the growth at which the smooth solution's tangent ceases to be positive definite, and the mode.

The fundamental path is followed by plain Newton steps on the true tangent K, which go on through a
bifurcation where a minimiser would leave for the folded branch; the signs of the pivots count the negative
eigenvalues. The lowest eigenvalue of K v = λ K₀ v, with K₀ the tangent of the undeformed body, is the share
of its stiffness that is left: 1 at the start, almost linear in growth, 0 where the body buckles. Between the
last stable state and the first unstable one the displacement is interpolated: nothing is solved with a
singular tangent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from scipy.optimize import brentq

from ..arrays import Array
from ..checks import finite, instance, positive
from ..errors import NotConvergedError, SolveError
from ..geometry.body import by_node
from ..growth.measure import largest_growth
from ..scene import Scene
from ..solve.inertia import negative_pivots as negative_pivots
from ..solve.march import Progress
from ..solve.threads import one_thread
from ..state import State
from .fundamental_path import FundamentalPath, FundamentalState
from .waves import LOCAL, extent_of, half_waves

FINEST = 1e-4  # smallest step towards a limit point, as a share of the scene's time
CLOSE = 0.1  # width of the bracket around the crossing, as a share of its time
WORN = 0.1  # share of the stiffness below which a path that cannot be followed has come to a limit point


Watching = Callable[[dict[str, float]], object]


@dataclass(frozen=True, kw_only=True)
class Buckling:
    """The first loss of stability of a scene's smooth solution.

    growth: the largest tangential growth factor there (1 where nothing grows).  time: in the scene's units.
    mode: half waves along the pial surface, see `waves.half_waves`.  extent: share of the surface that bears
    the mode, see `waves.extent_of`; 1 for equal waves.
    shape: the eigenvector, (2, n_nodes), its largest nodal displacement 1.
    state: the state on the fundamental path.  remaining_stiffness: share of it at the start, as good as 0.
    limit: whether the path turns back there, rather than going on unstable beyond a bifurcation.
    """

    growth: float
    time: float
    mode: int
    extent: float
    shape: Array
    state: State
    remaining_stiffness: float
    limit: bool

    def __repr__(self) -> str:
        """Return it in a line; the arrays would fill pages."""
        kind = "limit point" if self.limit else "bifurcation"
        where = f", localised on {self.extent:.0%} of the pial surface" if self.localised else ""
        at = f"growth {self.growth:.4f}, t = {self.time:.4g}"
        return f"Buckling({kind} at {at}, {self.mode} half waves{where})"

    @property
    def localised(self) -> bool:
        """Whether less than half of the pial surface bears the mode."""
        return self.extent < LOCAL

    def switched(self, amplitude: float, dt: float) -> Progress:
        """Return the progress from which `march` goes on along the buckled branch.

        The base displacement plus amplitude (m; its sign chooses between the two sides) times the mode.
        dt: length of the first step from there, in the scene's time.
        """
        if finite("amplitude", amplitude) == 0:
            raise ValueError("amplitude=0 stays on the path; give about a tenth of the cortex, in m.")
        moved = self.state["displacement"] + amplitude * self.shape
        return Progress(self.state.updated(displacement=moved), positive("dt", dt))


@one_thread
def buckling(scene: Scene, *, progress: Watching | None = None) -> Buckling:
    """Return the first loss of stability along the scene's smooth solution.

    progress: is called with numbers of each state of the path, as of a history: time, step, growth, seconds,
    and negative_pivots, 0 where it is stable.
    It is followed in steps of `scene.stepping`. At a bifurcation the critical growth is interpolated; a limit
    point is found to 1e-4 of the scene's time. `scene.stepping.solver` plays no part: factors always come
    from SuperLU, whose pivots count the negative eigenvalues.
    Raises ValueError for terms that resist motion (inertia, drag): they would stiffen the tangent. Raises
    NotConvergedError if the solution stays stable until the scene's end, or cannot be followed.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    for term in scene.terms:
        if term.resists_motion:
            raise ValueError(
                f"terms holds {term!r}, which resists motion and hides the loss of stability; leave it out."
            )
    path = FundamentalPath(scene)
    nodes, limit = _bracket(path, progress)
    base = nodes[-1] if limit else _crossing(path, nodes)
    stiffness, vector = path.lowest(base)
    if limit and stiffness > WORN:
        raise NotConvergedError(
            f"The fundamental path cannot be followed beyond t = {base.state.time:.6g}, growth "
            f"{largest_growth(base.state):.4g}, though {stiffness:.0%} of the stiffness is left; "
            "use smaller steps (Stepping(largest=...)) or smaller elements.",
            time=base.state.time,
        )
    shape = np.zeros(len(base.x))
    shape[path.assembler.free] = vector
    shape = shape.reshape(-1, 2).T / np.hypot(*shape.reshape(-1, 2).T).max()
    return Buckling(
        growth=largest_growth(base.state),
        time=base.state.time,
        mode=half_waves(scene.body, shape),
        extent=extent_of(scene.body, shape),
        shape=shape,
        state=base.state,
        remaining_stiffness=stiffness,
        limit=limit,
    )


def _bracket(path: FundamentalPath, progress: Watching | None) -> tuple[list[FundamentalState], bool]:
    """Return up to four stable states and the first unstable one; or stable ones and True."""
    stepping, until = path.scene.stepping, path.scene.until
    nodes = [path.start]
    state, dt, longest, ahead = path.start.state, stepping.first * until, stepping.largest * until, None
    while state.time < until * (1 - 1e-12):
        dt, began = min(dt, until - state.time), perf_counter()
        now = _attempt(path, state, dt, ahead)
        if now is None:
            dt = longest = dt / 2
            if dt >= FINEST * until:
                continue
            return nodes, True
        if progress is not None:
            progress(_numbers(state, now, perf_counter() - began))
        if now.negative:
            return _closer(path, nodes, now), False
        ahead = (now.x - by_node(state["displacement"])) / (now.state.time - state.time)
        state, nodes, dt = now.state, [*nodes[-3:], now], min(1.3 * dt, longest)
    raise NotConvergedError(
        f"No loss of stability until t = {until:g}, growth {largest_growth(state):.4g}; let it grow more.",
        time=until,
    )


def _numbers(before: State, now: FundamentalState, seconds: float) -> dict[str, float]:
    time = now.state.time
    return {
        "time": time, "step": time - before.time, "growth": largest_growth(now.state), "seconds": seconds,
        "negative_pivots": now.negative,
    }  # fmt: skip


def _closer(
    path: FundamentalPath, nodes: list[FundamentalState], end: FundamentalState
) -> list[FundamentalState]:
    """Return stable states and the first unstable one, near enough to interpolate what is between them."""
    while end.state.time - nodes[-1].state.time > CLOSE * end.state.time:
        start, dt = nodes[-1], 0.5 * (end.state.time - nodes[-1].state.time)
        now = _attempt(path, start.state, dt, 0.5 * (end.x - start.x) / dt)
        if now is None or not start.state.time < now.state.time < end.state.time:
            break
        nodes, end = (nodes, now) if now.negative else ([*nodes[-3:], now], end)
    return [*nodes, end]


def _attempt(path: FundamentalPath, state: State, dt: float, ahead: Array | None) -> FundamentalState | None:
    """Return the state dt ahead, or None; a step that may end too near a bifurcation is tried longer."""
    leap = dt > 0.1 * path.scene.stepping.largest * path.scene.until
    for length in (dt, 1.5 * dt) if leap else (dt,):
        try:
            found = path.step(state, length, None if ahead is None else ahead * length)
        except SolveError:
            continue
        return found if length == dt or found.negative else None
    return None


def _crossing(path: FundamentalPath, nodes: list[FundamentalState]) -> FundamentalState:
    """Return the state between the last two nodes where the lowest eigenvalue vanishes."""
    start, end = nodes[-2].state.time, nodes[-1].state.time

    def left(time: float) -> float:
        return path.lowest(path.between(nodes, time))[0]

    return path.between(nodes, float(brentq(left, start, end, xtol=1e-3 * (end - start), rtol=1e-7)))
