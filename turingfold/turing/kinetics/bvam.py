"""Kinetics of Barrio, Varea, Aragón and Maini, cubic about the uniform state (0, 0): u and v change sign."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...arrays import Array
from .base import Derivatives, Kinetics, Rates, UniformState, real_roots


@dataclass(frozen=True)
class BVAM(Kinetics):
    """p = α u (1 − r₁v²) + v (1 − r₂u), q = β v (1 + α r₁ u v / β) + u (γ + r₂v), about the state (0, 0).

    Defaults α = 0.899, β = −0.91, γ = −0.899, ratio 1/0.516: Barrio, Varea, Aragón, Maini (1999) Bull. Math.
    Biol. 61:483; r₁ = 3.5, r₂ = 0 (stripes), because the spot set r₁ = 0.02, r₂ = 0.2 does not settle on a
    thin band.
    """

    alpha: float = 0.899
    beta: float = -0.91
    gamma: float = -0.899
    r1: float = 3.5
    r2: float = 0.0
    published_ratio: ClassVar[float] = 1 / 0.516
    non_negative: ClassVar[bool] = False
    any_sign: ClassVar[tuple[str, ...]] = ("alpha", "beta", "gamma", "r1", "r2")

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        cubic, square = self.alpha * self.r1 * u * v * v, self.r2 * u * v
        return self.alpha * u - cubic + v - square, self.beta * v + cubic + self.gamma * u + square

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        by_u = self.alpha * self.r1 * v * v + self.r2 * v
        by_v = 2 * self.alpha * self.r1 * u * v + self.r2 * u
        return self.alpha - by_u, 1 - by_v, self.gamma + by_u, self.beta + by_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return (0, 0) and the points of the line (α+γ)u + (1+β)v = 0 where p vanishes."""
        if self.beta == -1:  # u vanishes, and with it v
            return ((0.0, 0.0),)
        s = -(self.alpha + self.gamma) / (1 + self.beta)
        others = real_roots(-self.alpha * self.r1 * s * s, -s * self.r2, self.alpha + s)
        return ((0.0, 0.0), *((u, s * u) for u in others if u != 0))


@dataclass(frozen=True)
class BVAM2012(Kinetics):
    """p = η (u + a v − C u v − u v²), q = η (H u + b v + C u v + u v²), about the state (0, 0).

    Defaults η = 1, a = −1, b = −1.5, H = 3, C = 0, ratio 12.5 (d_u = 0.08 d_v): Aragón, Barrio, Woolley,
    Baker, Maini (2012) Phys. Rev. E 86:026201.
    """

    eta: float = 1.0
    a: float = -1.0
    b: float = -1.5
    H: float = 3.0
    C: float = 0.0
    published_ratio: ClassVar[float] = 12.5
    non_negative: ClassVar[bool] = False
    any_sign: ClassVar[tuple[str, ...]] = ("a", "b", "H", "C")

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        coupling = self.C * u * v + u * v * v
        return self.eta * (u + self.a * v - coupling), self.eta * (self.H * u + self.b * v + coupling)

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        by_u, by_v = self.C * v + v * v, self.C * u + 2 * u * v
        eta = self.eta
        return eta * (1 - by_u), eta * (self.a - by_v), eta * (self.H + by_u), eta * (self.b + by_v)

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return (0, 0) and the points of the line (1+H)u + (a+b)v = 0 where p vanishes."""
        if self.a + self.b == 0:  # u vanishes, and with it v
            return ((0.0, 0.0),)
        s = -(1 + self.H) / (self.a + self.b)
        others = real_roots(-s * s, -self.C * s, 1 + self.a * s)
        return ((0.0, 0.0), *((u, s * u) for u in others if u != 0))
