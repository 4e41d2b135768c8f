"""Newton's direction by conjugate gradients, where the true tangent may not be positive definite.

A tangent K̃ to which convexity was added is positive definite, but its steps K̃⁻¹ f are short where the true K
is soft or negative: walls that slide on each other press on corners, and of some ten thousand unknowns one or
two can go down there. With K̃ as preconditioner few iterations solve K d = f; where a conjugate direction of
negative curvature comes up, the step ends along it (Steihaug 1983), as far as if the curvature were positive.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .problem import Configuration, configuration

FORCING = 0.1  # reduction of the residual at most, √(relative residual) near the equilibrium
MOST = 30  # iterations
DOUBLINGS = 8  # of a step along which the energy curves down
FLAT, STEEP = 1e-3, 0.1  # curvatures in units of the preconditioner's: negative below, and taken as at least


class Descent(NamedTuple):
    """A direction, how many iterations it took, and whether it goes down where the energy curves down."""

    direction: Array
    iterations: int
    curved: bool


def descent(
    solve: Callable[[Array], Array], times: Callable[[Array], Array], force: Array, residual: float
) -> Descent:
    """Return the direction d, K d = force, or down a direction of negative curvature.

    solve: product with the inverse of a positive definite matrix near K.  times: product with K.
    residual: relative size of the force.
    """
    found, left = np.zeros_like(force), force
    towards = solve(left)
    way, stiff = towards, left  # and the product of the preconditioner's matrix with it
    size = first = float(left @ towards)
    goal = min(FORCING, np.sqrt(residual)) ** 2 * first
    for count in range(1, MOST + 1):
        pull = times(way)
        curvature, usual = float(way @ pull), float(way @ stiff)
        if curvature <= FLAT * usual:
            found = found + size / max(abs(curvature), STEEP * usual) * way
            return Descent(found, count, True)
        step = size / curvature
        found, left = found + step * way, left - step * pull
        towards = solve(left)
        before, size = size, float(left @ towards)
        if size <= goal:
            break
        way, stiff = towards + size / before * way, left + size / before * stiff
    return Descent(found, count, False)


def lengthened(at: Configuration, there: Configuration) -> Configuration:
    """Return the end of the step, doubled as long as that is admissible and lowers the energy.

    Where the energy curves down, nothing says how far.
    """
    for _ in range(DOUBLINGS):
        onward = 2.0 * (there.x - at.x)
        if at.largest_step(onward) < 1.0:
            break
        farther = configuration(at.potentials, at.x + onward)
        if farther is None or farther.energy >= there.energy:
            break
        there = farther
    return there
