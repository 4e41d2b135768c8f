"""Exact solutions of growing discs and rings, from the elastic energy alone.

With r(R), growth g around and g_z out of plane, a = r', b = r/(g R), c = 1/g_z, the nominal stresses
Π = g g_z ∂ψ/∂a and H = g_z ∂ψ/∂b balance as (R Π)' = H.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..arrays import Array
from ..terms.elastic.material import NeoHookean


def psi_slope(material: NeoHookean, a: float, b: float, c: float) -> float:
    """Return ∂ψ/∂a of ψ(a, b, c) at principal stretches; ∂ψ/∂b by exchanging a and b."""
    J, I1 = a * b * c, a * a + b * b + c * c
    shear = material.mu * J ** (-2 / 3) * (a - I1 / (3 * a))
    return float(shear + material.kappa * (J - 1) * b * c)


def psi_curvature(material: NeoHookean, a: float, b: float, c: float) -> float:
    """Return ∂²ψ/∂a²."""
    J, I1 = a * b * c, a * a + b * b + c * c
    shear = material.mu * J ** (-2 / 3) * (5 * I1 / (9 * a * a) - 1 / 3)
    return float(shear + material.kappa * (b * c) ** 2)


@dataclass(frozen=True)
class Layer:
    """A ring of one material with growth around, and out of plane by `out`."""

    material: NeoHookean
    inner: float
    outer: float
    growth: float
    out: float = 1.0

    def outward(self, radius: float, stress: float) -> tuple[float, float]:
        """Return r and Π at the outer radius from those at the inner one."""
        start, ends = np.array([radius, stress]), (self.inner, self.outer)
        found = solve_ivp(self._slope, ends, start, rtol=1e-11, atol=1e-13, method="DOP853")
        return float(found.y[0, -1]), float(found.y[1, -1])

    def _slope(self, R: float, y: Array) -> list[float]:
        a, b, c = 1.0, y[0] / (self.growth * R), 1 / self.out
        for _ in range(50):
            excess = psi_slope(self.material, a, b, c) - y[1] / (self.growth * self.out)
            step = excess / psi_curvature(self.material, a, b, c)
            a -= float(np.clip(step, -0.3 * a, 0.3 * a))
            if abs(step) < 1e-14:
                break
        return [a, (self.out * psi_slope(self.material, b, a, c) - y[1]) / R]


def disc(
    core: NeoHookean, cortex: NeoHookean, thickness: float, growth: float, out: float = 1.0
) -> tuple[float, float, float]:
    """Return core stretch, outer radius and core stress of a disc of radius 1 with a growing cortex."""
    inner = 1 - thickness
    layer = Layer(cortex, inner, 1.0, growth, out)

    def at_surface(stretch: float) -> float:
        return layer.outward(stretch * inner, psi_slope(core, stretch, stretch, 1.0))[1]

    stretch = brentq(at_surface, 0.98, 1.0 + 0.98 * (growth - 1), xtol=1e-14)
    stress = psi_slope(core, stretch, stretch, 1.0)
    return stretch, layer.outward(stretch * inner, stress)[0], stress / stretch  # Cauchy stress Π/λ


def free_ring(material: NeoHookean, growth: float, inner: float = 0.5) -> tuple[float, float]:
    """Return inner and outer radius of a growing ring without loads, 1 its outer radius at rest."""
    layer = Layer(material, inner, 1.0, growth)
    found = brentq(lambda r: layer.outward(r, 0.0)[1], 0.8 * inner, 2.0 * inner, xtol=1e-13)
    return found, layer.outward(found, 0.0)[0]


def incompressible_stress(g: float, a: float, A: float, B: float) -> float:
    """Return T_rr/μ at the inner radius a of a ring A < R < B that keeps its volume, free outside.

    With c = g A² - a², b² = a² + g (B² - A²):
    T_rr = -μ {(1/2g) ln[(b² + c)/(a² + c)] - g [ln(b/a) - (c/2)(1/b² - 1/a²)]}.
    """
    c = g * A * A - a * a
    b = np.sqrt(a * a + g * (B * B - A * A))
    logs = np.log((b * b + c) / (a * a + c)) / (2 * g)
    return float(-(logs - g * (np.log(b / a) - c / 2 * (1 / b**2 - 1 / a**2))))
