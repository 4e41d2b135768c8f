"""Branches of steady patterns as the diffusion ratio changes, by pseudo-arclength continuation.

Solves M f(w) = D(d) K w with d = d_inhibitor / d_activator as an unknown, the activator's diffusivity kept,
from the point where a mode of the uniform state neither grows nor decays. Method: Keller (1977).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..checks import positive
from ..errors import NotConvergedError
from .eigenvalues import rightmost_eigenvalues
from .modes import Mode
from .reaction_diffusion import ReactionDiffusion
from .stability import Conditions
from .steady import relative_residual


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """A steady pattern on a branch.

    ratio: d_inhibitor / d_activator.  state: (2, n_nodes).
    amplitude: root mean square of the activator about its mean.
    leading: eigenvalue with the largest real part found.  fold: whether the ratio turned back just before.
    """

    ratio: float
    state: Array
    amplitude: float
    leading: complex
    fold: bool

    @property
    def stable(self) -> bool:
        """Whether every perturbation found decays."""
        return self.leading.real < 0


def neutral_ratio(found: Conditions, k2: float) -> float:
    """Return the ratio d at which a mode neither grows nor decays: det(J − k² D_a diag(1, d)) = 0.

    The activator's diffusivity is that of the conditions. Raises ValueError if the mode decays at every
    ratio.
    """
    a = ("u", "v").index(found.activator)
    D_a = found.d_u if a == 0 else found.d_v
    J, i = found.jacobian, 1 - a
    grows = J[a, a] - k2 * D_a
    if grows <= 0:
        raise ValueError(
            f"k2={k2:g} must be below J_aa / D_a = {J[a, a] / D_a:g}: a shorter wave decays at every ratio."
        )
    return float((grows * J[i, i] - J[a, i] * J[i, a]) / (k2 * D_a * grows))


@dataclass(frozen=True, eq=False)
class _Direction:
    """Tangent of a branch: state and ratio parts."""

    state: Array
    ratio: float


def steady_branch(
    system: ReactionDiffusion,
    found: Conditions,
    mode: Mode,
    *,
    amplitude: float = 0.02,
    step: float = 0.05,
    points: int = 40,
    upward: bool = True,
) -> Iterator[BranchPoint]:
    """Yield points of the branch that leaves the uniform state at a mode's neutral ratio.

    system: with the activator diffusivity to keep.  found: conditions of its kinetics and diffusivities.
    amplitude: of the first point, relative to the steady activator (absolute where that is 0).
    step: first arc length, in relative change of the ratio and of the state; adapted to Newton's iterations.
    upward: start towards a peak of the activator where the mode is positive.
    Raises NotConvergedError if the step has to become 1e-6 of the first one.
    """
    positive("amplitude", amplitude, at_most=1.0)
    branch = _Branch(system, found, neutral_ratio(found, mode.value))
    sign = 1.0 if upward else -1.0
    towards = sign * np.outer(found.fastest_direction, mode.shape)
    towards /= math.sqrt(branch.product(towards, towards))
    direction = _Direction(towards, 0.0)
    uniform = system.uniform(*found.steady_state)
    state, ratio = uniform + amplitude * towards, branch.start
    state, ratio, _ = branch.correct(state, ratio, direction)
    length, smallest = positive("step", step), 1e-6 * step
    for _ in range(points):
        onward = branch.tangent(state, ratio, direction)
        fold, direction = onward.ratio * direction.ratio < 0, onward
        leading = complex(rightmost_eigenvalues(branch.at(ratio), state)[0])
        yield BranchPoint(ratio, state, branch.amplitude(state), leading, fold)
        while True:
            try:
                new = branch.correct(
                    state + length * direction.state,
                    ratio + length * branch.start * direction.ratio,
                    direction,
                )
                break
            except NotConvergedError as error:
                length *= 0.5
                if length < smallest:
                    raise NotConvergedError(
                        f"the branch could not be followed beyond ratio {ratio:.6g}: {error}",
                        residual=error.residual,
                    ) from error
        state, ratio = new[0], new[1]
        length *= 1.4 if new[2] <= 3 else 1.0


class _Branch:
    """The extended system; products of states are means over the area, relative to the steady activator."""

    def __init__(self, system: ReactionDiffusion, found: Conditions, start: float) -> None:
        self.system, self.start = system, start
        self.activator = ("u", "v").index(found.activator)
        self.size = abs(found.steady_state[self.activator]) or 1.0

    def at(self, ratio: float) -> ReactionDiffusion:
        """Return the system with this ratio."""
        if self.activator == 0:
            return replace(self.system, d_v=ratio * self.system.d_u)
        return replace(self.system, d_u=ratio * self.system.d_v)

    def product(self, one: Array, other: Array) -> float:
        """Return the mean over the area of one·other, relative to the steady activator squared."""
        space = self.system.space
        return float(np.sum(one * self.system.times_mass(other)) / (space.area * self.size**2))

    def amplitude(self, state: Array) -> float:
        """Return the root mean square of the activator about its mean."""
        space, activator = self.system.space, state[self.activator]
        away = activator - space.mean(activator)
        return math.sqrt(float(away @ (space.mass @ away)) / space.area)

    def by_ratio(self, state: Array) -> Array:
        """Return ∂rate/∂d for the relative ratio d / start."""
        d_a = self.system.d_u if self.activator == 0 else self.system.d_v
        derivative = np.zeros_like(state)
        inhibitor = 1 - self.activator
        derivative[inhibitor] = -self.start * d_a * (self.system.space.stiffness @ state[inhibitor])
        return derivative

    def tangent(self, state: Array, ratio: float, before: _Direction) -> _Direction:
        """Return the unit tangent at a solution, on the side of the one before."""
        along = self.at(ratio).solver(state)(self.by_ratio(state))
        size = math.sqrt(self.product(along, along) + 1.0)
        if self.product(along, before.state) + before.ratio < 0:
            size = -size
        return _Direction(along / size, 1.0 / size)

    def correct(self, state: Array, ratio: float, direction: _Direction) -> tuple[Array, float, int]:
        """Return state, ratio and iterations of Newton's method in the plane across the direction."""
        guess, begin = state, ratio
        for iteration in range(1, 9):
            if ratio <= 0 or not np.isfinite(state).all():
                break
            at = self.at(ratio)
            solve = at.solver(state)
            change, along = solve(at.rate(state)), solve(self.by_ratio(state))
            moved = (ratio - begin) / self.start
            off = self.product(direction.state, state - guess + change) + direction.ratio * moved
            relative = -off / (self.product(direction.state, along) + direction.ratio)
            state, ratio = state + change + relative * along, ratio + self.start * relative
            if ratio > 0 and relative_residual(self.at(ratio), state) < 1e-11:
                return state, ratio, iteration
        raise NotConvergedError(
            "Newton's method on a branch did not converge in 8 iterations; use a smaller step."
        )
