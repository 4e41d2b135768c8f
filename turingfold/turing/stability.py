"""Linear stability of a uniform state: Turing's four conditions, critical ratio, band and fastest mode.

With J = ∂(p, q)/∂(u, v) at the steady state, a small pattern of squared wave number k² grows as exp(λ t),
where λ is an eigenvalue of J − k² diag(d_u, d_v). Formulas: Murray, Mathematical Biology II (2003), ch. 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..checks import finite_array, one_of, positive
from .kinetics.base import Kinetics, UniformState

NAN = float("nan")


@dataclass(frozen=True)
class Condition:
    """One inequality with its number: `value` must be below (or above) `bound`."""

    text: str
    value: float
    relation: str
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the inequality holds."""
        return self.value < self.bound if self.relation == "<" else self.value > self.bound

    def __str__(self) -> str:
        """Return one line of a table, with pass or fail."""
        verdict = "pass" if self.holds else "FAIL"
        return f"{self.text:<36} {self.value:>12.6g} {self.relation} {self.bound:<12.6g} {verdict}"


@dataclass(frozen=True)
class Conditions:
    """What linear theory says about a kinetics with two diffusivities; numbers that do not exist are NaN.

    activator: "u" or "v", the species with the positive diagonal entry of the Jacobian; "" if there is none.
    ratio, critical_ratio: d_inhibitor / d_activator, given and at the onset of instability.
    critical_k2: squared wave number at the onset, the activator's diffusivity kept.
    band: squared wave numbers between which modes grow.  fastest_k2, fastest_rate: of the mode that grows
        most.
    hopf_margin: −tr J; where it turns negative the uniform state oscillates, at `hopf_frequency` = √det J.
    """

    kinetics: Kinetics
    d_u: float
    d_v: float
    steady_states: tuple[UniformState, ...]
    steady_state: UniformState
    jacobian: Array
    checks: tuple[Condition, ...]
    activator: str
    ratio: float
    critical_ratio: float
    critical_k2: float
    band: tuple[float, float]
    fastest_k2: float
    fastest_rate: float
    hopf_margin: float
    hopf_frequency: float

    @property
    def shortest_k2(self) -> float:
        """Squared wave number above which nothing can grow, J_aa / D_a; NaN without an activator."""
        entries = {"u": self.jacobian[0, 0] / self.d_u, "v": self.jacobian[1, 1] / self.d_v}
        return float(entries.get(self.activator, NAN))

    @property
    def fastest_direction(self) -> Array:
        """Deviations (u, v) of the fastest mode, the activator's being 1; shape (2,)."""
        (f_u, f_v), _ = self.jacobian
        direction = np.array([f_v, self.fastest_rate - f_u + self.d_u * self.fastest_k2])
        return np.asarray(direction / direction[0 if self.activator == "u" else 1])

    def scaled_to(self, k2: float) -> Conditions:
        """Return the conditions with both diffusivities scaled so that k2 belongs to the fastest mode."""
        scale = self.fastest_k2 / positive("k2", k2)
        return conditions(self.kinetics, self.d_u * scale, self.d_v * scale)

    @property
    def unstable(self) -> bool:
        """Whether all four conditions hold: stable without diffusion, unstable with it."""
        return all(check.holds for check in self.checks)

    def __str__(self) -> str:
        """Return one line of a table, with pass or fail."""
        verdict = "Turing-unstable" if self.unstable else "NOT Turing-unstable"
        parameters = ", ".join(f"{name}={value:g}" for name, value in self.kinetics.parameters.items())
        name = type(self.kinetics).__name__
        lines = [
            f"{name}({parameters}), d_u={self.d_u:.6g}, d_v={self.d_v:.6g}: {verdict}",
            *(f"  {check}" for check in self.checks),
            f"  steady state u={self.steady_state[0]:.9g}, v={self.steady_state[1]:.9g}"
            f" (of {len(self.steady_states)}); activator {self.activator or 'none'}",
            f"  {self._ratios()}",
            f"  growing modes: {self._growing()}; fastest k² = {self.fastest_k2:.6g}, rate "
            f"{self.fastest_rate:.6g}",
            f"  Hopf: -tr J = {self.hopf_margin:.6g}, frequency {self.hopf_frequency:.6g}",
        ]
        return "\n".join(lines)

    def _ratios(self) -> str:
        if math.isnan(self.ratio):
            return "no ratio d_inhibitor/d_activator"
        given = f"ratio d_inhibitor/d_activator = {self.ratio:.6g}"
        if math.isnan(self.critical_ratio):
            return f"{given}, no critical one"
        return f"{given}, critical {self.critical_ratio:.9g} at k² = {self.critical_k2:.6g}"

    def _growing(self) -> str:
        low, high = self.band
        return "none" if math.isnan(high) else f"k² from {low:.6g} to {high:.6g}"


