"""Steady patterns: run until the pattern stands, then Newton's method and a certificate of stability."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np

from ..arrays import Array, Complexes
from ..errors import NotConvergedError
from .eigenvalues import eigenvalue_near, eigenvalue_right, rightmost_eigenvalues
from .integrators.rosenbrock import march
from .reaction_diffusion import ReactionDiffusion

STANDS = 1e-12  # relative rate below which a state stands, also one that is unstable
PUSH, PUSHES, POWERS = (
    0.02,
    3,
    8,
)  # away from it: share of the pattern's height, how often; iterations for its mode


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A steady state with its certificate.

    state: u and v at the nodes, shape (2, n_nodes).
    residual: largest entry of M f − D K w after Newton's method, relative to the sum of its parts' sizes.
    eigenvalues: of the linearised system, by descending real part, the rightmost ones.
    time, steps: of the run that led there.  newton_iterations: to polish it.
    """

    state: Array
    residual: float
    eigenvalues: Complexes
    time: float
    steps: int
    newton_iterations: int

    @property
    def leading(self) -> complex:
        """The eigenvalue with the largest real part."""
        return complex(self.eigenvalues[0])

    @property
    def stable(self) -> bool:
        """Whether every perturbation decays."""
        return self.leading.real < 0


def relative_residual(system: ReactionDiffusion, state: Array) -> float:
    """Return the largest |M f − D K w| of the nodes over the largest |M| |∂f/∂w| |w| + D |K| |w|."""
    space, size = system.space, np.abs(state)
    p_u, p_v, q_u, q_v = (np.abs(values) for values in system.kinetics.derivatives(*state))
    reaction = abs(space.mass) @ np.stack([p_u * size[0] + p_v * size[1], q_u * size[0] + q_v * size[1]]).T
    diffusion = abs(space.stiffness) @ np.stack([system.d_u * size[0], system.d_v * size[1]]).T
    largest = (reaction + diffusion).max(axis=0) + np.finfo(float).tiny
    return float((np.abs(system.rate(state)).max(axis=1) / largest).max())


def newton(
    system: ReactionDiffusion, state: Array, *, tolerance: float = 1e-12, iterations: int = 30
) -> tuple[Array, float, int]:
    """Solve M f(w) = D K w by Newton's method; return the state, its relative residual and the iterations.

    Factors are kept while each iteration reduces the residual tenfold.

    Raises NotConvergedError if the residual does not fall below the tolerance.
    """
    residual, solve = relative_residual(system, state), None
    for iteration in range(iterations):
        if residual <= tolerance:
            return state, residual, iteration
        solve = solve or system.solver(state)
        state = state + solve(system.rate(state))
        if not np.isfinite(state).all():
            break
        last, residual = residual, relative_residual(system, state)
        if residual > 0.1 * last:  # the factors have aged
            solve = None
    if residual <= tolerance:
        return state, residual, iterations
    raise NotConvergedError(
        f"Newton's method for a steady state stopped at a relative residual of {residual:.3g} (wanted "
        f"{tolerance:.3g}) after {iterations} iterations; start nearer to it, with a longer run.",
        residual=residual,
    )


def relative_rate(system: ReactionDiffusion, state: Array) -> float:
    """Return the largest rate of change over the pattern's height and the fastest reaction rate."""
    fastest = max(float(np.abs(values).max()) for values in system.kinetics.derivatives(*state))
    change = np.abs(system.rate(state)) / abs(system.space.mass).sum(axis=0)
    height = np.ptp(state, axis=1) + np.finfo(float).tiny
    return float((change.max(axis=1) / height).max() / fastest)


