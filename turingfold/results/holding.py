"""Forces where nodes only hold a free body, or a part of it, in place: none unless something pushes on it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

from ..scene import Scene, stress_scale

SEEN = 1e-3  # of the largest shear modulus times T: forces above this are told; round-off is below 1e-9


class HoldingForceWarning(UserWarning):
    """Nodes that only hold parts of the body in place carry what pushes on these parts."""


def holding_words(scene: Scene, force: float | None) -> str:
    """Return what to say of the largest force, N/m, at nodes that only hold parts in place, or nothing."""
    scale = stress_scale(scene.terms) * scene.body.thickness
    if force is None or not force > SEEN * scale:
        return ""
    return (
        "what touches free parts of the body pushes them against the single nodes that hold each in place, "
        f"with up to {force:.2g} N/m ({force / scale:.2g} of shear modulus times thickness): stresses there "
        "are the support's; with Drag(coefficient=...), small beside shear modulus / length², the parts move"
    )


def warn_of_holding(scene: Scene, before: Sequence[Mapping[str, float]], force: float) -> None:
    """Warn (HoldingForceWarning) of the first force of a run that is to be told; before: rows before it."""
    words = holding_words(scene, force)
    if words and not any(holding_words(scene, row.get("holding_force")) for row in before):
        warnings.warn(words, HoldingForceWarning, stacklevel=6)
