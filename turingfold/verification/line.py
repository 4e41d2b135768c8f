"""Steady patterns on a line, against the boundary value problem that they solve."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_bvp

from ..arrays import Array
from ..turing.kinetics.base import Kinetics
from ..turing.kinetics.chemical import Brusselator, Schnakenberg
from ..turing.reaction_diffusion import ReactionDiffusion
from ..turing.stability import turing_unstable_at
from ..turing.steady import settle
from .check import Check, Quantity
from .turing import strip

WAVES = 2


def line_patterns() -> list[Quantity]:
    """D_u u'' + p(u, v) = 0, D_v v'' + q(u, v) = 0 on (0, 1), without flux, two half waves.

    A collocation method of order four (scipy's solve_bvp, residual 1e-10), independent of finite elements.
    96 quadratic elements along the line: to 1e-5 of the range of u.
    """
    found = []
    for kinetics in (Schnakenberg(a=0.1, b=0.9), Brusselator(A=2.0, B=3.0)):
        at = turing_unstable_at(kinetics, None).scaled_to((WAVES * np.pi) ** 2)
        space, line = strip(96)
        system = ReactionDiffusion(space, kinetics, at.d_u, at.d_v)
        begin = np.array(at.steady_state)[:, None] * (1 + 0.05 * np.cos(WAVES * np.pi * space.nodes[0]))
        u = settle(system, begin).state[:, line]
        x = space.nodes[0, line]
        known = _solved(kinetics, (at.d_u, at.d_v), x, u)
        off = float(np.abs(u[0] - known[0]).max() / np.ptp(known[0]))
        words = type(kinetics).__name__
        found += [
            Quantity(f"{words}: largest u", float(known[0].max()), float(u[0].max()), 1e-5),
            Quantity(f"{words}: smallest u", float(known[0].min()), float(u[0].min()), 1e-5),
            Quantity(f"{words}: largest error / range", 0.0, off, 1e-5),
        ]
    return found


def _solved(kinetics: Kinetics, diffusion: tuple[float, float], x: Array, guess: Array) -> Array:
    """Return u and v at x, (2, n), from the first-order system in u, u', v, v'."""

    def slope(_: Array, y: Array) -> Array:
        p, q = kinetics.rates(y[0], y[2])
        return np.stack([y[1], -p / diffusion[0], y[3], -q / diffusion[1]])

    def ends(left: Array, right: Array) -> Array:
        return np.array([left[1], right[1], left[3], right[3]])

    start = np.stack([guess[0], np.gradient(guess[0], x), guess[1], np.gradient(guess[1], x)])
    solution = solve_bvp(slope, ends, x, start, tol=1e-10, max_nodes=100_000)
    if not solution.success:
        raise RuntimeError(f"no reference: {solution.message}")
    return np.asarray(solution.sol(x)[[0, 2]])


CHECKS = (Check("Turing: patterns on a line", line_patterns, "collocation, scipy's solve_bvp"),)