def settle(
    system: ReactionDiffusion,
    start: Array,
    *,
    until: float = math.inf,
    steps: int = 1000,
    tolerance: float = 1e-2,
    tolerated: float = 0.0,
    deadline: float = math.inf,
    least: Array | float = 0.0,
) -> SteadyState:
    """Run from a start until the pattern stands, polish it with Newton's method, and certify it.

    until, steps: longest time and largest number of steps to run.  tolerated: rate up to which a perturbation
    may grow.
    tolerance: local error of the run, relative; the end point does not depend on it.
    deadline: of `time.perf_counter`.  least: heights, (2,), below which nothing is left of a pattern.
    Raises NotConvergedError if nothing stable is reached by then, or nothing is left.
    """
    leading, time, taken = complex(math.nan), 0.0, 0
    for _ in range(PUSHES + 1):
        still_below, moment, state = 1e-3, None, start
        for moment in march(system, start, until=until - time, tolerance=tolerance):
            spent = time + moment.time, taken + moment.steps
            check_deadline(deadline, spent[0])
            if (np.ptp(moment.state, axis=1) < least).all():
                raise NotConvergedError(
                    f"nothing is left of the disturbance at time {spent[0]:.6g}: make it stronger or wider, "
                    "or take diffusivities for which a pattern exists.",
                    time=spent[0],
                )
            if relative_rate(system, moment.state) < still_below:
                still_below *= (
                    0.1  # a state at rest may be unstable: then run on until it moves ten times less
                )
                try:
                    state, residual, iterations = newton(system, moment.state)
                except NotConvergedError:
                    continue
                eigenvalues = rightmost_eigenvalues(
                    system, state, tolerated, partial(check_deadline, deadline, spent[0])
                )
                leading = complex(eigenvalues[0])
                if leading.real < tolerated:
                    return SteadyState(state, residual, eigenvalues, *spent, iterations)
            if spent[1] >= steps or still_below < STANDS:
                break
        time, taken = spent if moment else (time, taken)
        if still_below >= STANDS or not leading.real > 0:
            break
        start = _beside(system, state, leading)  # long steps damp what grows there: it would stand for ever
    raise NotConvergedError(
        f"no stable steady state was reached by time {time:.6g} {_reason(leading)}; run longer, start from "
        "another state, or expect a pattern that never rests.",
        time=time,
    )


def _beside(system: ReactionDiffusion, state: Array, leading: complex) -> Array:
    """Return a state beside an unstable steady one, along what grows there."""
    solve = system.solver(state, 1.1 * abs(leading))
    mode = 1 + np.cos(np.arange(state.size)).reshape(state.shape)  # the same in every run
    for _ in range(POWERS):
        mode = solve(system.times_mass(mode))
        mode /= np.abs(mode).max()
    size = np.maximum(np.ptp(state, axis=1), 0.1 * np.abs(state).max(axis=1))[:, None]
    push = PUSH * mode / (np.abs(mode) / size).max()
    if system.kinetics.non_negative:
        push *= min(1.0, 0.5 * float((state / np.maximum(np.abs(push), np.finfo(float).tiny)).min()))
    return np.asarray(state + push)


def check_deadline(deadline: float, time: float) -> None:
    """Raise NotConvergedError if `time.perf_counter` is past the deadline."""
    if perf_counter() > deadline:
        raise NotConvergedError(
            f"the time limit was reached while the pattern was sought, at {time:.4g}; allow more with "
            "Stepping(seconds=...) (--max-seconds), or use fewer elements.",
            time=time,
        )


def _reason(leading: complex) -> str:
    if not leading.real >= 0:
        return "(none was found)"
    if leading.imag == 0:
        return f"(the one found is left at the rate {leading.real:.3g})"
    period = 2 * math.pi / abs(leading.imag)
    return f"(the one found oscillates with a period of {period:.3g}, growing at the rate {leading.real:.3g})"


def continue_on_finer(
    system: ReactionDiffusion, coarse: SteadyState, state: Array, *, tolerated: float = 0.0,
    deadline: float = math.inf,
) -> SteadyState:  # fmt: skip
    """Polish a steady state of linear elements, interpolated to `state`, on quadratic ones, and certify it.

    The linear elements show that no unstable eigenvalue is missing. The rightmost real eigenvalue and, where
    one is near instability, the rightmost complex pair are computed anew on the quadratic elements.
    tolerated: rate up to which a perturbation may grow.  deadline: of `time.perf_counter`.
    Raises NotConvergedError if Newton's method fails or the steady state is unstable.
    """
    heed = partial(check_deadline, deadline, coarse.time)
    heed()
    state, residual, iterations = newton(system, state)
    found = [eigenvalue_right(system, state, heed)]
    pairs = coarse.eigenvalues[coarse.eigenvalues.imag > 0]
    if len(pairs):
        found.append(eigenvalue_near(system, state, complex(pairs[0]), heed))
    leading = max(found, key=lambda value: value.real)
    if leading.real >= tolerated:
        raise NotConvergedError(
            f"the steady state is unstable on the quadratic elements (leading eigenvalue {leading:.3g}) "
            "though stable on the linear ones; use smaller elements.",
            residual=residual,
        )
    eigenvalues = np.array(sorted(found, key=lambda value: -value.real))
    return replace(
        coarse, state=state, residual=residual, eigenvalues=eigenvalues, newton_iterations=iterations
    )
