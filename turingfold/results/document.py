"""scene.json and body.npz: what a result was made from, every part and value, seed, versions, date."""

from __future__ import annotations

import json
import platform
import reprlib
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ..scene import Scene
from .codec import Arrays, decode, encode
from .files import CorruptFileError, digest, read_arrays, read_json, unsigned

FORMAT = 3
OWN = __name__.split(".")[0]
PACKAGES = (OWN, "numpy", "scipy", "scikit-fem", "ipctk", "cvxopt")


def stored(scene: Scene, case: Mapping[str, Any] | None = None) -> tuple[dict[str, Any], Arrays]:
    """Return the content of scene.json and body.npz; case: what the scene comes from, if from a case."""
    arrays: Arrays = {}
    encoded = encode(scene, arrays)
    document = {
        "format": FORMAT,
        **({"case": dict(case)} if case else {}),
        "scene": encoded,
        "arrays": {"file": "body.npz", "sha256": digest(arrays)},
    }
    return document, arrays


def origin() -> dict[str, Any]:
    """Return when a result is made and with which versions, which scene.json says, too."""
    versions = {"python": platform.python_version(), "machine": platform.machine(), **installed()}
    return {"date": datetime.now(UTC).isoformat(timespec="seconds"), "versions": versions}


def read_scene(path: Path, known: Iterable[Any] = ()) -> Scene:
    """Return the scene a folder was made from; `known` as in `codec.decode`.

    Raises ValueError if there is none, or one that cannot be rebuilt, CorruptFileError if it is damaged.
    """
    document = read_document(path)
    try:
        return rebuilt(document, read_body(path, document), known)
    except CorruptFileError as error:
        raise CorruptFileError(f"{path / 'scene.json'}: {error}") from error


def read_document(path: Path) -> dict[str, Any]:
    """Return the content of scene.json; raises as `read_scene`."""
    file = path / "scene.json"
    if not file.exists():
        raise ValueError(f"{path} holds no result (there is no scene.json); name the folder of one scene.")
    document = read_json(file)
    if document.get("format") != FORMAT:
        versions = document.get("versions")
        wrote = versions.get(OWN, "unknown") if isinstance(versions, dict) else "unknown"
        found = reprlib.repr(document.get("format"))
        raise ValueError(
            f"{path} has format {found}, written by {OWN} {wrote}, and this version reads format {FORMAT}; "
            "install that version, or run the scene again (overwrite=True, --overwrite)."
        )
    try:
        return unsigned(document, file)
    except CorruptFileError as error:
        raise CorruptFileError(
            f"{error} Put back what it said, or run the scene again (overwrite=True, --overwrite)."
        ) from error


def read_body(path: Path, document: Mapping[str, Any]) -> Arrays:
    """Return the arrays that belong to a document; raises CorruptFileError where they do not."""
    arrays = read_arrays(path / "body.npz")
    if document["arrays"] != {"file": "body.npz", "sha256": digest(arrays)}:
        raise CorruptFileError(f"{path / 'body.npz'} does not belong to the scene.json beside it.")
    return arrays


def rebuilt(document: Mapping[str, Any], arrays: Arrays, known: Iterable[Any] = ()) -> Scene:
    """Return the scene that was `stored`; raises as `decode`, and where that is none."""
    scene = decode(document.get("scene"), arrays, known)
    if not isinstance(scene, Scene):
        raise CorruptFileError("it describes no scene.")
    return scene


def difference(old: Any, new: Any, ignoring: Sequence[str] = (), name: str = "") -> str:
    """Return the first place where two JSON values differ, as text; "" where they do not.

    ignoring: places that may differ, such as "scene.stepping.seconds".
    """
    if isinstance(old, dict) and isinstance(new, dict):
        for key in [*old, *(k for k in new if k not in old)]:
            path = f"{name}.{key}" if name else key
            found = "" if path in ignoring else difference(old.get(key), new.get(key), ignoring, path)
            if found:
                return found
        return ""
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = enumerate(zip(old, new, strict=True))
        return next((d for k, (a, b) in pairs if (d := difference(a, b, ignoring, f"{name}[{k}]"))), "")
    return "" if old == new else f"{name} was {_short(old)} and is {_short(new)}"


def _short(value: Any) -> str:
    if isinstance(value, list) and all(isinstance(item, dict) and "class" in item for item in value):
        return f"({', '.join(item['class'].rpartition('.')[2] for item in value)})"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "..."


def installed() -> dict[str, str]:
    """Return the versions of the packages that results may depend on, of those that are installed."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
