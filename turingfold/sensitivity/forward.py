"""Derivatives of an equilibrium with respect to parameters of its parts.

Where forces balance, g(x, p) = 0, the body moves with a parameter by dx/dp = -K⁻¹ ∂g/∂p, K = ∂g/∂x the
tangent that certified the equilibrium; contact is in K like everything else. What is measured on the pial
surface follows by the chain rule. The energy changes by ∂E/∂p alone, as the forces vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import instance
from ..errors import NotConvergedError
from ..geometry.body import by_node
from ..morphometry.folds import sulcal_depth
from ..morphometry.shape import gyrification_index
from ..parts import TimeStep
from ..results.result import Result
from ..results.surface import along_pial, pial_closed
from ..solve.inertia import Factors, Indefinite
from ..solve.problem import Configuration, Problem, configuration
from ..solve.sparsity import Assembler
from ..state import State
from .parameters import Change, change, check_path, number_of
from .validity import MISSED, lowest_eigenvalue, range_of

Measure = Callable[[Array], float]
ENERGY = "energy"


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives at one equilibrium.

    parameters, values: what they are with respect to, p of them.  measures, numbers: what of, m of them.
    derivatives: (m, p).  displacement: dx/dp, (p, 2, n_nodes); m per unit of the parameter.
    errors: of ∂g/∂p, relative, (p,).  negative_pivots: of the tangent; 0 at a minimum.
    ranges: by what share of itself each parameter may change until dx/dp misses a tenth of the displacement,
    (p,), at most 1.  stability: lowest eigenvalue of the tangent over that at the scene's start; 0: a snap.
    """

    parameters: tuple[str, ...]
    values: Array
    measures: tuple[str, ...]
    numbers: Array
    derivatives: Array
    displacement: Array
    errors: Array
    negative_pivots: int
    ranges: Array
    stability: float

    def of(self, measure: str, parameter: str) -> float:
        """Return one derivative."""
        return float(self.derivatives[self.measures.index(measure), self.parameters.index(parameter)])

    @property
    def relative(self) -> Array:
        """By how many per cent each measure changes with one per cent of each parameter, (m, p)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.derivatives * self.values / self.numbers[:, None])

    def deviations(self, deviations: Sequence[float]) -> Array:
        """Return the standard deviations of the measures, (m,), for those of independent parameters, (p,)."""
        return np.asarray(np.sqrt(((self.derivatives * np.asarray(deviations)) ** 2).sum(1)))

    def text(self) -> str:
        """Return the table: one per cent more of a parameter changes a measure by so many per cent."""
        width = max(len(name) for name in self.parameters)
        head = " ".join(f"{name:>20}" for name in self.measures)
        lines = [f"{'1 % more of':<{width}} {head} {'good for':>12}"]
        for name, row, reach in zip(self.parameters, self.relative.T, self.ranges, strict=True):
            numbers = " ".join(f"{value:>+18.3f} %" for value in row)
            lines.append(f"{name:<{width}} {numbers} {f'±{100 * reach:.2g} %':>12}")
        lines.append(
            f"good for: changes of the parameter within which the linear answer errs by up to {MISSED:.0%}\n"
            f"the lowest eigenvalue of the tangent is {self.stability:.2g} times that of the start (0: snap)"
        )
        return "\n".join(lines)


def sensitivity(
    result: Result,
    *,
    to: Sequence[str],
    of: Sequence[str | Measure] = ("gyrification_index", "perimeter", "sulcal_depth", ENERGY),
    step: int = -1,
) -> Sensitivity:
    """Return the derivatives of measures of a state with respect to parameters of its parts.

    to: parameters such as "TangentialGrowth.cortex", "Elastic.gray.mu", "AxonalTension.strength".
    of: "gyrification_index", "perimeter" (m), "sulcal_depth" (m), "energy" (J/m), or functions of the pial
    points (2, n) in m.
    Raises ValueError for scenes whose state depends on the way to it (drag, inertia, growth by stress,
    patterns that evolve) and for what is no parameter; NotConvergedError for a state that is no equilibrium.
    """
    instance("result", result, Result, "simulate(scene)")
    scene, state = result.scene, result.states[step]
    values = np.array([number_of(scene, parameter) for parameter in to])
    problem = Problem(scene)
    check_path(problem, result.states[0])
    x, last = by_node(state["displacement"]), TimeStep(state.time or scene.until, over=True)
    at = _balanced(problem, state, last, x)
    tangent = Tangent(problem, at)
    changes = [change(scene, state, x, parameter, last) for parameter in to]
    moves = np.stack([-tangent.solve(found.gradient) for found in changes])
    measures = dict(_measure(result, item) for item in of)
    points = _pial(result, x)
    rows = [_row(result, points, measure, moves, changes) for measure in measures.values()]
    numbers = [at.energy if measure is None else measure(points) for measure in measures.values()]
    return Sensitivity(
        parameters=tuple(to), values=values, measures=tuple(measures), numbers=np.array(numbers),
        derivatives=np.array(rows).reshape(len(measures), len(to)),
        displacement=moves.reshape(len(to), -1, 2).swapaxes(1, 2),
        errors=np.array([found.error for found in changes]), negative_pivots=tangent.factors.negative,
        ranges=np.array([
            range_of(scene, state, move, name, last, tangent.factors)
            for name, move in zip(to, moves, strict=True)
        ]),
        stability=tangent.lowest / Tangent(problem, _first(problem)).lowest,
    )  # fmt: skip


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


def _first(problem: Problem) -> Configuration:
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
        found += self.factors.solve(b - self.sparsity.times(self.values, found))
        whole[free] = found
        return whole


def perimeter(points: Array, closed: bool) -> float:
    """Return the length of a polygon (2, n); m."""
    return float(np.hypot(*np.diff(points, axis=1, append=points[:, :1] if closed else points[:, -1:])).sum())


def _measure(result: Result, item: str | Measure) -> tuple[str, Measure | None]:
    """Return a measure's name and its function of the pial points; None for the energy."""
    closed, thickness = pial_closed(result.scene.body), result.scene.body.thickness
    known: dict[str, Measure | None] = {
        "gyrification_index": lambda points: gyrification_index(points, closed=closed),
        "perimeter": lambda points: perimeter(points, closed),
        "sulcal_depth": lambda points: float(sulcal_depth(points, closed=closed, thickness=thickness)),
        ENERGY: None,
    }
    if callable(item):
        return getattr(item, "__name__", "measure"), item
    if item not in known:
        raise ValueError(f"of={item!r} must be one of {', '.join(known)}, or a function of points (2, n).")
    return item, known[item]


def _pial(result: Result, x: Array) -> Array:
    body = result.scene.body
    return along_pial(body, (body.nodes + x.reshape(-1, 2).T)[:, body.pial])


def _row(
    result: Result, points: Array, measure: Measure | None, moves: Array, changes: list[Change]
) -> list[float]:
    """Return the derivatives of one measure, by extrapolated differences along each motion."""
    if measure is None:
        return [found.energy for found in changes]
    body, row = result.scene.body, []
    for move in moves:
        way = _pial(result, move) - along_pial(body, body.nodes[:, body.pial])
        largest = float(np.abs(way).max())
        if not largest > 0:
            row.append(0.0)
            continue
        h = 1e-4 * body.thickness / largest
        wide, narrow = (
            (measure(points + s * way) - measure(points - s * way)) / (2 * s) for s in (h, 0.5 * h)
        )
        row.append((4 * narrow - wide) / 3)
    return row
