"""Kinetics given as Python functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array
from ...checks import finite_array, positive
from .base import Derivatives, Kinetics, Rates, UniformState

Rate = Callable[[Array, Array], Array]


@dataclass(frozen=True, kw_only=True)
class UserKinetics(Kinetics):
    """Kinetics from functions of arrays: p(u, v), q(u, v) and, if given, their four derivatives.

    p, q: rates of u and v, from arrays to arrays: np.exp, not math.exp; np.where, not if.
    partial_derivatives: function giving ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v; without it central differences are used.
    guesses: states (u, v) from which uniform steady states are searched; at least one.
    ratio: d_inhibitor / d_activator to use where none is asked for.

    Raises ValueError if the functions do not return finite arrays of the shape given, or if the derivatives
    disagree with differences of p and q by more than 1e-5 near a guess.
    """

    p: Rate
    q: Rate
    guesses: tuple[UniformState, ...]
    partial_derivatives: Callable[[Array, Array], Derivatives] | None = None
    ratio: float = 10.0
    non_negative: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Evaluate the functions near every guess and compare them with each other."""
        positive("UserKinetics: ratio", self.ratio)
        guesses = finite_array("UserKinetics: guesses", np.atleast_2d(self.guesses), (None, 2))
        object.__setattr__(self, "guesses", tuple((float(u), float(v)) for u, v in guesses))
        spread = 1 + np.array([-0.1, 0.0, 0.1])
        for guess in self.guesses:
            u, v = guess[0] * spread + 0.01, guess[1] * spread[::-1] + 0.01
            for name, rate in (("p", self.p), ("q", self.q)):
                finite_array(f"UserKinetics: {name}(u, v)", _tried(name, rate, u, v), (len(u),))
            if self.partial_derivatives is not None:
                given = _tried("partial_derivatives", self.partial_derivatives, u, v)
                name = "UserKinetics: partial_derivatives(u, v)"
                p_u, p_v, q_u, q_v = finite_array(name, given, (4, len(u)))
                self._compare((p_u, p_v, q_u, q_v), self._differences(u, v), (u, v))

    @property
    def published_ratio(self) -> float:  # type: ignore[override]
        """The ratio given."""
        return self.ratio

    @property
    def parameters(self) -> dict[str, float]:
        """None by name: they live inside the functions."""
        return {}

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        return np.asarray(self.p(u, v)), np.asarray(self.q(u, v))

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        if self.partial_derivatives is None:
            return self._differences(u, v)
        p_u, p_v, q_u, q_v = (np.asarray(values) for values in self.partial_derivatives(u, v))
        return p_u, p_v, q_u, q_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return the distinct states that Newton's method reaches from the guesses."""
        found: list[UniformState] = []
        for guess in self.guesses:
            state = self._newton(guess)
            if state is not None and all(
                np.hypot(state[0] - u, state[1] - v) > 1e-7 * (1 + np.hypot(u, v)) for u, v in found
            ):
                found.append(state)
        return tuple(found)

    def _newton(self, guess: UniformState) -> UniformState | None:
        x = np.array(guess)
        for _ in range(50):
            rate = np.array(self.rates(x[:1], x[1:]))[:, 0]
            jacobian = self.jacobian((x[0], x[1]))
            if not np.isfinite(rate).all() or abs(np.linalg.det(jacobian)) < 1e-300:
                return None
            step = np.linalg.solve(jacobian, rate)
            x = x - step
            if np.abs(step).max() <= 1e-12 * (1 + np.abs(x).max()):
                return float(x[0]), float(x[1])
        return None

    def _differences(self, u: Array, v: Array) -> Derivatives:
        size = np.cbrt(np.finfo(float).eps)
        h, k = size * (1 + np.abs(u)), size * (1 + np.abs(v))
        rates = self.rates
        by_u = [(a - b) / (2 * h) for a, b in zip(rates(u + h, v), rates(u - h, v), strict=True)]
        by_v = [(a - b) / (2 * k) for a, b in zip(rates(u, v + k), rates(u, v - k), strict=True)]
        return by_u[0], by_v[0], by_u[1], by_v[1]

    def _compare(self, given: Derivatives, differences: Derivatives, at: Rates) -> None:
        scale = max(float(np.abs(value).max()) for value in differences) + 1e-30
        for name, mine, theirs in zip(("∂p/∂u", "∂p/∂v", "∂q/∂u", "∂q/∂v"), differences, given, strict=True):
            worst = int(np.argmax(np.abs(mine - theirs)))
            if abs(mine[worst] - theirs[worst]) > 1e-5 * scale:
                raise ValueError(
                    f"UserKinetics: partial_derivatives gives {name}={theirs[worst]:g} at "
                    f"u={at[0][worst]:g}, v={at[1][worst]:g}, but differences of the rates give "
                    f"{mine[worst]:g}; correct it or leave it out."
                )


def _tried(name: str, function: Callable[[Array, Array], Any], u: Array, v: Array) -> Any:
    """Return what a user's function makes of arrays; raise ValueError with the remedy where it fails."""
    try:
        return function(u, v)
    except (TypeError, ValueError, ArithmeticError, AttributeError) as error:
        raise ValueError(
            f"UserKinetics: {name}(u, v) failed for arrays u and v with {type(error).__name__}: {error}; use "
            "numpy on whole arrays: np.exp in place of math.exp, np.where in place of if."
        ) from error
