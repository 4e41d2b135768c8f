"""The march through time: processes change the fields, then the potential finds its new minimum."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from ..arrays import Array, Integers
from ..errors import InadmissibleStateError, NotConvergedError, SolveError
from ..geometry.body import by_node
from ..parts import Operator, Potential, Process, Timed
from ..scene import Scene, stress_scale
from ..state import State
from ..stepping import Stepping
from .newton import Equilibrium, Memory, Minimiser
from .prediction import REMEMBERED, Past, extrapolated

LONGER = 1.3  # the next step after an easy one
EASY, HARD = 0.25, 0.5  # shares of the allowed iterations


@dataclass(frozen=True)
class Step:
    """An accepted step: the state, the numbers of its row in the history, and the potentials it minimises."""

    state: State
    numbers: dict[str, float]
    potentials: tuple[Potential, ...]
    seconds: dict[str, float]

    @property
    def x(self) -> Array:
        """Displacement, (2 n_nodes,), node by node."""
        return by_node(self.state["displacement"])

    def observe(self) -> dict[str, Array]:
        """Return the fields to look at, such as stresses."""
        fields: dict[str, Array] = {}
        for potential in self.potentials:
            fields |= potential.observe(self.x)
        return fields


@dataclass(frozen=True)
class Progress:
    """Where a march stands between two steps: enough to go on exactly as if it had not been interrupted.

    previous_dt: length of the last step, to the last bit.
    past: earlier equilibria, the newest last, to predict the next one from.
    memory: what the minimiser carries from step to step.
    """

    state: State
    dt: float
    previous_dt: float = 0.0
    past: tuple[Past, ...] = ()
    memory: Memory | None = None

    @property
    def equilibria(self) -> tuple[Past, ...]:
        """The latest equilibria and the present one."""
        return (*self.past, Past(self.state.time, self.state["displacement"]))


def begin(scene: Scene) -> Progress:
    """Return the progress before the first step, with the fields that the processes start from."""
    body = scene.body
    scale = np.array(stress_scale(scene.terms))
    state = State(0.0, {"displacement": np.zeros_like(body.nodes), "stress_scale": scale})
    for process in scene.processes:
        state = state.updated(**_made(process, "start", process.start(body, state, scene.seed)))
    return Progress(state, scene.stepping.first * scene.until)


def discretised(scene: Scene) -> tuple[list[Operator], Integers]:
    """Return the operators of the scene's terms, and the degrees of freedom that are held."""
    operators = [term.on(scene.body) for term in scene.terms]
    grounded = any(operator.grounds for operator in operators)
    return operators, scene.body.supported if grounded else scene.body.fixed


def processed(scene: Scene, state: State, dt: float) -> dict[str, Array]:
    """Return the fields that the scene's processes have dt after `state`."""
    fields: dict[str, Array] = {}
    for process in scene.processes:
        so_far = State(state.time, {**state.fields, **fields})
        fields |= _made(process, "advance", process.advance(scene.body, so_far, dt))
    return fields


def _made(process: Process, by: str, fields: object) -> dict[str, Array]:
    """Return the fields that a process made; raises ValueError for what is no dict of those it writes."""
    if not isinstance(fields, dict) or not set(fields) <= set(process.writes):
        raise ValueError(
            f"{type(process).__name__}.{by} returned {str(fields)[:60]}; it must be a dict of the fields it "
            f"writes ({', '.join(process.writes)}), {{}} where nothing changes."
        )
    return fields


def acting(operators: Sequence[Operator], state: State, dt: float) -> tuple[Potential, ...]:
    """Return the potentials that act in the step of length dt that ends in `state`."""
    return tuple(p for p in (operator.during(state, dt) for operator in operators) if p is not None)


def in_the_middle(scene: Scene) -> bool:
    """Return whether forces balance in the middle of each step, with the fields of that time."""
    return any(isinstance(term, Timed) and term.scheme == "midpoint" for term in scene.terms)


def march(scene: Scene, progress: Progress) -> Iterator[tuple[Step, Progress]]:
    """Yield each accepted step, and the progress from which the next one starts.

    Raises NotConvergedError when a step fails at the smallest step size or the time limit is reached.
    """
    stepping, until = scene.stepping, scene.until
    started = perf_counter()
    operators, held = discretised(scene)
    n_dofs, limits = 2 * scene.body.nodes.shape[1], (stepping.tolerance, stepping.iterations)
    minimiser = Minimiser(n_dofs, held, *limits, progress.memory, stepping.solver)
    if progress.memory is not None and progress.memory.point is not None:
        at_hand = acting(operators, progress.state, progress.previous_dt)
        minimiser.remember(at_hand, progress.memory.point)
    minimiser.deadline = started + stepping.seconds
    minimiser.effort.add("setting up", started)
    while progress.state.time < until * (1 - 1e-12):
        if perf_counter() > minimiser.deadline:
            raise _out_of_time(progress.state, scene)
        dt = min(progress.dt, until - progress.state.time)
        if until - progress.state.time - dt < 0.01 * dt:
            dt = until - progress.state.time
        try:
            step = _attempt(scene, operators, minimiser, progress, dt, perf_counter())
        except SolveError as error:
            if perf_counter() <= minimiser.deadline and dt / 2 < stepping.smallest * until:
                raise _stopped(progress.state, until, error) from error
            minimiser.forget()
            progress = replace(progress, dt=dt / 2)
            continue
        onward = _onward(dt, step.numbers["newton_iterations"], stepping, until)
        progress = Progress(step.state, onward, dt, progress.equilibria[-REMEMBERED:], minimiser.memory)
        yield step, progress


