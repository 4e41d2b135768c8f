"""Words for loads that are far beyond the stiffness of the body they act on: mistakes of units."""

from __future__ import annotations

from ..geometry.body import Body

FAR = 20.0  # times the stiffness: more is a mistake of units


def of_line(what: str, force: float, body: Body, shear_modulus: float) -> str:
    """Return words for a force or line tension (N/m) far beyond μT, or "" for one that is not."""
    scale = shear_modulus * body.thickness
    return _words(what, force, scale, "N/m", "modulus times thickness of the cortex")


def of_stress(what: str, stress: float, shear_modulus: float) -> str:
    """Return words for a traction or stress (Pa) far beyond μ, or "" for one that is not."""
    return _words(what, stress, shear_modulus, "Pa", "modulus")


def _words(what: str, value: float, scale: float, unit: str, of: str) -> str:
    if abs(value) <= FAR * scale:
        return ""
    return (
        f"{what}={value:g} {unit} is {abs(value) / scale:.3g} times the shear {of} ({scale:.3g} {unit}): no "
        "tissue withstands that"
    )
