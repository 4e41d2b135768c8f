"""A scene as plain JSON and arrays, and back; nothing that is stored can run code when it is read.

A dataclass becomes {"class": "turingfold.TangentialGrowth", "cortex": 1.9, ...}, by its public name, wherever
it is defined; an array {"array": name} with its numbers in a table of arrays, a function {"function": path}.
Reading makes only the public dataclasses of turingfold and what the caller names.
"""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, fields, is_dataclass
from importlib import import_module
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri2

from .files import CorruptFileError

Arrays = dict[str, NDArray[Any]]

OWN = __name__.split(".")[0]
PATH = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+")
DEEPEST = 30  # levels of a stored scene; those that are written have fewer than 10
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


def decode(
    stored: Any, arrays: Mapping[str, NDArray[Any]], known: Iterable[Any] = (), place: str = "scene"
) -> Any:
    """Return what `encode` was given; lists come back as tuples.

    known: dataclasses and functions outside turingfold that may be made, found by their module and name.
    place: what messages call the value.
    Raises ValueError for any other class or function, CorruptFileError for what cannot be made.
    """
    table = {_path(item, "known"): item for item in known}
    return _Reading(arrays, table).value(stored, place, DEEPEST)


@dataclass(frozen=True)
class _Reading:
    """What reading a stored value needs: the arrays, and what the caller names."""

    arrays: Mapping[str, NDArray[Any]]
    table: Mapping[str, Any]

    def value(self, stored: Any, place: str, deeper: int) -> Any:
        """Return a stored value; `deeper` levels may follow."""
        if not deeper:
            raise CorruptFileError(f"{place} is nested too deeply.")
        if isinstance(stored, list):
            items = enumerate(stored)
            return tuple(self.value(item, f"{place}[{k}]", deeper - 1) for k, item in items)
        if not isinstance(stored, dict):
            return stored
        match stored:
            case {"class": str(path)}:
                made = _class(path, self.table, place)
                parts = {name: part for name, part in stored.items() if name != "class"}
                own = {k: self.value(part, f"{place}.{k}", deeper - 1) for k, part in parts.items()}
                _check_fields(path, made, own, place)
                with _made_of(place):
                    return made(**own)
            case {"float": str(word)} if word in SPECIAL:
                return SPECIAL[word]
            case {"array": str(name)} if name in self.arrays:
                return self.arrays[name]
            case {"mesh": dict(names)}:
                with _made_of(place):
                    return _mesh(names, self.arrays)
            case {"function": str(path)}:
                return _function(path, self.table, place)
        raise CorruptFileError(f"{place} is {reprlib.repr(stored)}, which this program does not write.")


@contextmanager
def _made_of(place: str) -> Iterator[None]:
    """Name the place of whatever goes wrong when something is made of stored values."""
    try:
        yield
    except Exception as error:  # whatever a class makes of values that are not meant for it
        raise CorruptFileError(f"{place} cannot be made: {error or type(error).__name__}") from error


def _check_fields(path: str, made: Any, parts: Mapping[str, Any], place: str) -> None:
    """Refuse fields that the class does not have; what came later and has a default may be missing."""
    own = [f for f in fields(made) if f.init]
    needed = {f.name for f in own if f.default is MISSING and f.default_factory is MISSING}
    wrong = (set(parts) - {f.name for f in own}) | (needed - set(parts))
    if wrong:
        raise ValueError(
            f"{place}: the stored {path} and the installed one differ in the fields: "
            f"{', '.join(sorted(wrong))}. The result is of another version (scene.json names it); run the "
            "scene again."
        )


def _path(item: Any, name: str) -> str:
    """Return the name that a class or function is stored by; one of our own must be public."""
    path = f"{item.__module__}.{item.__qualname__}"
    if _public(item.__name__) is item:
        return f"{OWN}.{item.__name__}"
    if not PATH.fullmatch(path) or path.startswith(f"{OWN}."):
        raise ValueError(
            f"{name}: {path} could not be found when the results are read; define it at the top of a module."
        )
    return path


def _public(name: str) -> Any:
    """Return the public dataclass of a name, or None."""
    package = import_module(OWN)
    found = getattr(package, name) if name in package.__all__ else None
    return found if isinstance(found, type) and is_dataclass(found) else None


def _class(path: str, table: Mapping[str, Any], place: str) -> Any:
    package, _, name = path.rpartition(".")
    found = table.get(path) or (_public(name) if package == OWN else None)
    if not (isinstance(found, type) and is_dataclass(found)):
        raise _unknown(path, place)
    return found


def _function(path: str, table: Mapping[str, Any], place: str) -> Any:
    """Return a function that the caller names; no other is ever found."""
    if not isinstance(table.get(path), FunctionType):
        raise _unknown(path, place)
    return table[path]


def _unknown(path: str, place: str) -> ValueError:
    return ValueError(
        f"{place}: the stored scene uses {path}, which is not part of this version of {OWN}; "
        "pass the class or function itself: load(folder, known=(...,)); on the command line, --with "
        "FILE.py names the file that defines it."
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
    nodes, triangles = arrays[stored["nodes"]], arrays[stored["triangles"]]
    stem = stored["nodes"].removesuffix(".nodes")
    named = {
        f"_{kind}": {part: arrays[f"{stem}.{kind}.{part}"] for part in stored[kind]}
        for kind in ("boundaries", "subdomains")
    }
    mesh = MeshTri2(nodes, triangles, validate=False, **named)
    for members, count in (
        ((triangles,), mesh.nvertices),
        (named["_boundaries"].values(), mesh.nfacets),
        (named["_subdomains"].values(), mesh.nelements),
    ):
        if any(item.size and not 0 <= item.min() <= item.max() < count for item in members):
            raise ValueError("the mesh names nodes, edges or triangles that it does not have")
    return mesh
