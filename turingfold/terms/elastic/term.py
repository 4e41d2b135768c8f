"""The elastic term: materials of the two layers, and the element that carries them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array
from ...checks import one_of
from ...geometry.body import Body
from ...geometry.layers import cortex_indicator
from ...parts import Operator, Solid
from .material import NeoHookean

INNER = ("bubble", "element_pressure")
SHOWN = ("cauchy_stress", "elastic_volume", "moduli")
ELEMENTS = ("auto", "quadratic", "mixed")
NEARLY_INCOMPRESSIBLE = 0.49  # Poisson's ratio from which the quadratic element locks


@dataclass(frozen=True, kw_only=True)
class Elastic(Solid):
    """Elastic energy ∫ J_G ψ(F*) dA of a gray and a white neo-Hookean layer.

    Where processes write them, "growth" makes it grow and "modulus_factor" multiplies its moduli.

    Between the layers moduli change as `Body.layers` says. Without `white` the whole body is gray.
    element: "quadratic" triangles, "mixed" ones with a bubble and their own pressure, which do not lock, or
    "auto": mixed where a Poisson's ratio is at least 0.49.
    """

    gray: NeoHookean
    white: NeoHookean | None = None
    element: str = "auto"

    def __post_init__(self) -> None:
        one_of("element", self.element, ELEMENTS)
        for name, value in (("gray", self.gray), ("white", self.white)):
            if not (isinstance(value, NeoHookean) or (name == "white" and value is None)):
                raise ValueError(
                    f"{name}={value!r} must be a NeoHookean, e.g. NeoHookean.from_young(1389.0, 0.4583)."
                )

    @property
    def optional(self) -> tuple[str, ...]:
        """Growth factors, the factor of the moduli, and what the mixed element starts from."""
        return ("growth", "modulus_factor", *(INNER if self.mixed else ()))

    @property
    def writes(self) -> tuple[str, ...]:
        """Stress, volume ratio J* and moduli where a part reads them, and unknowns inside mixed elements."""
        return (*SHOWN, *(INNER if self.mixed else ()))

    @property
    def shear_modulus(self) -> float:
        """The largest shear modulus; Pa."""
        return max(self.gray.mu, self.white.mu if self.white else 0.0)

    @property
    def mixed(self) -> bool:
        """Whether the mixed element is used."""
        ratios = [layer.poisson for layer in (self.gray, self.white) if layer is not None]
        nearly = max(ratios) >= NEARLY_INCOMPRESSIBLE - 1e-12
        return self.element == "mixed" or (self.element == "auto" and nearly)

    def on(self, body: Body) -> Operator:
        """Return the term discretised on `body`."""
        if self.mixed:
            from .mixed import MixedOperator

            return MixedOperator(body, *self.moduli(body))
        from .quadratic import ElasticOperator

        return ElasticOperator(body, *self.moduli(body))

    def moduli(self, body: Body) -> tuple[Array, Array]:
        """Return μ and κ at the integration points, each (q, e); Pa."""
        shape = body.quadrature.weights.shape
        if self.white is None:
            return np.full(shape, self.gray.mu), np.full(shape, self.gray.kappa)
        share = cortex_indicator(body)
        gray, white = self.gray, self.white
        return white.mu + share * (gray.mu - white.mu), white.kappa + share * (gray.kappa - white.kappa)
