"""Adaptive linearly implicit (Rosenbrock) integration of the coupled system: one factorisation a step.

Stage i of a step h from w solves (M/(hγ) − J) U_i = F(w + Σ a_ij U_j) + M Σ c_ij U_j / h, and the step ends
at w + Σ m_i U_i. Theory: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), chapter IV.7.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import Array
from ...checks import positive
from ...errors import NotConvergedError
from ..kinetics.base import Kinetics
from ..reaction_diffusion import ReactionDiffusion


@dataclass(frozen=True, eq=False)
class Tableau:
    """Coefficients: γ, a and c strictly lower, the end m, and `error`, m minus the embedded end."""

    order: int
    gamma: float
    a: Array
    c: Array
    m: Array
    error: Array


def _lower(rows: tuple[tuple[float, ...], ...]) -> Array:
    matrix = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows, start=1):
        matrix[i, : len(row)] = row
    return matrix


def _from_classical(
    order: int, gamma: float, alpha: Array, below: Array, weights: Array, embedded: Array
) -> Tableau:
    # Γ = γI + below: a = αΓ⁻¹, c = I/γ − Γ⁻¹, m = bΓ⁻¹
    inverse = np.linalg.inv(gamma * np.eye(len(below)) + below)
    c = np.tril(-inverse, -1)
    return Tableau(order, gamma, alpha @ inverse, c, weights @ inverse, (weights - embedded) @ inverse)


# Rang, Angermann (2005) BIT 45:761: order 3, four stages, keeps its order with an inexact Jacobian
ROS34PW2 = _from_classical(
    order=3,
    gamma=4.3586652150845900e-01,
    alpha=_lower(
        ((8.7173304301691801e-01,), (8.4457060015369423e-01, -1.1299064236484185e-01), (0.0, 0.0, 1.0))
    ),
    below=_lower(
        (
            (-8.7173304301691801e-01,),
            (-9.0338057013044082e-01, 5.4180672388095326e-02),
            (2.4212380706095346e-01, -1.2232505839045147, 5.4526025533510214e-01),
        )
    ),
    weights=np.array(
        [2.4212380706095346e-01, -1.2232505839045147, 1.5452602553351020, 4.3586652150845900e-01]
    ),
    embedded=np.array([3.7810903145819369e-01, -9.6042292212423178e-02, 0.5, 2.1793326075422950e-01]),
)

_A5 = (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950)
# Hairer, Wanner (1996), RODAS: order 4, six stages; the last stage is the error estimate
RODAS4 = Tableau(
    order=4,
    gamma=0.25,
    a=_lower(
        (
            (1.544000000000000,),
            (0.9466785280815826, 0.2557011698983284),
            (3.314825187068521, 2.896124015972201, 0.9986419139977817),
            _A5,
            (*_A5, 1.0),
        )
    ),
    c=_lower(
        (
            (-5.668800000000000,),
            (-2.430093356833875, -0.2063599157091915),
            (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
            (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
            (
                8.083246795921522,
                -7.981132988064893,
                -31.52159432874371,
                16.31930543123136,
                -6.058818238834054,
            ),
        )
    ),
    m=np.array([*_A5, 1.0, 1.0]),
    error=np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
)


@dataclass(frozen=True, eq=False)
class Snapshot:
    """An accepted step: time, state (2, n_nodes), and the counts of steps and factorisations so far."""

    time: float
    state: Array
    steps: int
    factorizations: int


@dataclass(frozen=True)
class ErrorNorm:
    """Root mean square of an error over tolerance·|w| + floor, per species and node; 1 is just acceptable.

    floor: by default tolerance times the largest value of each species.
    """

    tolerance: float
    floor: float | None = None

    def __call__(self, error: Array, state: Array) -> float:
        """Return the norm of an error at a state."""
        size = np.abs(state)
        least = self.tolerance * size.max(axis=1, keepdims=True) if self.floor is None else self.floor
        return float(np.sqrt(np.mean((error / (self.tolerance * size + least + 1e-300)) ** 2)))


class Positivity:
    """Refuses steps across 0: rates of concentrations may have poles below it.

    Beyond a pole a state means nothing, and steps may become tiny for ever. Small negative values beside a
    front, from elements too large for it, come and go, and are let pass.
    """

    SHORT, PATIENCE = 1e-3, 200  # steps this many reaction times long are tiny; so many are the limit

    def __init__(self, kinetics: Kinetics, tolerance: float, fastest: float) -> None:
        """Keep the relative tolerance and the reaction time `fastest`."""
        self.active, self.tolerance, self.fastest = kinetics.non_negative, tolerance, fastest
        self.tiny = 0

    def refuses(self, before: Array, after: Array, step: float, time: float) -> bool:
        """Return whether a step has to be shortened; raise NotConvergedError where tiny ones do not end."""
        if not self.active or after.min() >= 0:
            return False
        allowed = self.tolerance * np.abs(before).max(axis=1, keepdims=True)
        if step > self.SHORT * self.fastest:
            across = np.where(before > 0, after < -allowed, (before > -allowed) & (after < -5 * allowed))
            return bool(across.any())
        self.tiny += int((after < -allowed).any())
        if self.tiny > self.PATIENCE:
            raise NotConvergedError(
                f"concentrations are negative at time {time:.6g}, down to {after.min():.3g}, where kinetics "
                f"have no meaning, and steps fell to {step:.3g}; use a smaller tolerance or smaller "
                "elements.",
                time=time,
            )
        return False


def reaction_time(system: ReactionDiffusion, state: Array) -> float:
    """Return one over the largest derivative of the rates at a state."""
    return 1 / max(float(np.abs(values).max()) for values in system.kinetics.derivatives(*state))


def march(
    system: ReactionDiffusion,
    state: Array,
    *,
    until: float = math.inf,
    tolerance: float = 1e-4,
    floor: float | None = None,
    first: float | None = None,
    tableau: Tableau = RODAS4,
    during: Callable[[float, float], ReactionDiffusion] | None = None,
) -> Iterator[Snapshot]:
    """Yield the accepted steps from `state` to the time `until`, the last one ending there exactly.

    tolerance: local error relative to the state.  floor: absolute part of it; default tolerance times the
    largest value of each species.  first: first step; default a tenth of the fastest reaction time.
    during: where the system changes in time, the system that stands for the interval (time, time + step).
    Steps that take concentrations across 0 are halved, as `Positivity` says.
    Raises NotConvergedError when the step falls below 1e-12 of the reaction time, or becomes tiny for good
    where concentrations are negative.
    """
    norm = ErrorNorm(positive("tolerance", tolerance, at_most=0.5), floor)
    state = system.check(state)
    fastest = reaction_time(system, state)
    positivity = Positivity(system.kinetics, tolerance, fastest)
    step = 0.1 * fastest if first is None else positive("first", first)
    time, steps, factorizations, growth = 0.0, 0, 0, 5.0
    while time < until:
        last = time + step >= until * (1 - 1e-12)
        step = until - time if last else step
        candidate, error = rosenbrock_step(
            system if during is None else during(time, step), state, step, tableau, norm
        )
        factorizations += 1
        factor = 0.9 * max(error, 1e-8) ** (-1 / tableau.order) if math.isfinite(error) else 0.1
        if error <= 1.0 and positivity.refuses(state, candidate, step, time):
            step, growth = 0.5 * step, 1.0
        elif error <= 1.0:
            time, state, steps = until if last else time + step, candidate, steps + 1
            yield Snapshot(time, state, steps, factorizations)
            step, growth = step * min(growth, max(0.2, factor)), 5.0
        else:
            step, growth = step * max(0.1, min(0.9, factor)), 1.0
        if step < 1e-12 * fastest:
            raise NotConvergedError(
                f"the step of the reaction-diffusion run fell to {step:.3g} at time {time:.6g}, 1e-12 of the "
                f"reaction time {fastest:.3g}: the kinetics blow up there; change parameters or start.",
                time=time,
            )


def rosenbrock_step(
    system: ReactionDiffusion, state: Array, step: float, tableau: Tableau, norm: ErrorNorm
) -> tuple[Array, float]:
    """Return the state after one step and its error in the norm; infinite if the state is not finite."""
    a, c = tableau.a, tableau.c
    solve = system.quick_solver(state, 1 / (step * tableau.gamma), 0.1 * norm.tolerance)
    stages: list[Array] = []
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # a step too long is refused below
        for i in range(len(a)):
            past = np.array(stages)
            at = state + np.tensordot(a[i, :i], past, 1) if i else state
            right = system.rate(at)
            if i:
                right = right + system.times_mass(np.tensordot(c[i, :i] / step, past, 1))
            if not np.isfinite(right).all():
                return state, math.inf
            stages.append(solve(right))
        found = np.array(stages)
        candidate = state + np.tensordot(tableau.m, found, 1)
        error = norm(np.tensordot(tableau.error, found, 1), np.maximum(np.abs(state), np.abs(candidate)))
    return (candidate, error) if math.isfinite(error) else (state, math.inf)
