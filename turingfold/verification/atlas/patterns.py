"""Patterns of the atlas: steady ones and runs in time, against residuals, modes and runs of scipy's."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import block_array, diags_array
from scipy.sparse.linalg import eigs, splu
from skfem import Basis, ElementTriP2, asm
from skfem.models.poisson import laplace, mass

from ...arrays import Array
from ...errors import NotConvergedError
from ...geometry.body import Body
from ...geometry.shapes import semicircle
from ...turing.integrators.rosenbrock import march
from ...turing.kinetics.base import Kinetics
from ...turing.kinetics.named import kinetics_named
from ...turing.pattern import Pattern
from ...turing.process import Turing
from ...turing.reaction_diffusion import ReactionDiffusion
from ...turing.stability import Conditions, turing_unstable_at
from ..turing import last, strip

UNBALANCED = 1e-8  # relative residual of what is no steady state; the solver stops at 1e-12
GROWING = 1e-3  # of the fastest rate: a perturbation that grows so fast makes a pattern unstable
FAR = 100.0  # times the tolerance of one step: how far the end of a run may be off


def steady(cell: Mapping[str, Any], seconds: float) -> tuple[list[str], dict[str, float]]:
    """Return what is wrong with the steady pattern of a cell, and what it took."""
    kinetics = kinetics_named(cell["kinetics"])
    body = semicircle(radius=1.0, thickness=cell["thickness"], elements=cell["elements"], base=cell["base"])
    waves = cell["half_waves"]
    ratio = _beyond(kinetics, cell["beyond"]).ratio
    turing = Turing(kinetics, half_waves=waves, ratio=ratio, initial=cell["initial"])
    pattern = turing.pattern(body, 0, deadline=perf_counter() + seconds)
    effort = {"steps": float(pattern.steady.steps), "iterations": float(pattern.steady.newton_iterations)}
    return faults(body, pattern, waves if cell["initial"] == "mode" else None), effort


def faults(body: Body, pattern: Pattern, waves: int | None) -> list[str]:
    """Return what is wrong with a steady pattern that should have so many half waves, if that is known."""
    state, found, kinetics = pattern.steady.state, [], pattern.system.kinetics
    at = pattern.design.conditions
    if not np.isfinite(state).all():
        return ["not finite"]
    if kinetics.non_negative and state.min() < 0:
        found.append(f"concentration {state.min():.2g}")
    line = state[0 if at.activator == "u" else 1, pattern.design.line]
    count = int(np.count_nonzero(np.diff(np.sign(line - 0.5 * (line.max() + line.min())))))
    if waves is not None and count != waves:
        found.append(f"{count} half waves")
    M, K = _matrices(body)
    p, q = kinetics.rates(*state)
    rest, size = [], []
    for rate, d, w in ((p, at.d_u, state[0]), (q, at.d_v, state[1])):
        rest.append(M @ rate - d * (K @ w))
        size.append(np.abs(M @ rate).max() + d * np.abs(K @ w).max())
    left = max(float(np.abs(r).max() / s) for r, s in zip(rest, size, strict=True))
    if left > UNBALANCED:
        found.append(f"residual {left:.2g}")
    growth = _fastest(kinetics, state, (at.d_u, at.d_v), (M, K), at.fastest_rate)
    if growth > GROWING * at.fastest_rate and not _drifts(pattern):
        found.append(f"a perturbation grows at {growth:.2g}")
    return found


def _matrices(body: Body) -> tuple[Any, Any]:
    """Return mass and stiffness matrix of the cortical band."""
    basis = Basis(body.cortex.mesh, ElementTriP2(), intorder=6)
    return asm(mass, basis), asm(laplace, basis)


def _drifts(pattern: Pattern) -> bool:
    return bool(pattern.design.line[0] == pattern.design.line[-1])


def _fastest(
    kinetics: Kinetics, state: Array, diffusion: tuple[float, float], matrices: tuple[Any, Any], rate: float
) -> float:
    """Return the largest real part of the eigenvalues of the linearised system near two growing rates."""
    M, K = matrices
    a, b, c, d = (M @ diags_array(np.broadcast_to(x, state[0].shape)) for x in _differences(kinetics, state))
    jacobian = block_array([[a - diffusion[0] * K, b], [c, d - diffusion[1] * K]]).tocsc()
    whole = block_array([[M, None], [None, M]]).tocsc()
    largest = -np.inf
    for shift in (rate, 0.3 * rate + 1j * rate):
        found = eigs(jacobian, k=6, M=whole, sigma=shift, return_eigenvectors=False, tol=1e-8)
        largest = max(largest, float(found.real.max()))
    return largest


def _differences(kinetics: Kinetics, state: Array) -> list[Array]:
    """Return ∂p/∂u, ∂p/∂v, ∂q/∂u and ∂q/∂v by differences."""
    u, v = state
    h, k = (1e-6 * max(float(np.abs(w).max()), 1e-3) for w in (u, v))
    after, before = kinetics.rates(u + h, v), kinetics.rates(u - h, v)
    above, below = kinetics.rates(u, v + k), kinetics.rates(u, v - k)
    found = [[(after[i] - before[i]) / (2 * h), (above[i] - below[i]) / (2 * k)] for i in (0, 1)]
    return [*found[0], *found[1]]


def marched(cell: Mapping[str, Any], seconds: float) -> tuple[list[str], dict[str, float]]:
    """Return what is wrong with a run in time from a small wave, against scipy's BDF at 1e-9, and its effort.

    stiffness: the square of a factor of both diffusivities, by which waves decay faster than the kinetics.
    """
    kinetics = kinetics_named(cell["kinetics"])
    found = _beyond(kinetics, cell["beyond"])
    space, _ = strip(24)
    scale = found.fastest_k2 / (np.pi * cell["half_waves"]) ** 2 * cell["stiffness"] ** 0.5
    system = ReactionDiffusion(space, kinetics, found.d_u * scale, found.d_v * scale)
    level = np.array(found.steady_state)
    wave = np.cos(cell["half_waves"] * np.pi * space.nodes[0])
    begin = level[:, None] + 0.02 * np.maximum(np.abs(level), 0.1)[:, None] * wave
    until = 3.0 / found.fastest_rate
    steps = list(march(system, begin, until=until, tolerance=cell["tolerance"]))
    end, n = last(steps).state, space.size
    M, K = space.mass, space.stiffness
    factor = splu(M.tocsc())

    limit = perf_counter() + 3 * seconds

    def slope(time: float, w: Array) -> Array:
        if perf_counter() > limit:
            raise NotConvergedError("scipy's run, not ours, takes too long", time=time)
        p, q = kinetics.rates(w[:n], w[n:])
        return np.concatenate([
            p - system.d_u * factor.solve(K @ w[:n]), q - system.d_v * factor.solve(K @ w[n:])
        ])  # fmt: skip

    known = solve_ivp(slope, (0, until), begin.ravel(), method="BDF", rtol=1e-9, atol=1e-11).y[:, -1]
    size = max(float(np.abs(known).max()), float(np.abs(begin).max()))  # one that dies out ends at round-off
    off = float(np.abs(end.ravel() - known).max() / size)
    faults = [] if np.isfinite(end).all() else ["not finite"]
    if not off <= FAR * cell["tolerance"]:
        faults.append(f"off by {off:.2g} at a tolerance of {cell['tolerance']:.2g}")
    return faults, {"steps": float(len(steps)), "iterations": float("nan")}


def _beyond(kinetics: Kinetics, share: float) -> Conditions:
    """Return the conditions at a ratio that lies by a share beyond the critical one."""
    return turing_unstable_at(kinetics, (1 + share) * turing_unstable_at(kinetics, None).critical_ratio)
