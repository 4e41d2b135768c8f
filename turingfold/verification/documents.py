"""Numbers of documents 1 and 2: tissue, layers, growth of the ferret, the pattern on document 1's body."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad_vec

from ..arrays import Array
from ..geometry.layers import cortex_indicator
from ..geometry.shapes import semicircle
from ..growth.laws import RateGrowth
from ..models.ferret import P32
from ..morphometry.polyline import perimeter
from ..state import State
from ..turing.kinetics.chemical import Schnakenberg
from ..turing.process import Turing
from .check import Check, Quantity, quantities
from .setups import GRAY, SOFT, WHITE


def tissue() -> list[Quantity]:
    """μ = E/(2 (1 + ν)), κ = E/(3 (1 - 2ν)): E = 1389 and 1895 Pa, ν = 0.4583; white over gray is 1.364.

    Document 2's κ = 5 μ is ν = (3κ - 2μ)/(2 (3κ + μ)) = 13/32.
    """
    known = [1389 / (2 * 1.4583), 1895 / (2 * 1.4583), 1389 / (3 * (1 - 2 * 0.4583)), 1895 / 1389, 13 / 32]
    got = [GRAY.mu, WHITE.mu, GRAY.kappa, WHITE.mu / GRAY.mu, SOFT.poisson]
    names = ["μ gray, Pa", "μ white, Pa", "κ gray, Pa", "white over gray", "document 2's Poisson ratio"]
    return quantities(names, known, got, 1e-12)


def body() -> list[Quantity]:
    """Length π R and area π R²/2 of the half disc of 40.4 mm; quadratic sides have them to (h/R)⁴."""
    made = semicircle(radius=0.0404, thickness=2.5e-3, elements=2)
    line = made.nodes[:, made.pial]
    area = float(made.quadrature.weights.sum())
    return [
        Quantity("pial length, m", np.pi * 0.0404, perimeter(line), 2e-4),
        Quantity("area, m²", np.pi * 0.0404**2 / 2, area, 1e-6),
    ]


def pattern() -> list[Quantity]:
    """24 half waves along document 1's cortex, k² = 613.38141151902/R², and ⟨u⟩ = a + b, as ∫ (p + q) = 0.

    k² are zeros of Bessel functions; three elements through the cortex have it to 2e-3.
    """
    made = semicircle(radius=0.0404, thickness=2.5e-3, elements=3)
    found = Turing(Schnakenberg(a=0.1, b=0.9), half_waves=24).pattern(made)
    k2 = found.design.conditions.fastest_k2
    return [
        Quantity("half waves", 24.0, float(found.half_waves), 0.0),
        Quantity("fastest k² R²", 613.38141151902, float(k2) * 0.0404**2, 2e-3),
        Quantity("mean of u", 1.0, float(found.system.space.mean(found.steady.state)[0]), 1e-12),
    ]


def layers() -> list[Quantity]:
    """θ = 1/(1 + exp(10 (y/T - 1))) in document 2's sigmoid layers: the largest error at all points."""
    made = semicircle(radius=1.0, thickness=0.1, size=0.1, layers="sigmoid")
    exact = 1 / (1 + np.exp(10 * (made.depth / 0.1 - 1)))
    error = float(np.abs(cortex_indicator(made) - exact).max())
    return [Quantity("largest error of θ", 0.0, error, 1e-12)]


def ferret_growth() -> list[Quantity]:
    """Ġ = 1.9 θ(y/T(t)) G along the surface, T = T₀ (1 - t/2): g = exp(1.9 ∫ θ dt), at P32, t = 0.44.

    On the surface e^{0.836}, less θ(0)'s 5e-5. scipy's adaptive quadrature of θ at every point, to 1e-9.
    """
    made = semicircle(radius=1.0, thickness=0.1, size=0.1, layers="sigmoid")
    law = RateGrowth(rate=1.9, thinning=0.5)
    got = law.on(made).advance(State(0.0), State(P32), P32)["growth"][0].ravel()
    share = (made.depth / 0.1).ravel()

    def theta(time: float) -> Array:
        return np.asarray(1 / (1 + np.exp(10 * (share / (1 - 0.5 * time) - 1))))

    known = np.exp(1.9 * quad_vec(theta, 0.0, P32, epsrel=1e-10)[0])
    outermost = int(np.argmin(share))
    return [
        Quantity("largest error of g, relative", 0.0, float(np.abs(got / known - 1).max()), 1e-6),
        Quantity("g next to the surface", float(known[outermost]), float(got[outermost]), 1e-6),
        Quantity("g on the surface", float(np.exp(1.9 * P32)), float(got.max()), 1e-2),
    ]


CHECKS = (
    Check("Document 1 and 2: tissue", tissue, "definitions"),
    Check("Document 1: body", body, "circle"),
    Check("Document 1: pattern", pattern, "Bessel functions"),
    Check("Document 2: growth at P32", ferret_growth, "Choi et al. 2025"),
    Check("Document 2: layers", layers, "Choi et al. 2025"),
)
