"""How far derivatives at an equilibrium can be trusted: to the next instability, and for what changes.

An equilibrium is lost where the lowest eigenvalue of its tangent reaches zero. Before that, with p + δ the
body at x + δ dx/dp misses the new equilibrium by about K⁻¹ g(x + δ dx/dp, p + δ), which grows with δ².
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array, Booleans
from ..geometry.body import by_node
from ..parts import TimeStep
from ..solve.inertia import Factors
from ..solve.problem import Problem, configuration
from ..solve.sparsity import Assembler
from ..state import State
from .change import fields_of, operators_of
from .parameters import changed_in, number_of

MISSED = 0.1  # share of a displacement that the linear answer may miss
UNSEEN = 1e-9  # share of a measure that is no change of it
NEARLY = 0.8, 1.25  # shares of that which will do
SMALL = 1e-3  # thicknesses of the cortex by which points move in the trial
STILL = 1e-9  # thicknesses that are no motion
TRIALS, LONGEST = 6, 2.0  # at most; and by how much the later ones may go farther each
REFUSALS = 20  # of trials, at most
POWERS = 40  # of the inverse: the lowest eigenvalue is then known to a few per cent
ALIKE = 1e-3  # relative change of it at which they end


def is_seen(lost: Array, value: float, numbers: Array) -> Booleans:
    """Return of which measures, (m,), what a parameter's kink leaves open of the derivatives is no round-off.

    lost: by how much these may err.  value: of the parameter; beside 0 it is by its unit.  numbers: measured.
    """
    seen: Booleans = lost * (abs(value) or 1.0) > UNSEEN * np.abs(numbers)
    return seen


def is_kinked(lost: Array, derivatives: Array, value: float, numbers: Array) -> Booleans:
    """Return of which measures, (m,), a kink leaves MISSED of the derivatives open; see `is_seen`."""
    kinked: Booleans = is_seen(lost, value, numbers) & (lost > MISSED * np.abs(derivatives))
    return kinked


def lowest_eigenvalue(factors: Factors, n: int) -> float:
    """Return the eigenvalue nearest to zero of a factorised symmetric matrix, by powers of its inverse."""
    v, found = np.random.default_rng(0).standard_normal(n), float("inf")
    for _ in range(POWERS):
        v /= np.linalg.norm(v)
        solved = factors.solve(v)
        before, found, v = found, 1.0 / float(solved @ v), solved
        if abs(found - before) < ALIKE * abs(found):
            break
    return found


def range_of(
    problem: Problem, state: State, move: Array, parameter: str, step: TimeStep, factors: Factors
) -> float:
    """Return by what share of itself a parameter may change until the linear answer misses MISSED.

    Of the displacement, in its nodes' norm, whichever way it changes; first by the second order, from a small
    trial, then by trials at the range itself, where walls may have met, or beside which a kink may lie.
    move: dx/dp, (2 n_nodes,).  At most 1; infinite where nothing moves, NaN of a parameter that is 0, 0 where
    not the least change is admissible or as good.
    """
    value, largest = number_of(problem.scene, parameter), float(np.abs(move).max())
    if not value:
        return float("nan")
    if abs(value) * largest <= STILL * problem.scene.body.thickness:  # as much again moves nothing
        return float("inf")

    def share_at(change: float) -> float | None:
        ways = (_missed(problem, state, way * change, move, parameter, step, factors) for way in (1, -1))
        return max((share for share in ways if share is not None), default=None)

    first = min(SMALL * problem.scene.body.thickness / largest, abs(value))
    return _good(share_at, first, abs(value)) / abs(value)


def _good(share_at: Callable[[float], float | None], change: float, most: float) -> float:
    """Return the largest change tried at which the answer misses about MISSED or less, 0 without one.

    share_at: what it misses; None for what is not admissible.  change: to begin with; most: the largest.
    """
    known, refused, good = 0, 0, 0.0
    while known < TRIALS and refused < REFUSALS:
        share = share_at(change)
        if share is None:  # a limit of its part, or of the body, to both sides
            change *= 0.5
            refused += 1
            continue
        if share < NEARLY[1] * MISSED:
            good = max(good, change)
            if known and share > NEARLY[0] * MISSED:
                break
        change *= min(MISSED / max(share, 1e-300), LONGEST if known else np.inf)
        change = min(change, most)  # more than as much again is no small change
        known += 1
    return good


def _missed(
    problem: Problem, state: State, change: float, move: Array, parameter: str, step: TimeStep,
    factors: Factors,
) -> float | None:  # fmt: skip
    """Return the share of a displacement that the linear answer misses; None for what is not admissible."""
    try:
        changed = changed_in(problem.scene, parameter, number_of(problem.scene, parameter) + change)
        now = state.updated(**fields_of(problem.scene, changed, state))
        operators = operators_of(problem, changed)
    except ValueError:  # a part refuses it
        return None
    x, acting = by_node(state["displacement"]), (operator.during(now, step) for operator in operators)
    at = configuration(tuple(one for one in acting if one is not None), x + change * move)
    if at is None:
        return None
    free = Assembler(problem.n_dofs, problem.held).free
    missed = factors.solve(at.forces(free)[0])
    return float(np.linalg.norm(missed) / np.linalg.norm(change * move[free]))
