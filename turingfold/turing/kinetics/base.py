"""Reaction kinetics p(u, v), q(u, v) of two morphogens: ∂u/∂t = d_u ∇²u + p, ∂v/∂t = d_v ∇²v + q.

Each is a frozen set of parameters with its rates, exact derivatives and all its uniform steady states.
Concentrations, lengths and times are dimensionless. The defaults are published sets; `published_ratio` is the
ratio d_inhibitor / d_activator that goes with them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import fields
from typing import ClassVar, TypeAlias

import numpy as np

from ...arrays import Array
from ...checks import finite, positive

Rates: TypeAlias = tuple[Array, Array]
Derivatives: TypeAlias = tuple[Array, Array, Array, Array]
UniformState: TypeAlias = tuple[float, float]


class Kinetics(ABC):
    """What every kinetics offers; u and v are arrays of one shape, and so are the results.

    `non_negative` says that u and v are concentrations, for which negative values have no meaning. Parameters
    must be positive, except those in `may_be_zero` and `any_sign`.
    """

    published_ratio: ClassVar[float]
    non_negative: ClassVar[bool] = True
    may_be_zero: ClassVar[tuple[str, ...]] = ()
    any_sign: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        """Refuse parameters that are not finite or have the wrong sign."""
        for name, value in self.parameters.items():
            label = f"{type(self).__name__}: {name}"
            if name in self.any_sign:
                finite(label, value)
            elif name not in self.may_be_zero or value != 0:
                positive(label, value)

    @abstractmethod
    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""

    @abstractmethod
    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""

    @abstractmethod
    def steady_states(self) -> tuple[UniformState, ...]:
        """Return every admissible uniform state (u, v) with p = q = 0; empty if there is none."""

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}  # type: ignore[arg-type]

    def jacobian(self, state: UniformState) -> Array:
        """Return ∂(p, q)/∂(u, v) at one state, shape (2, 2)."""
        u, v = np.array([state[0]]), np.array([state[1]])
        return np.array(self.derivatives(u, v)).reshape(2, 2)


def real_roots(*coefficients: float) -> list[float]:
    """Return the distinct real roots of a polynomial (highest power first), polished to round-off."""
    polynomial = np.trim_zeros(np.array(coefficients, dtype=float), "f")
    slope = np.polyder(polynomial)
    roots: list[float] = []
    for guess in np.roots(polynomial):
        if abs(guess.imag) > 1e-6 * max(1.0, abs(guess)):
            continue
        x = float(guess.real)
        for _ in range(3):
            rise = float(np.polyval(slope, x))
            if rise != 0.0:
                x -= float(np.polyval(polynomial, x)) / rise
        if all(abs(x - other) > 1e-9 * max(1.0, abs(x)) for other in roots):
            roots.append(x)
    return sorted(roots)