def _onward(dt: float, iterations: float, stepping: Stepping, until: float) -> float:
    """Return the length of the step after one that took so many iterations."""
    share = iterations / stepping.iterations
    factor = LONGER if share <= EASY else 1.0 if share <= HARD else 1 / LONGER
    return max(min(factor * dt, stepping.largest * until), stepping.smallest * until)


def _attempt(
    scene: Scene, operators: list[Operator], minimiser: Minimiser, progress: Progress, dt: float, began: float
) -> Step:
    """Take one step from untouched data."""
    old, effort = progress.state, minimiser.effort
    iterations, factorizations = effort.iterations, effort.factorizations
    state = _onward_by(scene, old, dt)
    potentials = at_end = acting(operators, state, dt)
    midway = in_the_middle(scene)
    if midway:
        potentials = acting(operators, _onward_by(scene, old, 0.5 * dt), dt)
    effort.add("processes", began)
    found = minimiser.minimise(potentials, by_node(old["displacement"]), _predicted(potentials, progress, dt))
    state = _finished(state.updated(displacement=found.x.reshape(-1, 2).T.copy()), potentials, found.x)
    end = by_node(state["displacement"])
    if midway or not np.array_equal(end, found.x):
        minimiser.forget()
    numbers = {
        **_numbers(found, state.time, dt),
        "newton_iterations": effort.iterations - iterations,
        "factorizations": effort.factorizations - factorizations,
        "seconds": perf_counter() - began,
    }
    for potential in at_end:
        numbers |= potential.measure(end)
    return Step(state, numbers, at_end, dict(effort.seconds))


def _onward_by(scene: Scene, state: State, dt: float) -> State:
    """Return the state with the fields that the processes have dt later, all finite."""
    time, fields = state.time + dt, processed(scene, state, dt)
    for name, values in fields.items():
        if not np.isfinite(values).all():
            raise InadmissibleStateError(f"the field {name!r} is not finite at t = {time:.4g}", time=time)
    return state.updated(time, **fields)


def _finished(state: State, potentials: tuple[Potential, ...], x: Array) -> State:
    """Return the state with what the potentials leave behind; they may end the step elsewhere than at x."""
    for potential in potentials:
        state = state.updated(**potential.finish(x))
    onward = by_node(state["displacement"]) - x
    if onward.any() and min(p.largest_step(x, onward) for p in potentials) < 1.0:
        raise InadmissibleStateError("the end of the step is not admissible", time=state.time)
    return state


def _predicted(potentials: tuple[Potential, ...], progress: Progress, dt: float) -> Array | None:
    """Return the displacement expected dt ahead, as far that way as admissible; None if there is no past."""
    if not progress.past:
        return None
    x = by_node(progress.state["displacement"])
    ahead = by_node(extrapolated(progress.equilibria, progress.state.time + dt)) - x
    return np.asarray(x + min(p.largest_step(x, ahead) for p in potentials) * ahead)


def _numbers(found: Equilibrium, time: float, dt: float) -> dict[str, float]:
    return {
        "time": time,
        "step": dt,
        "energy": found.energy,
        "residual": found.residual,
        "negative_pivots": found.negative_pivots,
    }


def _stopped(state: State, until: float, cause: SolveError) -> NotConvergedError:
    residual = f" (residual {cause.residual:.2g})" if np.isfinite(cause.residual) else ""
    return NotConvergedError(
        f"The march stopped at t = {state.time:.6g} of {until:g}: {cause}{residual}. The last good state is "
        "kept. Try smaller steps (Stepping(largest=...)), smaller elements, less load, or Drag(...).",
        time=state.time,
        residual=cause.residual,
    )


def _out_of_time(state: State, scene: Scene) -> NotConvergedError:
    return NotConvergedError(
        f"The march stopped at t = {state.time:.6g} of {scene.until:g}: the time limit of "
        f"{scene.stepping.seconds:g} s is reached. The last good state is kept. Try another "
        "Stepping(seconds=...); a run with results in a folder goes on with it by resume=True.",
        time=state.time,
    )
