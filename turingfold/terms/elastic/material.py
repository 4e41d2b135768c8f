"""The neo-Hookean material: parameters, and the derivatives of its energy along the invariants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...checks import finite, positive


@dataclass(frozen=True, kw_only=True)
class NeoHookean:
    """Compressible neo-Hookean solid, ψ = μ/2 (I₁ J^{-2/3} - 3) + κ/2 (J - 1)² per unit reference volume.

    I₁ is the full three-dimensional trace, F_zz² included: without it an undeformed body in plane strain
    would be stressed. mu, kappa: shear and bulk modulus in Pa.

    *A Mathematical Model of Cerebral Cortical Folding Development* prints the exponent as +2/3 (its energy
    has no minimum at rest; it must be -2/3), calls κ = E/(3(1-2ν)) the shear modulus μ, and gives white/gray
    as 1.39 where its own moduli make 1895/1389 = 1.364. None of the three is used here.
    Raises ValueError unless both moduli are positive and given by name.
    """

    mu: float
    kappa: float

    def __new__(cls, *unnamed: Any, **named: Any) -> NeoHookean:
        """Refuse moduli without names: two numbers may be E and ν as well as μ and κ."""
        if unnamed:
            numbers = ", ".join(map(repr, unnamed))
            raise ValueError(
                f"NeoHookean({numbers}) does not say which moduli these are; write "
                f"NeoHookean.from_young({numbers}) for Young's modulus and Poisson's ratio, or "
                "NeoHookean(mu=..., kappa=...) for the shear and the bulk modulus in Pa."
            )
        return super().__new__(cls)

    def __post_init__(self) -> None:
        positive("mu", self.mu, remedy="give the shear modulus in Pa")
        positive("kappa", self.kappa, remedy="give the bulk modulus in Pa")

    @classmethod
    def from_young(cls, young: float, poisson: float) -> NeoHookean:
        """Return the material with μ = E/(2(1+ν)), κ = E/(3(1-2ν)); young in Pa, -1 < poisson < 0.5."""
        E, nu = positive("young", young), finite("poisson", poisson)
        if not -1 < nu < 0.5:
            raise ValueError(
                f"poisson={nu:g} must lie between -1 and 0.5, both excluded; "
                "for nearly incompressible tissue use 0.4999 or less."
            )
        return cls(mu=E / (2 * (1 + nu)), kappa=E / (3 * (1 - 2 * nu)))

    @property
    def young(self) -> float:
        """Young's modulus, 9κμ/(3κ + μ); Pa."""
        return 9 * self.kappa * self.mu / (3 * self.kappa + self.mu)

    @property
    def poisson(self) -> float:
        """Poisson's ratio, (3κ - 2μ)/(2(3κ + μ))."""
        return (3 * self.kappa - 2 * self.mu) / (2 * (3 * self.kappa + self.mu))


def shrink(J: Array) -> Array:
    """Return J^{-2/3}, which energy and derivatives share; a cube root would take twice the time."""
    return np.asarray(J ** (-2.0 / 3.0))


def energy(mu: Array, kappa: Array, I1: Array, J: Array, shrunk: Array | None = None) -> Array:
    """Return ψ at the invariants; all arrays of one shape, Pa.  shrunk: `shrink(J)`, if it is known."""
    shrunk = shrink(J) if shrunk is None else shrunk
    return np.asarray(0.5 * mu * (I1 * shrunk - 3.0) + 0.5 * kappa * (J - 1.0) ** 2)


def stress_coefficients(
    mu: Array, kappa: Array, I1: Array, J: Array, shrunk: Array | None = None
) -> tuple[Array, Array]:
    """Return a, b of the first Piola stress P = a F + b ∂J/∂F."""
    a = mu * (shrink(J) if shrunk is None else shrunk)
    return a, kappa * (J - 1.0) - a * I1 / (3.0 * J)


def tangent_coefficients(
    mu: Array, kappa: Array, I1: Array, J: Array, shrunk: Array | None = None
) -> tuple[Array, Array]:
    """Return c₁, c₂ of ∂P/∂F = a 1 + c₁ (F⊗C + C⊗F) + c₂ C⊗C + b ∂C/∂F with C = ∂J/∂F."""
    ratio = mu * (shrink(J) if shrunk is None else shrunk) / J
    return (-2.0 / 3.0) * ratio, kappa + (5.0 / 9.0) * ratio * I1 / J