def conditions(kinetics: Kinetics, d_u: float, d_v: float) -> Conditions:
    """Examine a kinetics with diffusivities d_u, d_v > 0 for a Turing instability.

    Of several steady states the one examined is the first that is Turing-unstable, else the first that is
    stable without diffusion, else the first. Raises ValueError if there is none.
    """
    d_u, d_v = positive("d_u", d_u), positive("d_v", d_v)
    states = kinetics.steady_states()
    if not states:
        raise ValueError(
            f"{kinetics!r} has no uniform steady state{' with positive u and v' * kinetics.non_negative}; "
            "change its parameters."
        )
    found = [_examine(kinetics, d_u, d_v, states, state) for state in states]
    ranked = [c for c in found if c.unstable] + [c for c in found if c.checks[0].holds and c.checks[1].holds]
    return (ranked or found)[0]


def conditions_at_ratio(kinetics: Kinetics, ratio: float | None = None) -> Conditions:
    """Examine a kinetics with diffusivities 1 (activator) and `ratio` (inhibitor; default: published)."""
    ratio = positive("ratio", kinetics.published_ratio if ratio is None else ratio)
    u_first, v_first = (conditions(kinetics, *pair) for pair in ((1.0, ratio), (ratio, 1.0)))
    return v_first if v_first.activator == "v" and not u_first.unstable else u_first


def turing_unstable_at(kinetics: Kinetics, ratio: float | None = None) -> Conditions:
    """Examine as `conditions_at_ratio` does; raise ValueError with the table if not Turing-unstable."""
    found = conditions_at_ratio(kinetics, ratio)
    if not found.unstable:
        given = "" if math.isnan(found.ratio) else f"ratio={found.ratio:g}: "
        helps = found.checks[0].holds and found.ratio <= found.critical_ratio  # False where they are NaN
        remedy = f"a ratio above the critical one, {found.critical_ratio:.6g}, or " if helps else ""
        raise ValueError(
            f"{given}no pattern grows out of the uniform state, because not all four conditions of a Turing "
            f"instability hold; take "
            f"{remedy}other parameters. A pattern that only a large, local disturbance starts, as spots of "
            f"Gray and Scott's model, may exist all the same, but is not sought.\n{found}"
        )
    return found


