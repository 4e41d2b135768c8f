"""Kinetics of chemical reactions: one species feeds the other, or is used up by it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import Array
from .base import Derivatives, Kinetics, Rates, UniformState, real_roots


@dataclass(frozen=True)
class Schnakenberg(Kinetics):
    """p = a − u + u²v, q = b − u²v.

    Defaults a = 0.1, b = 0.9, ratio 10: Madzvamuse, Wathen, Maini (2003) J. Comput. Phys. 190:478.
    Kinetics: Schnakenberg (1979) J. Theor. Biol. 81:389.
    """

    a: float = 0.1
    b: float = 0.9
    published_ratio: ClassVar[float] = 10.0
    may_be_zero: ClassVar[tuple[str, ...]] = ("a",)

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        turnover = u * u * v
        return self.a - u + turnover, self.b - turnover

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        by_u, by_v = 2 * u * v, u * u
        return by_u - 1, by_v, -by_u, -by_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return (a + b, b / (a + b)²)."""
        total = self.a + self.b
        return ((total, self.b / total**2),)


@dataclass(frozen=True)
class Brusselator(Kinetics):
    """p = A − (B + 1) u + u²v, q = B u − u²v; oscillates for B > 1 + A².

    Defaults A = 2, B = 3, ratio 8: the VisualPDE preset brusselator (critical ratio 7.4641).
    Kinetics: Prigogine, Lefever (1968) J. Chem. Phys. 48:1695.
    """

    A: float = 2.0
    B: float = 3.0
    published_ratio: ClassVar[float] = 8.0

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        turnover = u * u * v
        return self.A - (self.B + 1) * u + turnover, self.B * u - turnover

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        by_u, by_v = 2 * u * v, u * u
        return by_u - self.B - 1, by_v, self.B - by_u, -by_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return (A, B / A)."""
        return ((self.A, self.B / self.A),)


@dataclass(frozen=True)
class Thomas(Kinetics):
    """p = a − u − h, q = α (b − v) − h, h = ρ u v / (1 + u + K u²).

    Defaults a = 150, b = 100, α = 1.5, ρ = 13, K = 0.05: Murray, Mathematical Biology II (2003), with his
    ratio 27.03 raised to 30, clear of the critical 27.015. Kinetics: Thomas (1975).
    """

    a: float = 150.0
    b: float = 100.0
    alpha: float = 1.5
    rho: float = 13.0
    K: float = 0.05
    published_ratio: ClassVar[float] = 30.0
    may_be_zero: ClassVar[tuple[str, ...]] = ("K",)

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        uptake = self.rho * u * v / (1 + u + self.K * u * u)
        return self.a - u - uptake, self.alpha * (self.b - v) - uptake

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        brake = 1 + u + self.K * u * u
        by_u = self.rho * v * (1 - self.K * u * u) / brake**2
        by_v = self.rho * u / brake
        return -1 - by_u, -by_v, -by_u, -self.alpha - by_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return the roots of (a − u)(1 + u + K u²) = ρ u v with v = b − (a − u) / α, both positive."""
        a, b, alpha, rho, K = self.a, self.b, self.alpha, self.rho, self.K
        roots = real_roots(-K, a * K - 1 - rho / alpha, a - 1 - rho * (b - a / alpha), a)
        pairs = ((u, b - (a - u) / alpha) for u in roots)
        return tuple((u, v) for u, v in pairs if u > 0 and v > 0)


@dataclass(frozen=True)
class GrayScott(Kinetics):
    """p = −u v² + F (1 − u), q = u v² − (F + k) v; the activator is v.

    Defaults F = 0.055, k = 0.062, ratio 2 (d_u = 2 d_v): K. Sims' reaction–diffusion page, one of the few
    popular sets with a Turing-unstable uniform state. Kinetics: Gray, Scott (1984); Pearson (1993).
    """

    F: float = 0.055
    k: float = 0.062
    published_ratio: ClassVar[float] = 2.0

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        turnover = u * v * v
        return self.F * (1 - u) - turnover, turnover - (self.F + self.k) * v

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        by_u, by_v = v * v, 2 * u * v
        return -self.F - by_u, -by_v, by_u, by_v - self.F - self.k

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return (1, 0) and, where F ≥ 4 (F + k)², v = [F ± √(F² − 4F(F+k)²)] / (2(F+k)), u = (F+k)/v."""
        loss = self.F + self.k
        inner = self.F**2 - 4 * self.F * loss**2
        if inner < 0:
            return ((1.0, 0.0),)
        values = {(self.F + sign * float(np.sqrt(inner))) / (2 * loss) for sign in (1, -1)}
        return ((1.0, 0.0), *((loss / v, v) for v in sorted(values, reverse=True)))


@dataclass(frozen=True)
class LengyelEpstein(Kinetics):
    """p = a − u − 4uv / (1 + u²), q = σ b (u − uv / (1 + u²)); the CDIMA reaction, d_v = σ c d_u.

    Defaults a = 12, b = 0.31, σ = 50, ratio 53.5 (c = 1.07): the photosensitive CDIMA literature, as
    Horváth, Dolnik, Muñuzuri, Epstein (1999) Phys. Rev. Lett. 83:2950.
    """

    a: float = 12.0
    b: float = 0.31
    sigma: float = 50.0
    published_ratio: ClassVar[float] = 53.5

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        uptake = u * v / (1 + u * u)
        return self.a - u - 4 * uptake, self.sigma * self.b * (u - uptake)

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        brake = 1 + u * u
        by_u, by_v = v * (1 - u * u) / brake**2, u / brake
        rate = self.sigma * self.b
        return -1 - 4 * by_u, -4 * by_v, rate * (1 - by_u), -rate * by_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return (a / 5, 1 + a² / 25)."""
        u = self.a / 5
        return ((u, 1 + u * u),)
