"""Steady patterns: run until the pattern stands, then Newton's method and a certificate of stability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigs

from ..arrays import Array
from ..errors import NotConvergedError
from .integrators.rosenbrock import march
from .reaction_diffusion import ReactionDiffusion


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A steady state with its certificate.

    state: u and v at the nodes, shape (2, n_nodes).
    residual: largest entry of M f − D K w after Newton's method, relative to the sum of its parts' sizes.
    leading: eigenvalue of the linearised system with the largest real part found.
    time, steps: of the run that led there.  newton_iterations: to polish it.
    """

    state: Array
    residual: float
    leading: complex
    time: float
    steps: int
    newton_iterations: int

    @property
    def stable(self) -> bool:
        """Whether every perturbation found decays."""
        return self.leading.real < 0


def relative_residual(system: ReactionDiffusion, state: Array) -> float:
    """Return the largest |M f − D K w| of the nodes over the largest |M| |∂f/∂w| |w| + D |K| |w|."""
    space, size = system.space, np.abs(state)
    p_u, p_v, q_u, q_v = (np.abs(slope) for slope in system.kinetics.derivatives(*state))
    reaction = abs(space.mass) @ np.stack([p_u * size[0] + p_v * size[1], q_u * size[0] + q_v * size[1]]).T
    spread = abs(space.stiffness) @ np.stack([system.d_u * size[0], system.d_v * size[1]]).T
    largest = (reaction + spread).max(axis=0) + np.finfo(float).tiny
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


def leading_eigenvalue(
    system: ReactionDiffusion, state: Array, *, count: int = 4, near: float | None = None
) -> complex:
    """Return the eigenvalue with the largest real part among the `count` nearest to a point right of zero.

    Eigenvalues λ of J(w) z = λ M z; the point is 0.03 times the size of the reaction's own rates.
    """
    slopes = system.kinetics.derivatives(*state)
    point = 0.03 * float(max(np.abs(slopes[0]).max(), np.abs(slopes[3]).max())) if near is None else near
    solve = system.solver(state, point)
    n = 2 * system.space.size

    def apply(x: Array) -> Array:
        return solve(system.massed(x.reshape(2, -1))).ravel()

    inverse = LinearOperator((n, n), matvec=apply, dtype=float)
    start = 1 + np.cos(np.arange(n))
    # (point·M − J)⁻¹ M has the eigenvalues 1 / (point − λ)
    # a small basis, as few of its vectors are wanted: ARPACK's usual one takes a third more solves
    basis = min(max(3 * count, count + 2), n)
    values = eigs(inverse, count, which="LM", ncv=basis, v0=start, return_eigenvectors=False, tol=1e-6)
    found = point - 1 / values
    return complex(found[np.argmax(found.real)])


def speed(system: ReactionDiffusion, state: Array) -> float:
    """Return the largest rate of change over the pattern's height and the fastest reaction rate."""
    slopes = system.kinetics.derivatives(*state)
    fastest = max(float(np.abs(slope).max()) for slope in slopes)
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
    neutral: float = 0.0,
) -> SteadyState:
    """Run from a start until the pattern stands, polish it with Newton's method, and certify it.

    until, steps: longest time and largest number of steps to run.  neutral: rate up to which a perturbation
    may grow.
    tolerance: local error of the run, relative; the end point does not depend on it.
    Raises NotConvergedError if nothing stable is reached by then.
    """
    slow, leading, moment = 1e-3, complex(math.nan), None
    for moment in march(system, start, until=until, tolerance=tolerance):
        if speed(system, moment.state) < slow:
            slow *= 0.1  # what stands still may yet be unstable: then wait ten times longer
            try:
                state, residual, iterations = newton(system, moment.state)
            except NotConvergedError:
                continue
            leading = leading_eigenvalue(system, state)
            if leading.real < neutral:
                return SteadyState(state, residual, leading, moment.time, moment.steps, iterations)
        if moment.steps >= steps or slow < 1e-12:
            break
    time = moment.time if moment else 0.0
    raise NotConvergedError(
        f"no stable steady state was reached by time {time:.6g} (leading eigenvalue of the last one tried: "
        f"{leading:.3g}); run longer, start from another state, or expect a pattern that never rests.",
        time=time,
    )


def refine(
    system: ReactionDiffusion, coarse: SteadyState, state: Array, *, neutral: float = 0.0
) -> SteadyState:
    """Polish a coarser steady state, interpolated to `state`, on the finer system and certify it there.

    neutral: rate up to which a perturbation may grow.
    Raises NotConvergedError if Newton's method fails or the steady state is unstable.
    """
    state, residual, iterations = newton(system, state)
    leading = leading_eigenvalue(system, state)
    if leading.real >= neutral:
        raise NotConvergedError(
            f"the steady state is unstable on the quadratic elements (leading eigenvalue {leading:.3g}) "
            "though stable on the linear ones; use smaller elements.",
            residual=residual,
        )
    return SteadyState(state, residual, leading, coarse.time, coarse.steps, iterations)
