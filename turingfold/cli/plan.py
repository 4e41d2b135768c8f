"""What a command is to run: scenes with their names, parameters and folders."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..geometry.changes import OutlineWarning
from ..models.declared import as_text, find
from ..results.files import read_json
from ..scene import Scene
from ..studies.sweep import is_part, read_values, varied
from .case import Case, check_apart, folder_name
from .notes import note_made
from .request import Request


@dataclass(frozen=True)
class Planned:
    """One scene to run.  provenance: what is stored of the case."""

    name: str
    scene: Scene
    provenance: Mapping[str, Any] = field(default_factory=dict)


def given_values(case: Case, request: Request) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the values that the request sets: of the case's parameters, and as text of parts of its scenes.

    Raises ValueError for unknown names, for values out of range or of another kind, and for names set twice.
    """
    own: dict[str, Any] = {}
    parts: dict[str, str] = {}
    for name, text in request.assigned:
        if name in own or name in parts:
            raise ValueError(f"{name} is set twice; set it once.")
        if is_part(name):
            parts[name] = text
        else:
            own[name] = find(case.parameters, name).read(text)
    return own, parts


def planned(case: Case, request: Request) -> list[Planned]:
    """Return the scenes of a case as the request sets their parameters.

    Raises ValueError for scenes that it does not have.
    """
    own, parts = given_values(case, request)
    warnings.simplefilter("ignore", OutlineWarning)  # it is noted with all else that was changed
    every = case.scenes(own, quick=request.quick)
    check_apart(every, case.path)
    if unknown := [name for name in request.only if name not in every]:
        names = ", ".join(map(repr, every))
        raise ValueError(f"{case.shown} has no scene {unknown[0]!r}; it has: {names}.")
    provenance = case.provenance(own, quick=request.quick)
    provenance |= {"scenes": list(every), "command": request.words()}
    if parts:
        provenance["parts"] = parts
    chosen = {name: scene for name, scene in every.items() if not request.only or name in request.only}
    note_made(case, own, chosen, quick=request.quick)
    return [
        Planned(name, _with_parts(name, scene, parts), provenance | {"scene": name})
        for name, scene in chosen.items()
    ]


def _with_parts(name: str, scene: Scene, parts: Mapping[str, str]) -> Scene:
    for parameter, text in parts.items():
        try:
            values = read_values(text, scene, parameter)
            if len(values) != 1:
                raise ValueError(f"{parameter}={text} lists {len(values)} values; set one, or sweep --vary.")
            (scene,) = varied(scene, {parameter: values}).values()
        except ValueError as error:
            raise ValueError(f"scene {name!r}: {error}") from error
    return scene


def base_folder(case: Case, request: Request) -> Path:
    """Return the folder of a case's results: DIR/<case>, by default in results or results/quick."""
    out = request.out or (Path("results/quick") if request.quick else Path("results"))
    command = request.command[0]
    return out / (case.name if command == "run" else f"{case.name}-{command}")


def has_result(base: Path, name: str) -> bool:
    """Return whether a folder holds a state of a scene."""
    return any((base / folder_name(name) / "states").glob("*.npz"))


def stored_names(case: Case, base: Path) -> tuple[list[str], bool]:
    """Return the scenes that results of a case in a folder are of, and whether their parameters were changed.

    No names where none says so: then they are those of the case.
    """
    found = [read_json(file).get("case", {}) for file in sorted(base.glob("*/scene.json"))]
    known = [one for one in found if one.get("name") == case.name]
    changed = any(one.get("changed") or one.get("parts") for one in known)
    return (list(known[0].get("scenes", ())) if known else []), changed


def changed_words(provenance: Mapping[str, Any]) -> str:
    """Return the parameters that differ from the case's own, as text; "" if none does."""
    values = provenance.get("parameters", {})
    words = [f"{name}={as_text(values[name])}" for name in provenance.get("changed", ())]
    return ", ".join(words + [f"{name}={text}" for name, text in provenance.get("parts", {}).items()])


def without_result(base: Path, names: Sequence[str]) -> list[str]:
    """Return the scenes of which a folder holds no result."""
    return [name for name in names if not has_result(base, name)]
