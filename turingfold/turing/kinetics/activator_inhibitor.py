"""An activator that makes its own inhibitor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import Array
from .base import Derivatives, Kinetics, Rates, UniformState, real_roots


@dataclass(frozen=True)
class GiererMeinhardt(Kinetics):
    """p = a − b u + u² / (v (1 + K u²)), q = u² − c v; K saturates the autocatalysis.

    Defaults a = 0.5, b = 1, c = 6.1, K = 0, ratio 100: the VisualPDE preset GiererMeinhardt.
    Kinetics: Gierer, Meinhardt (1972) Kybernetik 12:30.
    """

    a: float = 0.5
    b: float = 1.0
    c: float = 6.1
    K: float = 0.0
    published_ratio: ClassVar[float] = 100.0
    may_be_zero: ClassVar[tuple[str, ...]] = ("a", "K")

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        square = u * u
        return self.a - self.b * u + square / (v * (1 + self.K * square)), square - self.c * v

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        brake = 1 + self.K * u * u
        return 2 * u / (v * brake**2) - self.b, -u * u / (v * v * brake), 2 * u, np.full_like(u, -self.c)

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return ((a + c) / b, u² / c) for K = 0, else the positive roots of (b u − a)(1 + K u²) = c."""
        a, b, c, K = self.a, self.b, self.c, self.K
        return tuple((u, u * u / c) for u in real_roots(b * K, -a * K, b, -(a + c)) if u > 0)


@dataclass(frozen=True)
class KochMeinhardt(Kinetics):
    """p = ρ_a u² / ((1 + κ u²) v) − μ_a u, q = ρ_h u² − μ_h v.

    Defaults ρ_a = μ_a = 0.01, ρ_h = μ_h = 0.02, κ = 0.25, ratio 40 (stripes): Koch, Meinhardt (1994)
    Rev. Mod. Phys. 66:1481.
    """

    rho_a: float = 0.01
    mu_a: float = 0.01
    rho_h: float = 0.02
    mu_h: float = 0.02
    kappa: float = 0.25
    published_ratio: ClassVar[float] = 40.0
    may_be_zero: ClassVar[tuple[str, ...]] = ("kappa",)

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        square = u * u
        production = self.rho_a * square / ((1 + self.kappa * square) * v)
        return production - self.mu_a * u, self.rho_h * square - self.mu_h * v

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        brake = 1 + self.kappa * u * u
        return (
            2 * self.rho_a * u / (brake**2 * v) - self.mu_a,
            -self.rho_a * u * u / (brake * v * v),
            2 * self.rho_h * u,
            np.full_like(u, -self.mu_h),
        )

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return the root of κ u³ + u = ρ_a μ_h / (ρ_h μ_a), v = ρ_h u² / μ_h."""
        strength = self.rho_a * self.mu_h / (self.rho_h * self.mu_a)
        return tuple((u, self.rho_h * u * u / self.mu_h) for u in real_roots(self.kappa, 0, 1, -strength))


@dataclass(frozen=True)
class FitzHughNagumo(Kinetics):
    """p = u − u³ − v + κ, q = e_v (u − a_v v − a_z).

    Defaults e_v = 10, a_v = 1, a_z = 0, κ = −0.005, ratio 0.05/0.00028: Rossant, IPython Cookbook (2018),
    reaction–diffusion recipe (his τ is 1/e_v).
    """

    e_v: float = 10.0
    a_v: float = 1.0
    a_z: float = 0.0
    kappa: float = -0.005
    published_ratio: ClassVar[float] = 0.05 / 0.00028
    non_negative: ClassVar[bool] = False
    any_sign: ClassVar[tuple[str, ...]] = ("a_v", "a_z", "kappa")

    def rates(self, u: Array, v: Array) -> Rates:
        """Return p and q."""
        return u - u**3 - v + self.kappa, self.e_v * (u - self.a_v * v - self.a_z)

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v."""
        one = np.ones_like(u)
        return 1 - 3 * u * u, -one, self.e_v * one, -self.e_v * self.a_v * one

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return the roots of a_v (u − u³ + κ) = u − a_z with v = u − u³ + κ."""
        a_v = self.a_v
        roots = real_roots(-a_v, 0, a_v - 1, a_v * self.kappa + self.a_z)
        return tuple((u, u - u**3 + self.kappa) for u in roots)
