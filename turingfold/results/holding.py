"""Forces where nodes only hold a free body, or a part of it, in place: none unless something pushes on it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

from ..parts import Solid
from ..scene import Scene
from .callers import level_outside

SEEN = 1e-3  # of the least shear modulus times T: forces above this are told; round-off is below 1e-9


class HoldingForceWarning(UserWarning):
    """Nodes that only hold parts of the body in place carry what pushes on these parts."""


def holding_words(scene: Scene, force: float | None) -> str:
    """Return what to say of the largest force, N/m, at nodes that only hold parts in place, or nothing.

    It is measured by the softest tissue, which a force passes on its way from the surface to these nodes.
    """
    if force is None or not force > 0:
        return ""
    share = force / (_least_shear_modulus(scene) * scene.body.thickness)
    if not share > SEEN:
        return ""
    return (
        "what touches free parts of the body pushes them against the single nodes that hold each in place, "
        f"with up to {force:.2g} N/m ({share:.2g} of the least shear modulus times thickness): stresses "
        "there are the support's; with Drag(coefficient=...), small beside shear modulus / length², the "
        "parts move"
    )


def warn_of_holding(scene: Scene, before: Sequence[Mapping[str, float]], force: float) -> None:
    """Warn (HoldingForceWarning) of the first force of a run that is to be told; before: rows before it."""
    words = holding_words(scene, force)
    forces = (row.get("holding_force", 0.0) for row in before)
    largest = max((one for one in forces if one > 0), default=0.0)  # an empty cell, read back, is NaN
    if words and not holding_words(scene, largest):
        warnings.warn(words, HoldingForceWarning, stacklevel=level_outside())


def _least_shear_modulus(scene: Scene) -> float:
    """Return the least shear modulus of the body, or 1 Pa, the unit of stress, of one without solids; Pa."""
    moduli = [term.moduli(scene.body)[0] for term in scene.terms if isinstance(term, Solid)]
    return float(sum(moduli[1:], moduli[0]).min()) if moduli else 1.0
