"""Adaptive backward differentiation of orders 1 to 5 on the coupled system, factors kept while they serve.

The numerical differentiation formulas in backward differences of Shampine, Reichelt (1997) SIAM J. Sci.
Comput. 18:1, with the mass matrix: each step solves M (d + ψ) = c F(w₀ + d), c = h / α_k, by Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...arrays import Array
from ...checks import positive
from ...errors import NotConvergedError
from ..linear.direct import Solver
from ..reaction_diffusion import ReactionDiffusion
from .rosenbrock import ErrorNorm, Positivity, Snapshot, reaction_time

HIGHEST = 5
_KAPPA = np.array([0.0, -0.1850, -1 / 9, -0.0823, -0.0415, 0.0])
_GAMMA = np.concatenate([[0.0], np.cumsum(1 / np.arange(1, HIGHEST + 1))])
_ALPHA = (1 - _KAPPA) * _GAMMA
_ERROR = _KAPPA * _GAMMA + 1 / np.arange(1, HIGHEST + 2)


def march_bdf(
    system: ReactionDiffusion,
    state: Array,
    *,
    until: float = math.inf,
    tolerance: float = 1e-4,
    floor: float | None = None,
    first: float | None = None,
) -> Iterator[Snapshot]:
    """Yield the accepted steps from `state` to the time `until`, the last one ending there exactly.

    tolerance, floor, first, steps that turn concentrations negative, and errors: as in `march`.
    """
    norm = ErrorNorm(positive("tolerance", tolerance, at_most=0.5), floor)
    state = system.check(state)
    smallest = 1e-12 * reaction_time(system, state)
    step = 1e10 * smallest * math.sqrt(tolerance) if first is None else positive("first", first)
    run = _Run(system, norm, state, min(step, until))
    while run.time < until:
        if run.time + run.step > until * (1 - 1e-12):
            run.rescale((until - run.time) / run.step)
            ends = True
        else:
            ends = False
        while not run.step_once():
            ends = False
            if run.step < smallest:
                raise NotConvergedError(
                    f"the step of the reaction-diffusion run fell to {run.step:.3g} at time {run.time:.6g}, "
                    "1e-12 of the reaction time: the kinetics blow up there; change parameters or start.",
                    time=run.time,
                )
        run.time = until if ends else run.time
        yield Snapshot(run.time, run.differences[0].copy(), run.steps, run.factorizations)
        run.adapt()


class _Run:
    """One run: backward differences (8, 2, n) of the present order and step, and the factors in use."""

    def __init__(self, system: ReactionDiffusion, norm: ErrorNorm, state: Array, step: float) -> None:
        self.system, self.norm, self.step = system, norm, step
        self.order, self.time, self.equal_steps, self.steps, self.factorizations = 1, 0.0, 0, 0, 0
        self.differences = np.zeros((HIGHEST + 3, *state.shape))
        solve = system.space.sparsity.scalar_solver(system.space.mass.data)
        self.differences[0] = state
        self.differences[1] = step * np.stack([solve(side) for side in system.rate(state)])
        self.factors: Solver | None = None
        self.positivity = Positivity(system.kinetics, norm.tolerance, reaction_time(system, state))

    def rescale(self, factor: float) -> None:
        """Change the step, and interpolate the differences to it."""
        part = self.differences[: self.order + 1]
        part[:] = np.tensordot(_change(self.order, factor).T, part, 1)
        self.step *= factor
        self.equal_steps = 0
        self.factors = None

    def step_once(self) -> bool:
        """Try one step; where it fails, shorten it or renew the factors, and return False."""
        k, differences = self.order, self.differences
        guess = differences[: k + 1].sum(axis=0)
        psi = np.tensordot(_GAMMA[1 : k + 1], differences[1 : k + 1], 1) / _ALPHA[k]
        c = self.step / _ALPHA[k]
        fresh = self.factors is None
        if self.factors is None:
            self.factors = self.system.solver(guess, 1 / c)
            self.factorizations += 1
        change, iterations = self._newton(self.factors, guess, psi, c)
        if change is None:
            if fresh:
                self.rescale(0.5)
            self.factors = None
            return False
        error = self.norm(_ERROR[k] * change, guess + change)
        if error > 1:
            self.rescale(max(0.2, 0.8 * error ** (-1 / (k + 1))))
            return False
        if self.positivity.refuses(differences[0], guess + change, self.step, self.time):
            self.rescale(0.5)
            return False
        self.time += self.step
        self.steps += 1
        self.equal_steps += 1
        differences[k + 2] = change - differences[k + 1]
        differences[k + 1] = change
        for i in range(k, -1, -1):
            differences[i] += differences[i + 1]
        if iterations > 2:
            self.factors = None
        return True

    def _newton(self, solve: Solver, guess: Array, psi: Array, c: float) -> tuple[Array | None, int]:
        # c F(w₀ + d) = M (ψ + d)
        change, last = np.zeros_like(guess), math.nan
        with np.errstate(over="ignore", invalid="ignore"):
            for iteration in range(1, 5):
                right = self.system.rate(guess + change) - self.system.times_mass(psi + change) / c
                if not np.isfinite(right).all():
                    return None, iteration
                update = solve(right)
                size = self.norm(update, guess)
                change = change + update
                ratio = size / last if iteration > 1 and last > 0 else 0.0
                if ratio >= 1 or not math.isfinite(size):
                    return None, iteration
                if size < 1e-3 or (iteration > 1 and size * ratio / (1 - ratio) < 0.03):
                    return change, iteration
                last = size
        return None, 4

    def adapt(self) -> None:
        """Choose order and step anew after as many equal steps as the order asks for."""
        k = self.order
        if self.equal_steps <= k:
            return
        present = self.differences[0]
        factors = {}
        for order, place in ((k - 1, k), (k, k + 1), (k + 1, k + 2)):
            if 1 <= order <= HIGHEST:
                error = max(self.norm(_ERROR[order] * self.differences[place], present), 1e-10)
                factors[order] = error ** (-1 / (order + 1))
        self.order = max(factors, key=lambda order: factors[order])
        self.rescale(min(10.0, 0.8 * factors[self.order]))


def _change(order: int, factor: float) -> Array:
    def table(ratio: float) -> Array:
        i, j = np.arange(1, order + 1)[:, None], np.arange(1, order + 1)
        matrix = np.ones((order + 1, order + 1))
        matrix[1:, 0] = 0.0
        matrix[1:, 1:] = (i - 1 - ratio * j) / i
        return np.asarray(np.cumprod(matrix, axis=0))

    return np.asarray(table(factor) @ table(1.0))
