"""An equilibrium that was computed before, and its factorised tangent."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array
from ..checks import instance, whole
from ..errors import NotConvergedError
from ..geometry.body import by_node
from ..parts import TimeStep
from ..results.result import Result
from ..solve.inertia import Factors, Indefinite
from ..solve.problem import Configuration, Problem, configuration
from ..solve.sparsity import Assembler
from ..state import State
from .change import Change, Still, change, check_path
from .validity import lowest_eigenvalue


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state of a result that is in equilibrium.

    x: its displacement, (2 n_nodes,).  step: in which the scene is there, for good.  still: of `change`.
    """

    problem: Problem
    state: State
    x: Array
    step: TimeStep
    at: Configuration
    still: Still

    @classmethod
    def of(cls, result: Result, number: int) -> Equilibrium:
        """Return that of a state by its number.

        Raises ValueError for scenes whose state depends on the way to it, NotConvergedError for a state that
        is no equilibrium.
        """
        instance("result", result, Result, "simulate(scene)")
        count = len(result.states)
        if whole("step", number, at_least=-count) >= count:
            raise ValueError(
                f"step={number}: the result has the states 0 to {count - 1}, or -1 for its last."
            )
        problem, state = Problem(result.scene), result.states[number]
        if not state.time:
            raise ValueError(f"step={number} is the start, before anything has grown; choose a later state.")
        check_path(problem, result.states[0])
        x, step = by_node(state["displacement"]), TimeStep(state.time, over=True)
        return cls(problem, state, x, step, _balanced(problem, state, step, x), {})

    @cached_property
    def tangent(self) -> Tangent:
        """Its tangent, factorised."""
        return Tangent(self.problem, self.at)

    @property
    def stability(self) -> float:
        """The lowest eigenvalue of the tangent over that at the scene's start."""
        return self.tangent.lowest / Tangent(self.problem, _start_of(self.problem)).lowest

    def change(self, parameter: str) -> Change:
        """Return how forces and energy change with a parameter while the body stays."""
        return change(self.problem, self.state, self.x, parameter, self.step, self.still)


def _balanced(problem: Problem, state: State, last: TimeStep, x: Array) -> Configuration:
    """Return the equilibrium at a state."""
    at = configuration(problem.potentials(state, last), x)
    if at is None:
        raise NotConvergedError("the state is not admissible", time=state.time)
    residual = at.forces(Assembler(problem.n_dofs, problem.held).free)[1]
    if residual > 10 * problem.scene.stepping.tolerance:
        raise NotConvergedError(
            f"the state at t = {state.time:.4g} is no equilibrium, its residual is {residual:.2g}; "
            "run its scene again",
            time=state.time,
        )
    return at


def _start_of(problem: Problem) -> Configuration:
    """Return the configuration that the scene starts from."""
    start, length = problem.start(), problem.scene.stepping.first * problem.scene.until
    at = configuration(problem.potentials(start, TimeStep(length)), by_node(start["displacement"]))
    if at is None:
        raise NotConvergedError("the scene's start is not admissible", time=0.0)
    return at


class Tangent:
    """The factorised tangent of an equilibrium."""

    def __init__(self, problem: Problem, at: Configuration) -> None:
        self.assembler = Assembler(problem.n_dofs, problem.held)
        self.sparsity, self.values = self.assembler.assemble(at.hessians(0.0))
        self.factors: Factors = Indefinite(self.sparsity).factorize(self.values)

    @property
    def lowest(self) -> float:
        """The eigenvalue nearest to zero."""
        return lowest_eigenvalue(self.factors, len(self.assembler.free))

    def solve(self, gradient: Array) -> Array:
        """Return K⁻¹ of forces, (2 n_nodes,), refined once as the pivots are not chosen."""
        free = self.assembler.free
        b, whole = gradient[free], np.zeros(len(gradient))
        found = self.factors.solve(b)
        found += self.factors.solve(b - self.sparsity.product(self.values)(found))
        whole[free] = found
        return whole
