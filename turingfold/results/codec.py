"""A scene as plain JSON and arrays, and back; nothing that is stored can run code when it is read.

A dataclass becomes {"class": "turingfold.growth.TangentialGrowth", "cortex": 1.9, ...}, an array
{"array": name} with its numbers in a table of arrays, a function {"function": path}. Reading makes only the
dataclasses of turingfold itself and what the caller names.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from importlib import import_module
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri2

Arrays = dict[str, NDArray[Any]]

OWN = __name__.split(".")[0]
PATH = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+")
SPECIAL = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


def encode(value: Any, arrays: Arrays, name: str = "scene") -> Any:
    """Return `value` as what JSON can hold; its arrays are added to `arrays` under their names.

    Raises ValueError for what cannot be written down, such as a function without a name of its own.
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, (float, np.floating, np.integer)):
        number = value.item() if isinstance(value, np.generic) else value
        return number if math.isfinite(number) else {"float": str(float(number))}
    if isinstance(value, (tuple, list)):
        return [encode(item, arrays, f"{name}.{k}") for k, item in enumerate(value)]
    if isinstance(value, np.ndarray):
        arrays[name] = value
        return {"array": name}
    if isinstance(value, MeshTri2):
        return {"mesh": _mesh_arrays(value, arrays, name)}
    if is_dataclass(value) and not isinstance(value, type):
        own = [f.name for f in fields(value) if f.init]
        parts = {part: encode(getattr(value, part), arrays, f"{name}.{part}") for part in own}
        return {"class": _path(value.__class__, name), **parts}
    if isinstance(value, FunctionType):
        return {"function": _path(value, name)}
    raise ValueError(
        f"{name} is a {type(value).__name__}, which cannot be stored with the results; use numbers, texts, "
        "tuples, arrays, frozen dataclasses of these, or functions defined at the top of a module."
    )


def decode(stored: Any, arrays: Mapping[str, NDArray[Any]], known: Iterable[Any] = ()) -> Any:
    """Return what `encode` was given; lists come back as tuples.

    known: dataclasses and functions outside turingfold that may be made, found by their module and name.
    Raises ValueError for any other class or function, and for fields that do not suit the class.
    """
    table = {_path(item, "known"): item for item in known}
    return _decode(stored, arrays, table)


def _decode(stored: Any, arrays: Mapping[str, NDArray[Any]], table: Mapping[str, Any]) -> Any:
    if isinstance(stored, list):
        return tuple(_decode(item, arrays, table) for item in stored)
    if not isinstance(stored, dict):
        return stored
    match stored:
        case {"class": str(path)}:
            made = _known(path, table, type)
            parts = {k: _decode(v, arrays, table) for k, v in stored.items() if k != "class"}
            _check_fields(path, made, parts)
            return made(**parts)
        case {"float": str(word)} if word in SPECIAL:
            return SPECIAL[word]
        case {"array": str(name)} if name in arrays:
            return arrays[name]
        case {"mesh": dict(names)}:
            return _mesh(names, arrays)
        case {"function": str(path)}:
            return _known(path, table, FunctionType)
    raise ValueError(f"the stored scene holds {str(stored)[:80]}, which this program does not write.")


def _check_fields(path: str, made: Any, parts: Mapping[str, Any]) -> None:
    """Refuse fields that the class does not have; what came later and has a default may be missing."""
    own = [f for f in fields(made) if f.init]
    needed = {f.name for f in own if f.default is MISSING and f.default_factory is MISSING}
    wrong = (set(parts) - {f.name for f in own}) | (needed - set(parts))
    if wrong:
        raise ValueError(
            f"the stored {path} and the installed one differ in the fields: {', '.join(sorted(wrong))}. The "
            "result is of another version (scene.json names it); run the scene again."
        )


def _path(item: Any, name: str) -> str:
    path = f"{item.__module__}.{item.__qualname__}"
    if not PATH.fullmatch(path):
        raise ValueError(
            f"{name}: {path} could not be found when the results are read; define it at the top of a module."
        )
    return path


def _known(path: str, table: Mapping[str, Any], kind: type) -> Any:
    if path in table:
        return table[path]
    module, _, name = path.rpartition(".")
    if PATH.fullmatch(path) and module.startswith(OWN + "."):
        try:
            found = getattr(import_module(module), name, None)
        except ModuleNotFoundError:
            found = None
        # what a module imported from elsewhere is not its own
        own = isinstance(found, kind) and getattr(found, "__module__", "") == module
        if own and (kind is not type or is_dataclass(found)):
            return found
    raise ValueError(
        f"the stored scene uses {path}, which is not part of this version of {OWN}; "
        "pass the class or function itself: load(folder, known=(...,))."
    )


# meshes: node positions, triangles by their corners, and the named parts


def _mesh_arrays(mesh: MeshTri2, arrays: Arrays, name: str) -> dict[str, Any]:
    arrays[f"{name}.nodes"], arrays[f"{name}.triangles"] = mesh.doflocs, mesh.t
    stored: dict[str, Any] = {"nodes": f"{name}.nodes", "triangles": f"{name}.triangles"}
    for kind, parts in (("boundaries", mesh.boundaries or {}), ("subdomains", mesh.subdomains or {})):
        for part, members in parts.items():
            arrays[f"{name}.{kind}.{part}"] = np.asarray(members, dtype=np.int64)
        stored[kind] = sorted(parts)
    return stored


def _mesh(stored: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> MeshTri2:
    nodes = stored["nodes"]
    stem = nodes.removesuffix(".nodes")
    named = {
        f"_{kind}": {part: arrays[f"{stem}.{kind}.{part}"] for part in stored[kind]}
        for kind in ("boundaries", "subdomains")
    }
    return MeshTri2(arrays[nodes], arrays[stored["triangles"]], validate=False, **named)
