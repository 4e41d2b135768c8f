"""Units in which lengths and stresses of a scene are shown."""

from __future__ import annotations

import math

from ..geometry.body import Body
from ..scene import Scene, stress_scale

BRAIN = 0.5  # m; a body longer than this is no brain in metres, but one in units of its own
UNITS_THEMSELVES = ("seconds",)
UNSEEN = 1e-4  # smaller errors do not show in four decimals; they are said to be that
MEASURES = {  # units in SI of what is stored, tabulated or measured and is no pure number, by name
    **dict.fromkeys(("displacement", "min_gap", "perimeter", "sulcal_depth", "least_fold_depth"), "m"),
    **dict.fromkeys(("normal_displacement", "fold_amplitude"), "m"),
    **dict.fromkeys(("von_mises", "pressure", "contact_pressure", "cauchy_stress"), "Pa"),
    **dict.fromkeys(("energy", "kinetic_energy", "drag_work", "damping_work"), "J/m"),
    "holding_force": "N/m",
    "seconds": "s",
}
PARAMETERS = {  # of parts, by the end of their names
    "mu": "Pa", "kappa": "Pa", "Body.thickness": "m", "Inertia.density": "kg/m³", "ActiveStress.stress": "Pa",
}  # fmt: skip
TISSUE = 10.0  # Pa; no tissue is softer, so smaller moduli are not in Pa, but in units of their own


def with_unit(name: str, unit: str) -> str:
    """Return a name with its unit, "pressure [Pa]"; as it is without one, and where it says it."""
    return name if not unit or name in UNITS_THEMSELVES else f"{name} [{unit}]"


def without_unit(name: str) -> tuple[str, str]:
    """Return the name and the unit, "" for none, of `with_unit`."""
    plain, bracket, unit = name.partition(" [")
    return (plain, unit[:-1]) if bracket and unit.endswith("]") else (name, "")


def length_unit(body: Body) -> tuple[float, str]:
    """Return the unit that lengths of a body are shown in, and its name.

    That is 1e-3 m, "mm"; for a body in units of its own, longer than 0.5, the cortical thickness, "T".
    """
    return (body.thickness, "T") if body.length > BRAIN else (1e-3, "mm")


def stress_unit(scene: Scene) -> tuple[float, str]:
    """Return the unit that stresses of a scene are shown in, and its name.

    That is 1e3 Pa, "kPa"; for moduli that are no tissue's in Pa, the largest below 10, 1 without a name.
    """
    return (1e3, "kPa") if stress_scale(scene.terms) >= TISSUE else (1.0, "")


def is_si(scene: Scene) -> bool:
    """Return whether lengths and stresses of a scene are in m and Pa, by their size."""
    return scene.body.length <= BRAIN and bool(stress_unit(scene)[1])


def stored_unit(scene: Scene, name: str) -> str:
    """Return the unit in which a field, a number or a measure of a scene is stored: m, Pa or J/m.

    None of pure numbers, of times, which are the scene's, and in scenes with units of their own.
    """
    return measure_unit(name) if is_si(scene) else ""


def measure_unit(name: str) -> str:
    """Return the unit in SI of a field, a number or a measure; "" of pure numbers and of times."""
    return MEASURES.get(name, "")


def parameter_unit(name: str) -> str:
    """Return the unit of a parameter of a part in SI, of those that always have the same one; else ""."""
    if ".kinetics." in f".{name}":  # rates of reactions, which are pure numbers, have the same letters
        return ""
    return next((unit for end, unit in PARAMETERS.items() if f".{name}".endswith(f".{end}")), "")


def with_error(number: float, error: float | None) -> str:
    """Return a number with its error, to the first digit of that: "1.44 ± 0.03".

    error: None where nothing tells it, "1.44 ± ?"; 0 of a number that has none, "1.44".
    """
    if error is None or not math.isfinite(error):
        return f"{number:.2f} ± ?"
    if error == 0:
        return f"{number:.2f}"
    if error < UNSEEN:
        return f"{number:.4f} ± {UNSEEN:.4f}"
    decimals = max(0, -math.floor(math.log10(1.05 * error)))
    return f"{number:.{decimals}f} ± {error:.{decimals}f}"
