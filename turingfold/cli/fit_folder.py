"""Whether the result that a folder holds is one of a fit, which a fit that goes on may replace."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ..results.document import difference, read_document, stored
from ..results.identity import FREE
from ..scene import Scene
from ..sensitivity.parameters import changed_in

STOPS = "scene.stepping.stops"  # a fit that goes on may have other targets


def check_own(folder: Path, scene: Scene, to: Collection[str]) -> None:
    """Raise ValueError where a folder holds another result than one of a scene with fitted parameters.

    to: names of the parameters, whose values may be any.
    """
    if (folder / "scene.json").exists() and (other := _other(read_document(folder), scene, to)):
        raise ValueError(
            f"{folder} holds a result that is none of this fit: {other}. Go on with the scene and the "
            "parameters of that fit, choose another folder (--out DIR), or replace what is there "
            "(--overwrite)."
        )


def _other(document: Mapping[str, Any], scene: Scene, to: Collection[str]) -> str:
    """Return what makes a stored result another one, as text; "" if it is of the scene."""
    values = document.get("case", {}).get("fitted")
    if not isinstance(values, dict):
        return "it was not fitted"
    if set(values) != set(to):
        return f"it was fitted by {', '.join(values)}"
    for name, value in values.items():
        scene = changed_in(scene, name, value)
    return difference(document, stored(scene)[0], ignoring=(*FREE, STOPS))
