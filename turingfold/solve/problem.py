"""The equilibrium problem of a scene: what march, buckling and paths of equilibria solve.

Processes give the fields at a time, terms give energies of the displacement under these fields. The forces
are the gradient of their sum; forces small against those that balance in it make an equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import Any, TypeVar

import numpy as np

from ..arrays import Array, Integers
from ..errors import InadmissibleStateError
from ..geometry.body import by_node
from ..parts import (
    Abrupt,
    Condensed,
    Evaluation,
    Evolution,
    Hessian,
    LongEvolution,
    Operator,
    Potential,
    Process,
    SearchLine,
    Term,
    TimeStep,
    check_kind,
    declared,
)  # fmt: skip
from ..scene import Scene, stress_scale
from ..state import State
from .line_search import Straight

Kept = TypeVar("Kept")


@dataclass(frozen=True, eq=False)
class Configuration:
    """All potentials at one displacement x, (2 n_nodes,)."""

    x: Array
    potentials: tuple[Potential, ...]
    evaluations: tuple[Evaluation, ...]

    @cached_property
    def energy(self) -> float:
        """The sum of the energies; J per m of depth."""
        return sum(e.energy for e in self.evaluations)

    @property
    def round_off(self) -> float:
        """Differences of energy below this are round-off."""
        return sum(e.round_off for e in self.evaluations)

    @property
    def is_condensed(self) -> bool:
        """Whether unknowns inside the elements are eliminated."""
        return any(isinstance(e, Condensed) for e in self.evaluations)

    @property
    def is_valid(self) -> bool:
        """Whether this may be a body: nothing is turned over and no walls cross."""
        return all(e.is_valid() for e in self.evaluations)

    def forces(self, free: Integers) -> tuple[Array, float]:
        """Return the gradient on the free unknowns, and its size relative to the forces that balance."""
        parts = [e.gradient() for e in self.evaluations]
        gradient = np.sum([g for g, _ in parts], axis=0)[free]
        scale = np.sqrt(sum(s for _, s in parts))
        return gradient, float(np.linalg.norm(gradient) / (scale if scale > 0 else 1.0))

    @property
    def is_abrupt(self) -> bool:
        """Whether walls touch, so that the tangent may change within any distance."""
        return any(isinstance(e, Abrupt) and e.has_hessian for e in self.evaluations)

    def hessians(self, convexity: float, abrupt: float = 0.0) -> list[Hessian]:
        """Return the Hessians of the energies that have one, blended towards their positive parts.

        abrupt: convexity of those that are `Abrupt`, at least.
        """
        return [
            e.hessian(max(convexity, abrupt) if isinstance(e, Abrupt) else convexity)
            for e in self.evaluations if e.has_hessian
        ]  # fmt: skip

    def largest_step(self, direction: Array) -> float:
        """Return a step in (0, 1] along a direction that keeps the state admissible."""
        return min((e.largest_step(direction) for e in self.evaluations), default=1.0)

    def search_lines(self, direction: Array, decrease: float) -> list[SearchLine]:
        """Return how each energy follows a direction; decrease: slope of the total energy along it."""
        return [
            e.along(direction, decrease) if isinstance(e, Condensed) else Straight(p, e, self.x, direction)
            for p, e in zip(self.potentials, self.evaluations, strict=True)
        ]

    def at(
        self, lines: Sequence[SearchLine], direction: Array, step: float
    ) -> tuple[float, Configuration] | None:
        """Return the merit and the configuration a step along a direction; None where it is inadmissible."""
        found = []
        for line in lines:
            there = line.at(step)
            if there is None:
                return None
            found.append(there)
        parts = tuple(e for _, e in found)
        return sum(m for m, _ in found), Configuration(self.x + step * direction, self.potentials, parts)


def configuration(potentials: tuple[Potential, ...], x: Array) -> Configuration | None:
    """Return the potentials at x, or None where one energy is infinite."""
    found = []
    for potential in potentials:
        at = potential.evaluate(x)
        if at is None or not np.isfinite(at.energy):
            return None
        found.append(at)
    return Configuration(x, potentials, tuple(found))


class Problem:
    """A scene on its body: operators of its terms, processes, and the degrees of freedom that are held.

    deadline: of `time.perf_counter`, at which the scene's time limit is over; it counts from here.
    """

    def __init__(self, scene: Scene) -> None:
        """Compute what is computed once."""
        body = scene.body
        self.scene = scene
        self.deadline = perf_counter() + scene.stepping.seconds
        self.operators: list[Operator] = [term.on(body) for term in scene.terms]
        self._processes: list[tuple[Process, Evolution]] = [(p, p.on(body)) for p in scene.processes]
        for term, operator in zip(scene.terms, self.operators, strict=True):
            check_kind(term, operator, Operator)
        for process, evolution in self._processes:
            check_kind(process, evolution, Evolution)
        for evolution in (e for _, e in self._processes if isinstance(e, LongEvolution)):
            evolution.deadline = self.deadline
        supported = any(operator.resists_rigid_motions for operator in self.operators)
        self.held: Integers = body.supported if supported else body.fixed
        if not supported:
            for operator in self.operators:
                operator.check_balance()
        self.holds: Integers = np.setdiff1d(self.held, body.supported)  # of parts that are free
        self.n_dofs = body.nodes.size
        self._kept: dict[str, Any] = {}

    def kept(self, name: str, make: Callable[[Scene], Kept]) -> Kept:
        """Return what `make` makes of the scene, made once."""
        if name not in self._kept:
            self._kept[name] = make(self.scene)
        found: Kept = self._kept[name]
        return found

    def start(self) -> State:
        """Return the state that the scene starts from."""
        scale = np.array(stress_scale(self.scene.terms))
        state = State(0.0, {"displacement": np.zeros_like(self.scene.body.nodes), "stress_scale": scale})
        for process, evolution in self._processes:
            state = state.updated(**declared(process, evolution.start(state, self.scene.seed), "start"))
        _check_finite(state)
        wanted = self.scene.wanted
        potentials = self.potentials(
            state, TimeStep(self.scene.stepping.first * self.scene.until),
            lambda term: not wanted.isdisjoint(term.writes),
        )  # fmt: skip
        if not potentials:
            return state
        at = configuration(potentials, by_node(state["displacement"]))
        if at is None:
            raise InadmissibleStateError("the energy at the scene's start is infinite", time=0.0)
        return self.finished(state, at)

    def processed(self, before: State, dt: float) -> State:
        """Return `before` with the time and the fields of the processes dt later; the rest is as it was."""
        now = State(before.time + dt)
        for number, (process, evolution) in enumerate(self._processes):
            made = declared(process, evolution.advance(before, now, dt), "advance")
            kept = {name: before[name] for name in process.writes if name in before and name not in made}
            if rewritten := [name for name in kept if self._rewritten(number, name)]:
                raise ValueError(
                    f"{type(process).__name__}.advance returned no {rewritten[0]!r}, which a later process "
                    "rewrites; return it at every step."
                )
            now = now.updated(**kept, **made)
        state = before.updated(now.time, **now.fields)
        _check_finite(state)
        return state

    def potentials(
        self, state: State, step: TimeStep, among: Callable[[Term], bool] = lambda term: True
    ) -> tuple[Potential, ...]:
        """Return the potentials that act in a step; `state` is that in which forces balance.

        among: which terms are asked, all unless it is given.
        """
        asked = zip(self.scene.terms, self.operators, strict=True)
        acting = (operator.during(state, step) for term, operator in asked if among(term))
        return tuple(potential for potential in acting if potential is not None)

    def potential_energy(self, state: State, step: TimeStep, at: Configuration) -> float:
        """Return the energy that is stored in a configuration: none of terms that resist motion.

        Their incremental potentials depend on the length of the step.
        """
        if not any(term.resists_motion for term in self.scene.terms):
            return at.energy
        stored = configuration(self.potentials(state, step, lambda term: not term.resists_motion), at.x)
        return float("nan") if stored is None else stored.energy

    def holding_force(self, at: Configuration) -> float:
        """Return the largest force at nodes that only hold free parts in place; N per m of depth."""
        forces = np.sum([evaluation.gradient()[0] for evaluation in at.evaluations], axis=0)
        return float(np.abs(forces[self.holds]).max())

    def finished(self, state: State, at: Configuration) -> State:
        """Return the state with those fields of the terms that some part reads.

        Raises InadmissibleStateError where one is not finite, as the stress where a triangle is turned over.
        """
        wanted, writes = self.scene.wanted, {n for term in self.scene.terms for n in term.writes}
        for evaluation in at.evaluations:
            made = evaluation.finish(wanted)
            if undeclared := set(made) - writes:
                raise ValueError(
                    f"{type(evaluation).__name__}.finish returned {', '.join(sorted(undeclared))}, which no "
                    "term declares in `writes`."
                )
            state = state.updated(**made)
        _check_finite(state)
        return state

    def _rewritten(self, number: int, name: str) -> bool:
        return any(name in later.writes for later, _ in self._processes[number + 1 :])


def _check_finite(state: State) -> None:
    """Raise InadmissibleStateError for a field that is not finite, by name."""
    for name, values in state.fields.items():
        if not np.isfinite(values).all():
            raise InadmissibleStateError(
                f"the field {name!r} is not finite at t = {state.time:.4g}", time=state.time
            )
