"""IMEX integration with a fixed step: diffusion implicit, reaction explicit, one factorisation per species.

Multistep, with f_k = f(w_k):
(a₀M + c₀ dt DK) w_{n+1} = Σ_j a_j M w_{n+1−j} + dt Σ_j (b_j M f_{n+1−j} − c_j DK w_{n+1−j}), j = 1, 2, ...
Ascher, Ruuth, Wetton (1995) SIAM J. Numer. Anal. 32:797.
Runge-Kutta, stage i of a stiffly accurate pair, the last being the end of the step:
(M + dt A_ii DK) W_i = M w_n + dt Σ_{j<i} (Â_ij M f(W_j) − A_ij DK W_j).
Ascher, Ruuth, Spiteri (1997) Appl. Numer. Math. 25:151.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import Array
from ...checks import positive
from ...errors import InadmissibleStateError
from ..linear.direct import Solver
from ..reaction_diffusion import ReactionDiffusion
from .rosenbrock import Snapshot


@dataclass(frozen=True, eq=False)
class Multistep:
    """Coefficients from the newest level back: a and c from w_{n+1}, b from f_n."""

    name: str
    order: int
    a: tuple[float, ...]
    b: tuple[float, ...]
    c: tuple[float, ...]

    def amplification(self, z: float) -> float:
        """Return the largest root for w' = λw treated explicitly, z = λ dt."""
        count = len(self.b)
        a = np.zeros(count)
        a[: len(self.a) - 1] = self.a[1:]
        return float(np.abs(np.roots([self.a[0], *(-a - z * np.array(self.b))])).max())

    @cached_property
    def reaction_limit(self) -> float:
        """Largest dt |λ| at which decaying reactions decay in the scheme."""
        return _limit(self)


@dataclass(frozen=True, eq=False)
class RungeKutta:
    """Implicit and explicit tableaux, both stiffly accurate; one diagonal value after the first stage."""

    name: str
    order: int
    implicit: Array
    explicit: Array

    def amplification(self, z: float) -> float:
        """Return |R(z)| for w' = λw treated explicitly, z = λ dt."""
        stages = np.ones(len(self.explicit))
        for i in range(1, len(stages)):
            stages[i] = 1 + z * self.explicit[i, :i] @ stages[:i]
        return float(abs(stages[-1]))

    @cached_property
    def reaction_limit(self) -> float:
        """Largest dt |λ| at which decaying reactions decay in the scheme."""
        return _limit(self)


def _limit(scheme: Multistep | RungeKutta) -> float:
    # first point of the negative real axis at which the amplification passes 1
    z = np.linspace(0.0, 4.0, 4001)[1:]
    growing = np.array([scheme.amplification(-x) for x in z]) > 1 + 1e-12
    return float(z[np.argmax(growing)])


def _square(rows: list[list[float]]) -> Array:
    matrix = np.zeros((len(rows), len(rows)))
    for i, row in enumerate(rows):
        matrix[i, : len(row)] = row
    return matrix


_G = 1 - 1 / math.sqrt(2)
_D = 1 - 1 / (2 * _G)

SBDF1 = Multistep("SBDF1", 1, (1, 1), (1,), (1,))
SBDF2 = Multistep("SBDF2", 2, (3 / 2, 2, -1 / 2), (2, -1), (1,))
SBDF3 = Multistep("SBDF3", 3, (11 / 6, 3, -3 / 2, 1 / 3), (3, -3, 1), (1,))
CNAB2 = Multistep("CNAB2", 2, (1, 1), (3 / 2, -1 / 2), (1 / 2, 1 / 2))
MCNAB2 = Multistep("MCNAB2", 2, (1, 1), (3 / 2, -1 / 2), (9 / 16, 3 / 8, 1 / 16))
ARS222 = RungeKutta(
    "ARS222", 2, _square([[0], [0, _G], [0, 1 - _G, _G]]), _square([[0], [_G], [_D, 1 - _D, 0]])
)
ARS443 = RungeKutta(
    "ARS443",
    3,
    _square(
        [[0], [0, 1 / 2], [0, 1 / 6, 1 / 2], [0, -1 / 2, 1 / 2, 1 / 2], [0, 3 / 2, -3 / 2, 1 / 2, 1 / 2]]
    ),
    _square([[0], [1 / 2], [11 / 18, 1 / 18], [5 / 6, -5 / 6, 1 / 2], [1 / 4, 7 / 4, 3 / 4, -7 / 4, 0]]),
)
CHECKED = 10  # steps from one look at the reaction's eigenvalues to the next, each the cost of an evaluation
RISE = 1.05  # of the largest value, after which they are looked at before that
SCHEMES = {scheme.name: scheme for scheme in (SBDF1, SBDF2, SBDF3, CNAB2, MCNAB2, ARS222, ARS443)}


def fastest_reaction(system: ReactionDiffusion, state: Array) -> float:
    """Return the largest modulus of an eigenvalue of ∂(p, q)/∂(u, v) at the nodes."""
    p_u, p_v, q_u, q_v = system.kinetics.derivatives(*state)
    half_trace, det = 0.5 * (p_u + q_v), p_u * q_v - p_v * q_u
    root = np.sqrt((half_trace**2 - det).astype(complex))
    return float(np.maximum(np.abs(half_trace + root), np.abs(half_trace - root)).max())


