"""A state on another body of the same shape, and what its equilibrium answers there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..geometry.body import Body, by_node
from ..parts import Evolution, Fields, LongEvolution, Process, TimeStep
from ..scene import Scene
from ..solve.inertia import Indefinite
from ..solve.linear import NotPositiveDefinite, solver_for
from ..solve.problem import Configuration, Problem, configuration
from ..solve.sparsity import Sparsity
from ..stability.path_dependence import remembers
from ..state import State


class NoEstimateError(Exception):
    """There is no estimate of an error; the message says why."""


def refuse_motion(scene: Scene) -> None:
    """Raise NoEstimateError for a scene with terms that resist motion."""
    if any(term.resists_motion for term in scene.terms):
        raise NoEstimateError("errors of a motion add up over its steps; see turingfold accuracy")


def on_another_body(
    scene: Scene, state: State, body: Body, carried: Callable[[str, Array], Array]
) -> tuple[Problem, Configuration]:
    """Return a scene's problem on another body, and there the configuration of a state.

    carried: what carries a field, by name and values, over; others are computed on the body anew.
    Raises NoEstimateError where the body cannot take the state.
    """
    known = _known(scene)
    given = _Given({name: carried(name, state[name]) for name in known})
    others = (process for process in scene.processes if known.isdisjoint(process.writes))
    processes = (given, *others) if known else scene.processes
    terms = tuple(term.for_states_of(scene.body) for term in scene.terms)
    own = Problem(replace(scene, body=body, processes=processes, terms=terms))
    start = own.start()
    now = own.processed(start, state.time) if state.time else start
    now = now.updated(displacement=carried("displacement", state["displacement"]))
    at = _configuration(own, now)
    if at.is_condensed:  # what is inside the elements has settled now; tangents begin with it
        at = _configuration(own, own.finished(now, at))
    return own, at


def at_rest(problem: Problem, state: State) -> Configuration:
    """Return the configuration of a state of the problem, in equilibrium."""
    return _configuration(problem, state, over=True)


def _known(scene: Scene) -> set[str]:
    """Return the fields that are carried over, as to compute them anew takes all steps or long."""
    known = {
        name
        for process in scene.processes
        if remembers(process, scene) or isinstance(process.on(scene.body), LongEvolution)
        for name in process.writes
    }
    # with a field, all that its writers write
    while more := {n for p in scene.processes if not known.isdisjoint(p.writes) for n in p.writes} - known:
        known |= more
    return known


def _configuration(problem: Problem, state: State, *, over: bool = False) -> Configuration:
    step = TimeStep(state.time or problem.scene.until, over=over)
    at = configuration(problem.potentials(state, step), by_node(state["displacement"]))
    if at is None:
        raise NoEstimateError("walls cross or triangles turn over in the state on a finer mesh")
    return at


def forces_of(at: Configuration) -> Array:
    """Return the gradient of all energies, (2 n,)."""
    return np.asarray(np.sum([e.gradient()[0] for e in at.evaluations], axis=0))


def solution(sparsity: Sparsity, values: Array, scene: Scene) -> Callable[[Array], Array]:
    """Return what solves with the tangent of the state."""
    solver = solver_for(sparsity, scene.stepping.solver)
    try:
        solver.factorize(values)
    except NotPositiveDefinite:  # a saddle
        return Indefinite(sparsity).factorize(values).solve
    return solver.solve


@dataclass(frozen=True, eq=False)
class _Given(Process):
    """Fields that are known already."""

    fields: Fields

    @property
    def writes(self) -> tuple[str, ...]:
        return tuple(self.fields)

    @property
    def keeps(self) -> tuple[str, ...]:
        return tuple(self.fields)

    def on(self, body: Body) -> _GivenOnBody:
        return _GivenOnBody(self.fields)


@dataclass(frozen=True, eq=False)
class _GivenOnBody(Evolution):
    fields: Fields

    def start(self, state: State, seed: int) -> Fields:
        return dict(self.fields)

    def advance(self, before: State, now: State, dt: float) -> Fields:
        return dict(self.fields)