def _examine(
    kinetics: Kinetics, d_u: float, d_v: float, states: tuple[UniformState, ...], state: UniformState
) -> Conditions:
    J = kinetics.jacobian(state)
    (f_u, f_v), (g_u, g_v) = J.tolist()
    trace, det, cross = f_u + g_v, f_u * g_v - f_v * g_u, -f_v * g_u
    B = d_v * f_u + d_u * g_v
    checks = (
        Condition("tr J < 0 (no oscillation)", trace, "<", 0.0),
        Condition("det J > 0 (stable if well mixed)", det, ">", 0.0),
        Condition("d_v f_u + d_u g_v > 0", B, ">", 0.0),
        Condition("(d_v f_u + d_u g_v)² > 4 d_u d_v det", B * B, ">", 4 * d_u * d_v * det),
    )
    activator = {(True, False): "u", (False, True): "v"}.get((f_u > 0, g_v > 0), "")
    ratio = critical_ratio = critical_k2 = NAN
    if activator:
        J_aa, D_a, D_i = (f_u, d_u, d_v) if activator == "u" else (g_v, d_v, d_u)
        ratio = D_i / D_a
        if det > 0 and cross > 0:
            critical_ratio = ((math.sqrt(det) + math.sqrt(cross)) / J_aa) ** 2
            critical_k2 = math.sqrt(det / critical_ratio) / D_a
    inner = B * B - 4 * d_u * d_v * det
    band = (NAN, NAN)
    if inner >= 0 and B > 0:
        upper = (B + math.sqrt(inner)) / (2 * d_u * d_v)
        band = (max(0.0, det / (d_u * d_v * upper)), upper)
    fastest_k2 = _fastest(J, d_u, d_v)
    return Conditions(
        kinetics, d_u, d_v, states, state, J, checks, activator, ratio, critical_ratio, critical_k2, band,
        fastest_k2, float(_growth(J, d_u, d_v, np.array([fastest_k2]))[0]),
        -trace, math.sqrt(det) if det > 0 else NAN,
    )  # fmt: skip


def _fastest(J: Array, d_u: float, d_v: float) -> float:
    # k² ≥ 0 of the largest growth rate: where the real branch has slope zero, or 0
    (f_u, f_v), (g_u, g_v) = J.tolist()
    if d_u == d_v or f_v * g_u >= 0:
        return 0.0
    pull = (d_u + d_v) * math.sqrt(-f_v * g_u / (d_u * d_v)) * math.copysign(1.0, d_v - d_u)
    k2 = (pull - (f_u - g_v)) / (d_v - d_u)
    if k2 <= 0:
        return 0.0
    at_zero, at_k2 = _growth(J, d_u, d_v, np.array([0.0, k2]))
    return k2 if at_k2 > at_zero else 0.0


def _growth(J: Array, d_u: float, d_v: float, k2: Array) -> Array:
    a, d = J[0, 0] - d_u * k2, J[1, 1] - d_v * k2
    half_gap = 0.5 * (a - d)
    inner = half_gap**2 + J[0, 1] * J[1, 0]
    return np.asarray(0.5 * (a + d) + np.sqrt(np.maximum(inner, 0.0)))


def dispersion(kinetics: Kinetics, d_u: float, d_v: float, k2: ArrayLike) -> Array:
    """Return the largest real part of the eigenvalues of J − k² diag(d_u, d_v), in the shape of k2."""
    found = conditions(kinetics, d_u, d_v)
    squared = np.asarray(k2, dtype=float)
    finite_array("k2", squared.reshape(-1), (None,))
    return _growth(found.jacobian, found.d_u, found.d_v, squared)


def hopf_boundary(kinetics: Kinetics, parameter: str, between: tuple[float, float]) -> float:
    """Return the value of a parameter at which tr J = 0, the others as given.

    Raises ValueError if the name is unknown or tr J has the same sign at both ends of `between`.
    """
    one_of("parameter", parameter, tuple(kinetics.parameters))

    def trace(value: float) -> float:
        changed = replace(kinetics, **{parameter: value})  # type: ignore[type-var]
        return -conditions(changed, 1.0, 1.0).hopf_margin

    ends = trace(between[0]), trace(between[1])
    if ends[0] * ends[1] > 0:
        raise ValueError(
            f"tr J is {ends[0]:g} at {parameter}={between[0]:g} and {ends[1]:g} at "
            f"{parameter}={between[1]:g}: there is no Hopf boundary between them; widen `between`."
        )
    from scipy.optimize import brentq  # slow to import, and few kinetics need it

    return float(brentq(trace, *between, xtol=1e-14, rtol=1e-14))
