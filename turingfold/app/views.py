"""What a page draws of a stored result: its mesh, the fields of its states, and its numbers over time."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from ..growth.ages import ages_of
from ..results.document import read_scene
from ..results.files import CorruptFileError
from ..results.history import read_history
from ..results.identity import Identity
from ..results.loading import read_result
from ..results.measures import sulci_of
from ..results.reading import state_of
from ..results.units import length_unit, stress_unit
from ..results.vtu import arrays_of
from ..scene import Scene

NOT_DRAWN = ("points", "triangles", "layer", "cauchy_stress")  # by a frame: the same in all, or not at all
CURVES = ("time", "growth", "gyrification_index", "energy", "min_gap", "seconds")


class Views:
    """Reads results for pages, and remembers the scenes and numbers that it read last."""

    def __init__(self) -> None:
        self._scene = lru_cache(16)(_scene)
        self._identity = lru_cache(16)(_identity)
        self._numbers = lru_cache(4096)(self._measured)
        self._drawing = Lock()  # matplotlib draws one picture at a time

    def scene(self, folder: Path, known: tuple[Any, ...]) -> Scene:
        """Return the scene of a result; raises ValueError where it cannot be rebuilt."""
        return self._scene(folder, known, (folder / "scene.json").stat().st_mtime_ns)

    def identity(self, folder: Path) -> Identity:
        """Return the run of a result; raises ValueError where its scene.json is damaged."""
        return self._identity(folder, (folder / "scene.json").stat().st_mtime_ns)

    def progress(self, folder: Path, known: tuple[Any, ...]) -> dict[str, Any]:
        """Return how far a result is: columns of its history, its frames with numbers, and its units."""
        scene, rows = self.scene(folder, known), read_history(folder, self.identity(folder))
        body = scene.body
        frames = [self._numbers(folder, known, step, stamp) for step, stamp in _steps(folder)]
        return {
            "until": scene.until,
            "mirror": body.mirror,
            "thickness": body.thickness,
            "length": length_unit(body),
            "stress": stress_unit(scene),
            "curves": {name: [_number(row.get(name)) for row in rows] for name in CURVES},
            "frames": [frame for frame in frames if frame],
        }

    def _measured(self, folder: Path, known: tuple[Any, ...], step: int, stamp: int) -> dict[str, Any] | None:
        """Return time, age, number of folds and their mean depth of a kept state; None of a damaged one."""
        scene = self.scene(folder, known)
        body, identity = scene.body, self.identity(folder)
        try:
            rows = read_history(folder, identity)
            state = state_of(folder / "states" / f"{step:06d}.npz", identity, rows)
        except CorruptFileError:
            return None
        folds, depth = sulci_of(body, state["displacement"])
        ages = ages_of(scene.processes)
        label = ages.label(state.time) if ages else ""
        numbers = {"folds": folds, "sulcal_depth": _number(depth)}
        return {"step": step, "time": state.time, "label": label, **numbers}

    def mesh(self, folder: Path) -> bytes:
        """Return the undeformed nodes (n, 3) and quadratic triangles (e, 6), `packed`."""
        step, _ = next(_steps(folder), (0, 0))
        found = arrays_of(_frame(folder, step))
        return packed({name: found[name] for name in ("points", "triangles", "layer")})

    def frame(self, folder: Path, step: int) -> bytes:
        """Return the fields of a state, at nodes (n, ...) or in triangles (e,), `packed`."""
        found = arrays_of(_frame(folder, step))
        return packed({name: found[name] for name in found if name not in NOT_DRAWN})

    def section(self, folder: Path, known: tuple[Any, ...], step: int, field: str) -> bytes:
        """Return a picture of a state as PDF; field: as in `figures.section`."""
        from matplotlib.figure import Figure

        from ..figures.sections import measures, section

        result, steps = read_result(folder, known=known), [number for number, _ in _steps(folder)]
        if step not in steps or len(steps) > len(result.states):
            raise ValueError(f"there is no state of step {step}.")
        with self._drawing:
            figure, out = Figure(figsize=(8, 5), layout="constrained"), io.BytesIO()
            axes = figure.add_subplot()
            section(axes, result, steps.index(step), field=field)
            if step == steps[-1]:
                axes.set_title(measures(result))
            figure.savefig(out, format="pdf")
        return out.getvalue()


def frames_archive(folder: Path) -> bytes:
    """Return the frames for ParaView and their index as a ZIP file."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for file in [folder / "frames.pvd", *sorted((folder / "frames").glob("*.vtu"))]:
            if file.is_file() and not file.is_symlink():
                archive.writestr(str(file.relative_to(folder)), file.read_bytes())
    return out.getvalue()


def packed(arrays: Mapping[str, np.ndarray[Any, Any]]) -> bytes:
    """Return arrays as bytes: the length of a JSON header (uint32), the header, and the numbers.

    The header has name, shape and kind ("f": float32, "u": uint32) of each array, in the order of the
    numbers; all is little-endian, and the numbers begin at a multiple of four.
    """
    kinds = {name: "u" if np.issubdtype(array.dtype, np.integer) else "f" for name, array in arrays.items()}
    entries = [{"name": n, "shape": array.shape, "kind": kinds[n]} for n, array in arrays.items()]
    header = json.dumps(entries).encode()
    header += b" " * (-len(header) % 4)
    numbers = [np.ascontiguousarray(array, f"<{kinds[n]}4").tobytes() for n, array in arrays.items()]
    return b"".join([len(header).to_bytes(4, "little"), header, *numbers])


def _steps(folder: Path) -> Iterator[tuple[int, int]]:
    """Return an iterator of the steps that have both a state and a frame, and when these were written."""
    for file in sorted((folder / "states").glob("*.npz")):
        frame = folder / "frames" / f"{file.stem}.vtu"
        if file.stem.isdecimal() and frame.is_file() and not (frame.is_symlink() or file.is_symlink()):
            yield int(file.stem), file.stat().st_mtime_ns


def _frame(folder: Path, step: int) -> Path:
    file = folder / "frames" / f"{step:06d}.vtu"
    if file.is_symlink():
        raise CorruptFileError(f"{file} is a link.")
    return file


def _scene(folder: Path, known: tuple[Any, ...], stamp: int) -> Scene:
    return read_scene(folder, known)


def _identity(folder: Path, stamp: int) -> Identity:
    return Identity.at(folder)


def _number(value: Any) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None