def march_imex(
    system: ReactionDiffusion,
    state: Array,
    *,
    until: float,
    step: float,
    scheme: Multistep | RungeKutta = SBDF2,
) -> Iterator[Snapshot]:
    """Yield every step from `state` to `until`; `step` is made a little smaller to divide it evenly.

    The reaction's eigenvalues are looked at every CHECKED steps, and where the state rises. Raises ValueError
    if the step is beyond the scheme's limit at the start, and InadmissibleStateError, with the time and the
    step that would do, if the reaction becomes too fast for it or the state stops being finite later.
    """
    state = system.check(state)
    count = math.ceil(positive("until", until) / positive("step", step) * (1 - 1e-12))
    dt = until / count
    if refusal := _beyond_limit(scheme, dt, fastest_reaction(system, state)):
        raise ValueError(refusal)
    if isinstance(scheme, Multistep):
        states = _multistep(system, state, dt, count, scheme)
    else:
        states = _runge_kutta(system, state, dt, count, scheme)
    factorizations = 2 if isinstance(scheme, RungeKutta) or len(scheme.b) == 1 else 4
    seen = np.abs(state).max()
    with np.errstate(over="ignore", invalid="ignore"):
        for n, new in enumerate(states, start=1):
            largest = np.abs(new).max()
            if not np.isfinite(largest):
                raise InadmissibleStateError(
                    f"{scheme.name} with step {dt:.4g} left the finite numbers at time {n * dt:.6g}: the "
                    "reaction has become faster than the step resolves; use a smaller step or an adaptive "
                    "method.",
                    time=n * dt,
                )
            if n % CHECKED == 0 or largest > RISE * seen:
                seen = largest
                if refusal := _beyond_limit(scheme, dt, fastest_reaction(system, new)):
                    raise InadmissibleStateError(f"at time {n * dt:.6g} {refusal}", time=n * dt)
            yield Snapshot(n * dt, new, n, factorizations)


def _beyond_limit(scheme: Multistep | RungeKutta, dt: float, fastest: float) -> str:
    if dt * fastest > scheme.reaction_limit:
        return (
            f"step={dt:.4g} must be at most {scheme.reaction_limit / fastest:.4g}: {scheme.name} treats the "
            f"reaction explicitly, whose largest eigenvalue is {fastest:.4g}, and holds up to a product of "
            f"{scheme.reaction_limit:.4g}; use a smaller step or an adaptive method."
        )
    return ""


def _implicit_solvers(system: ReactionDiffusion, mass: float, dt: float) -> tuple[Solver, Solver]:
    m, k = system.space.mass.data, system.space.stiffness.data
    pattern = system.space.sparsity
    u, v = (pattern.scalar_solver(mass * m + dt * d * k) for d in (system.d_u, system.d_v))
    return u, v


def _reaction(system: ReactionDiffusion, state: Array) -> Array:
    return np.stack(system.kinetics.rates(*state))


def _multistep(
    system: ReactionDiffusion, state: Array, dt: float, count: int, scheme: Multistep
) -> Iterator[Array]:
    levels = max(len(scheme.a), len(scheme.c), len(scheme.b) + 1) - 1
    states = [state]  # newest first
    for new in _runge_kutta(system, state, dt, min(levels - 1, count), ARS443):
        states.insert(0, new)
        yield new
    reactions = [_reaction(system, old) for old in states]
    solvers = _implicit_solvers(system, scheme.a[0], scheme.c[0] * dt)
    for _ in range(count - levels + 1):
        right = system.times_mass(_weighted(scheme.a[1:], states) + dt * _weighted(scheme.b, reactions))
        if len(scheme.c) > 1:
            right = right - dt * system.diffusion(_weighted(scheme.c[1:], states))
        new = np.stack([solve(side) for solve, side in zip(solvers, right, strict=True)])
        states = [new, *states[: levels - 1]]
        reactions = [_reaction(system, new), *reactions[: levels - 1]]
        yield new


def _weighted(weights: tuple[float, ...], values: list[Array]) -> Array:
    return np.asarray(sum(w * value for w, value in zip(weights, values, strict=False)))


def _runge_kutta(
    system: ReactionDiffusion, state: Array, dt: float, count: int, scheme: RungeKutta
) -> Iterator[Array]:
    if count < 1:
        return
    diagonal = scheme.implicit[-1, -1]
    solvers = _implicit_solvers(system, 1.0, diagonal * dt)
    for _ in range(count):
        reactions, diffusions = [_reaction(system, state)], [system.diffusion(state)]
        start = system.times_mass(state)
        for i in range(1, len(scheme.explicit)):
            gain = np.tensordot(scheme.explicit[i, :i], np.array(reactions), 1)
            loss = np.tensordot(scheme.implicit[i, :i], np.array(diffusions), 1)
            right = start + dt * (system.times_mass(gain) - loss)
            stage = np.stack([solve(side) for solve, side in zip(solvers, right, strict=True)])
            reactions.append(_reaction(system, stage))
            diffusions.append(system.diffusion(stage))
        state = stage
        yield state
