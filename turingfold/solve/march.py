"""The march through time: processes change the fields, then the displacement finds its new equilibrium."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter

from ..arrays import Array
from ..errors import (
    InadmissibleStateError,
    OutOfMemoryError,
    RoundOffError,
    SolveError,
    StepTooLongError,
)
from ..geometry.body import by_node
from ..parts import Evaluation, Potential, TimeStep
from ..scene import Scene
from ..state import State
from ..stepping import Stepping
from .equilibrium import Equilibrium, Memory
from .newton import Minimiser
from .prediction import REMEMBERED, Past, extrapolated
from .problem import Configuration, Problem, configuration
from .step_control import longest_next
from .stops import hopeless, out_of_time, stopped

LONGER = 1.3  # the next step after an easy one
# shares of the allowed iterations: chosen on a whole coronal section, which took 536 for 744 with 1/4 and 1/2
EASY, HARD = 0.4, 0.6
USUAL, SNAPS, DAMPED = "usual", "snaps", "damped"  # ways to take a step
PATIENCE = 3  # halvings after failures, or by which a step is below the usual, before the body snaps
REFINEMENTS = 3  # how often a step is taken again with finer potentials

Potentials = tuple[Potential, ...]


@dataclass(frozen=True, eq=False)
class Step:
    """An accepted step: the state at its end, all potentials there, and the numbers of its history row.

    seconds: spent since the march began, by kind of work.  longest_next: what a bound on the error allows.
    """

    state: State
    at: Configuration
    numbers: dict[str, float]
    seconds: dict[str, float]
    longest_next: float = math.inf

    @property
    def x(self) -> Array:
        """Displacement, (2 n_nodes,), node by node."""
        return self.at.x

    def observe(self) -> dict[str, Array]:
        """Return the fields to look at, such as stresses."""
        return observed(self.at)


def observed(at: Configuration) -> dict[str, Array]:
    """Return the fields that terms show of a configuration, each (q, e)."""
    fields: dict[str, Array] = {}
    for evaluation in at.evaluations:
        fields |= evaluation.observe()
    return fields


@dataclass(frozen=True)
class Progress:
    """Where a march stands between two steps: enough to go on exactly as if it had not been interrupted.

    previous_dt: length of the last step, to the last bit.
    usual_dt: length of steps before they had to be shortened, which is forgotten by and by.
    past: earlier equilibria, the newest last, to predict the next one from.
    memory: what the minimiser carries from step to step.
    """

    state: State
    dt: float
    previous_dt: float = 0.0
    past: tuple[Past, ...] = ()
    memory: Memory | None = None
    usual_dt: float = 0.0

    @property
    def equilibria(self) -> tuple[Past, ...]:
        """The latest equilibria and the present one."""
        return (*self.past, Past(self.state.time, self.state["displacement"]))


def begin(scene: Scene, problem: Problem | None = None) -> Progress:
    """Return the progress before the first step, with the fields that the scene starts from."""
    return Progress((problem or Problem(scene)).start(), scene.stepping.first * scene.until)


def march(
    scene: Scene, progress: Progress, problem: Problem | None = None
) -> Iterator[tuple[Step, Progress]]:
    """Yield each accepted step, and the progress from which the next one starts.

    problem: that of the scene, if it is made already; the scene's time limit counts from when it was made.

    Raises NotConvergedError when a step fails at the smallest step size or the time limit is reached.
    """
    stepping, until = scene.stepping, scene.until
    started = perf_counter()
    problem = problem or Problem(scene)
    minimiser = _minimiser(problem, progress)
    minimiser.effort.add("setting up", started)
    failures, overshot = 0, False  # of the present step; whether the last one came to a bad end
    while progress.state.time < until * (1 - 1e-12):
        if minimiser.out_of_time:
            raise out_of_time(progress.state, scene)
        dt = _length(progress, stepping, until)
        way, strict = _way(progress, dt, failures, overshot, stepping), failures <= PATIENCE
        try:
            step = _attempt(problem, minimiser, progress, dt, perf_counter(), way, strict)
        except (RoundOffError, OutOfMemoryError, MemoryError) as error:  # no other step would do
            minimiser.forget()
            raise hopeless(progress.state, until, error) from error
        except StepTooLongError as error:
            if error.length < stepping.smallest * until:
                raise stopped(progress.state, stepping, until, error) from error
            minimiser.forget()
            progress = replace(progress, dt=error.length, usual_dt=min(progress.usual_dt, error.length))
            continue
        except SolveError as error:
            failures += 1
            overshot = isinstance(error, InadmissibleStateError)
            if not minimiser.out_of_time and dt / 2 < stepping.smallest * until:
                # too few halvings: the body may still snap within this step, or end as what is no body
                if failures <= PATIENCE or (strict and overshot):
                    failures = PATIENCE + 1
                    minimiser.forget()
                    continue
                raise stopped(progress.state, stepping, until, error) from error
            minimiser.forget()
            progress = replace(progress, dt=dt / 2)
            continue
        failures, overshot = 0, False
        if step.numbers["snapped"] or step.numbers.get("damped"):
            minimiser.forget()
        progress = _after(step, progress, dt, scene, minimiser.memory, strict)
        yield step, progress
        del step  # with all that was computed at its end


def _way(progress: Progress, dt: float, failures: int, overshot: bool, stepping: Stepping) -> str:
    """Return the way to take a step of length dt after so many failures.

    overshot: whether the last one's end was no body; there no flow leads on, but damping may.
    """
    if failures < PATIENCE and not (failures and dt < progress.usual_dt / 2**PATIENCE):
        return USUAL
    if overshot:
        return DAMPED if stepping.balance < 1 else USUAL
    return SNAPS


def _after(step: Step, progress: Progress, dt: float, scene: Scene, memory: Memory, strict: bool) -> Progress:
    """Return the progress after a step of length dt, with the length of the next one."""
    stepping, until, past = scene.stepping, scene.until, progress.equilibria[-REMEMBERED:]
    onward = _onward(dt, step.numbers["newton_iterations"], stepping, until)
    if step.numbers["snapped"]:  # the short steps before it, and the past, tell nothing of what follows
        onward, past = max(progress.usual_dt, dt), ()
    elif not (strict or step.at.is_valid):  # shorter steps were of no use
        onward = max(progress.usual_dt, dt)
    if any(abs(step.state.time - stop) <= 1e-12 * until for stop in stepping.stops):
        # a step that was cut short there says little about the next
        onward = max(onward, progress.dt)
    onward = min(onward, step.longest_next)
    usual = max(progress.usual_dt / LONGER if past else progress.usual_dt, dt)
    return Progress(step.state, onward, dt, past, memory, usual)


def _minimiser(problem: Problem, progress: Progress) -> Minimiser:
    """Return the minimiser of a scene, with what earlier steps left for the next ones."""
    stepping, memory = problem.scene.stepping, progress.memory
    limits = stepping.tolerance, stepping.iterations
    minimiser = Minimiser(problem.n_dofs, problem.held, *limits, memory, stepping.solver)
    if memory is not None and memory.point is not None:
        last = TimeStep(progress.previous_dt, stepping.balance)
        before = progress.state.updated(displacement=progress.past[-1].displacement)
        minimiser.remember(problem.potentials(before, last), memory.point)
    minimiser.deadline = problem.deadline
    return minimiser


def _length(progress: Progress, stepping: Stepping, until: float) -> float:
    """Return the length of the next step, which ends at the next stop rather than just before it."""
    now = progress.state.time
    left = min((stop for stop in stepping.stops if stop > now + 1e-12 * until), default=until) - now
    return left if left < 1.01 * progress.dt else progress.dt


def _onward(dt: float, iterations: float, stepping: Stepping, until: float) -> float:
    """Return the length of the step after one that took so many iterations."""
    share = iterations / stepping.iterations
    factor = LONGER if share <= EASY else 1.0 if share <= HARD else 1 / LONGER
    return max(min(factor * dt, stepping.largest * until), stepping.smallest * until)


def _attempt(
    problem: Problem, minimiser: Minimiser, progress: Progress, dt: float, began: float, way: str,
    strict: bool,
) -> Step:  # fmt: skip
    """Take one step from untouched data.

    way: SNAPS, to wherever the gradient flow from there ends; DAMPED, by the implicit Euler rule, which ends
    where forces balance, instead of by one that goes on past that; its damping vanishes with the step.
    strict: whether an end that is no body, after a start that is one, is refused.
    """
    old, effort = progress.state, minimiser.effort
    iterations, factorizations = effort.iterations, effort.factorizations
    usual = problem.scene.stepping.balance
    step = TimeStep(dt, 1.0 if way == DAMPED else usual)
    state = balanced = problem.processed(old, dt)
    if step.balance < 1:
        balanced = problem.processed(old, step.span)
    potentials = problem.potentials(balanced, step)
    effort.add("processes", began)
    x = by_node(old["displacement"])
    found = _found(problem, minimiser, potentials, x, _predicted(progress, dt), way, step.balance)
    at = found.at if step.balance == 1 else _at_end(problem, state, step, old, found.at)
    if at is not found.at:
        minimiser.forget()
    if strict and not at.is_valid and _starts_valid(potentials, x):
        raise InadmissibleStateError(
            "at the end of the step walls cross or triangles are turned over", time=state.time
        )
    energy = problem.potential_energy(state, step, at)
    state = state.updated(displacement=at.x.reshape(-1, 2).T.copy())
    onward = longest_next(progress.equilibria, state.time, state["displacement"], problem.scene.stepping)
    state = problem.finished(state, found.at)
    numbers = {
        "time": state.time,
        "step": dt,
        "energy": energy,
        "residual": found.residual,
        "negative_pivots": found.negative_pivots,
        "snapped": float(way == SNAPS),
        "newton_iterations": effort.iterations - iterations,
        "factorizations": effort.factorizations - factorizations,
        "seconds": perf_counter() - began,
    }
    if problem.holds.size:
        numbers["holding_force"] = problem.holding_force(at)
    if usual < 1:
        numbers["damped"] = float(way == DAMPED)
    for evaluation in at.evaluations:
        numbers |= evaluation.measure()
    return Step(state, at, numbers, dict(effort.seconds), onward)


def _found(
    problem: Problem, minimiser: Minimiser, potentials: Potentials, x: Array, ahead: Array | None, way: str,
    balance: float,
) -> Equilibrium:  # fmt: skip
    """Return the equilibrium after x, with potentials that are fine enough for the step that it makes.

    ahead: where it may be.  balance: share of the step after which forces balance.
    """
    found = _equilibrium(problem, minimiser, potentials, x, ahead, way)
    for _ in range(REFINEMENTS):
        finer = _finer(potentials, found.at.evaluations)
        if balance < 1 and all(one is other for one, other in zip(finer, potentials, strict=True)):
            end = configuration(potentials, _moved_on(x, found.at.x, balance))
            finer = finer if end is None else _finer(potentials, end.evaluations)
        if all(one is other for one, other in zip(finer, potentials, strict=True)):
            break
        minimiser.forget()
        try:
            found, potentials = _equilibrium(problem, minimiser, finer, x, ahead, way), finer
        except SolveError:
            if way != SNAPS:  # a shorter step may do
                raise
            break
    return found


def _starts_valid(potentials: Potentials, x: Array) -> bool:
    start = configuration(potentials, x)
    return start is not None and start.is_valid


def _finer(potentials: Potentials, evaluations: tuple[Evaluation, ...]) -> Potentials:
    """Return the potentials, those that are too coarse for what was found by finer ones."""
    pairs = zip(potentials, evaluations, strict=True)
    return tuple(evaluation.finer() or potential for potential, evaluation in pairs)


def _moved_on(x: Array, middle: Array, balance: float) -> Array:
    """Return where a step from x ends that goes on evenly after forces balance in the middle."""
    return x + (middle - x) / balance


def _equilibrium(
    problem: Problem, minimiser: Minimiser, potentials: Potentials, x: Array, ahead: Array | None, way: str
) -> Equilibrium:
    if way != SNAPS:
        return minimiser.minimise(potentials, x, ahead)
    from .snap import Creep

    return problem.kept("creep", Creep.of).to_minimum(minimiser, potentials, x)


def _at_end(problem: Problem, end: State, step: TimeStep, old: State, found: Configuration) -> Configuration:
    """Return the configuration at the end of a step in whose middle forces balance, moved on evenly."""
    x = _moved_on(by_node(old["displacement"]), found.x, step.balance)
    if found.largest_step(x - found.x) < 1.0:
        raise InadmissibleStateError("the end of the step is not admissible", time=end.time)
    at = configuration(problem.potentials(end, step), x)
    if at is None:
        raise InadmissibleStateError("the end of the step is not admissible", time=end.time)
    return at


def _predicted(progress: Progress, dt: float) -> Array | None:
    """Return the displacement expected dt ahead; None if there is no past."""
    if not progress.past:
        return None
    return by_node(extrapolated(progress.equilibria, progress.state.time + dt))
