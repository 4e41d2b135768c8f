"""Derivatives of an equilibrium with respect to parameters of its parts.

Where forces balance, g(x, p) = 0, the body moves with a parameter by dx/dp = -K⁻¹ ∂g/∂p, K = ∂g/∂x the
tangent that certified the equilibrium; contact is in K like everything else. What is measured on the pial
surface follows by the chain rule. The energy changes by ∂E/∂p alone, as the forces vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import finite_array
from ..results.result import Result
from ..solve.threads import one_thread
from .change import rough_words, warn_of_rough
from .measures import MEASURES, Measure, measures_of, numbers_at, rate_along
from .parameters import counted, values_in
from .tangent import Equilibrium
from .validity import MISSED, UNSEEN, is_kinked, is_seen, range_of

ROUGH = 1e-2  # share of a measure's largest derivative that its kinks leave open, beyond which it is told


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives at one equilibrium.

    parameters, values: what they are with respect to, p of them.  measures, numbers: what of, m of them.
    derivatives: (m, p).  jumps: by how much they may err where a measure jumps or has a kink, as the depth
    where a sulcus comes to count, or forces have one in the parameter, (m, p).
    displacement: dx/dp, (p, 2, n_nodes); m per unit of the parameter.
    errors: of ∂g/∂p, relative, (p,).  negative_pivots: of the tangent; 0 at a minimum.
    ranges: by what share of itself each parameter may change until dx/dp misses a tenth of the displacement,
    whichever way, (p,), at most 1; 0 at a kink of which the sides differ by more.
    stability: lowest eigenvalue of the tangent over that at the scene's start; 0: a snap.
    """

    parameters: tuple[str, ...]
    values: Array
    measures: tuple[str, ...]
    numbers: Array
    derivatives: Array
    jumps: Array
    displacement: Array
    errors: Array
    negative_pivots: int
    ranges: Array
    stability: float

    def __repr__(self) -> str:
        """Return it in a line; `text()` is the table."""
        return f"Sensitivity(of {', '.join(self.measures)} to {counted(self.parameters)})"

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
        given = finite_array("deviations", deviations, (len(self.parameters),))
        if (given < 0).any():
            raise ValueError(f"deviations holds {given.min():g}; a standard deviation is 0 or more.")
        return np.asarray(np.sqrt(((self.derivatives * given) ** 2).sum(1)))

    def text(self) -> str:
        """Return the table: one per cent more of a parameter changes a measure by so many per cent."""
        width = max(len(name) for name in self.parameters)
        head = " ".join(f"{name:>20}" for name in self.measures)
        lines = [f"{'1 % more of':<{width}} {head} {'good for':>12}"]
        for name, row, reach in zip(self.parameters, self.relative.T, self.ranges, strict=True):
            numbers = " ".join(f"{value:>+18.3f} %" if np.isfinite(value) else f"{'-':>20}" for value in row)
            lines.append(f"{name:<{width}} {numbers} {f'±{100 * reach:.2g} %':>12}")
        lines.append(
            f"good for: changes of the parameter within which the linear answer errs by up to {MISSED:.0%}\n"
            f"the lowest eigenvalue of the tangent is {self.stability:.2g} times that of the start (0: snap)"
        )
        largest, open_ = (np.abs(own * self.values).max(1) for own in (self.derivatives, self.jumps))
        lines += [
            f"{name} jumps or has a kink here: its numbers may err by as much as {lost:.2g} of {size:.2g}"
            for name, number, lost, size in zip(self.measures, self.numbers, open_, largest, strict=True)
            if lost > max(ROUGH * size, UNSEEN * abs(number))
        ]
        lines += rough_words(self.parameters, np.where(np.isinf(self.ranges), 0.0, self.errors))
        return "\n".join(lines)


@one_thread
def sensitivity(
    result: Result, *, to: Sequence[str], of: Sequence[str | Measure] = MEASURES, step: int = -1
) -> Sensitivity:
    """Return the derivatives of measures of a state with respect to parameters of its parts.

    A solve for each parameter; `adjoint_sensitivity` takes one for each measure.
    to: parameters such as "TangentialGrowth.cortex", "Elastic.gray.mu", "AxonalTension.strength".
    of: "gyrification_index", "perimeter" (m), "sulcal_depth" (m), "energy" (J/m), or functions of the pial
    points (2, n) in m.
    Raises ValueError for scenes whose state depends on the way to it (drag, inertia, growth by stress,
    patterns that evolve), for what is no parameter, and for those that act in steps; NotConvergedError for a
    state that is no equilibrium. Warns of parameters with a kink that leaves the answer good for nothing.
    """
    here = Equilibrium.of(result, step)
    if not len(to):
        raise ValueError('to=() names no parameter; give some, such as ["Elastic.gray.mu"].')
    values = values_in(result.scene, to)
    changes = [here.change(parameter) for parameter in to]
    moves = np.stack([-here.tangent.solve(found.gradient) for found in changes])
    measures = measures_of(result, of)
    rows = [
        [(found.energy, 0.0) for found in changes]
        if measure is None
        else [rate_along(result, measure, here.x, move) for move in moves]
        for measure in measures.values()
    ]
    derivatives, jumps = np.moveaxis(np.array(rows).reshape(len(measures), len(to), 2), -1, 0)
    factors, errors = here.tangent.factors, np.array([found.error for found in changes])
    ranges = np.array([
        min(range_of(here.problem, here.state, move, name, here.step, factors), found.reach)
        for name, move, found in zip(to, moves, changes, strict=True)
    ])  # fmt: skip
    numbers = numbers_at(result, measures, here.x, here.at.energy)
    for k in np.flatnonzero(errors > ROUGH):
        beside = here.tangent.solve(changes[k].lost)
        lost = np.array([
            changes[k].lost_energy if measure is None else abs(rate_along(result, measure, here.x, beside)[0])
            for measure in measures.values()
        ])  # fmt: skip
        seen = is_seen(lost, values[k], numbers).any()
        if np.isinf(ranges[k]) and not seen:  # what it changes is round-off
            continue
        jumps[:, k] = np.maximum(jumps[:, k], lost)
        differs = is_kinked(lost, derivatives[:, k], values[k], numbers).any()
        if differs or np.linalg.norm(beside) > MISSED * np.linalg.norm(moves[k]):
            ranges[k] = 0.0
    warn_of_rough(to, np.where(ranges == 0, errors, 0.0))
    return Sensitivity(
        parameters=tuple(to), values=values, measures=tuple(measures),
        numbers=numbers,
        derivatives=derivatives, jumps=jumps,
        displacement=moves.reshape(len(to), -1, 2).swapaxes(1, 2),
        errors=errors, negative_pivots=factors.negative, ranges=ranges,
        stability=here.stability,
    )  # fmt: skip
