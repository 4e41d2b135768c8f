"""Points of a study: values of a case's parameters, from which a scene is made where it is run.

A point is small, so that thousands can be listed and sent to other machines. Its folder holds a record of how
it ended, point.json: by that, a study that was stopped goes on, and its table is collected.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import SolveError
from ..results.files import CorruptFileError, json_content, read_json, unsigned, write_whole
from ..results.folder import prune
from ..results.result import Result, Row
from ..results.simulate import FRAMES, StoppedError, simulate
from ..scene import Scene
from ..studies.sweep import with_value
from .case import Case, load_case
from .files import short
from .outcome import Outcome
from .request import Running

RECORD = "point.json"
KEEP = ("summary", "last", "all")
DONE = ("converged", "invalid")  # and not to be run again


class ChangedCaseError(RuntimeError):
    """A case that was changed while a study of it runs: its points would be of different cases."""


@dataclass(frozen=True)
class Point:
    """One scene of a case with values of parameters, and where what comes of it is kept.

    every: names of the scenes that the case has with these values.  given: values of the case's parameters.
    parts: values of parts of the scene.  varied: those that the study varies, of both kinds.
    keep: "summary", the record alone; "last", the last state; "all", the kept states and their frames.
    running, command: how it is run, and by which command line.  refused: why there can be no such scene.
    """

    case: Path
    sha256: str
    name: str
    scene: str
    every: tuple[str, ...]
    given: Mapping[str, Any]
    parts: Mapping[str, Any]
    varied: Mapping[str, Any]
    folder: Path
    quick: bool = False
    keep: str = "last"
    running: Running = Running()  # noqa: RUF009 - frozen
    command: str = ""
    refused: str = ""

    @property
    def identity(self) -> str:
        """The SHA-256 of all that the result of the point depends on."""
        own = [self.sha256, self.scene, self.quick, sorted(self.given.items()), sorted(self.parts.items())]
        return hashlib.sha256(json.dumps(own).encode()).hexdigest()


def is_taken(folder: Path) -> bool:
    """Return whether a folder holds a result, perhaps of another point."""
    return (folder / "scene.json").exists() or read_record(folder).get("status") not in (None, "refused")


def read_record(folder: Path, identity: str | None = None) -> dict[str, Any]:
    """Return the record in a folder; empty where there is none, a damaged one, or one of another point."""
    file = folder / RECORD
    if not file.is_file():
        return {}
    try:
        found = unsigned(read_json(file), file)
    except CorruptFileError:
        return {}
    return found if identity in (None, found.get("identity")) else {}


class Maker:
    """Makes the scenes of points; it keeps the case and the scenes made last, which neighbours share."""

    def __init__(self, case: Case | None = None) -> None:
        self._case = case
        self._made: tuple[dict[str, Any], bool] | None = None
        self._scenes: dict[str, Scene] = {}

    @property
    def latest(self) -> dict[str, Scene]:
        """The scenes made last."""
        return self._scenes

    def scenes(self, case: Case, given: Mapping[str, Any], *, quick: bool) -> dict[str, Scene]:
        """Return the scenes of a case with some parameters given."""
        wanted = dict(given), quick
        if case is not self._case or wanted != self._made:
            self._made, self._scenes = None, {}  # the old ones go before the new ones come
            self._scenes = case.scenes(given, quick=quick)
            self._case, self._made = case, wanted
        return self._scenes

    def made(self, point: Point) -> tuple[Scene, dict[str, Any]]:
        """Return the scene of a point, and what is stored of the case with its result.

        Raises ValueError where there can be none, ChangedCaseError where the case is another one by now.
        """
        if point.refused:
            raise ValueError(point.refused)
        case = self._case
        if case is None or case.path != point.case:
            case = load_case(point.case)
        if case.sha256 != point.sha256:
            changed = f"{short(point.case)} was changed since the study began"
            raise ChangedCaseError(f"{changed}; begin another one.")
        every = self.scenes(case, point.given, quick=point.quick)
        if tuple(every) != point.every:
            raise ValueError(
                f"the case has the scenes {', '.join(every)} with these values and {', '.join(point.every)} "
                "with others; vary what changes its scenes in sweeps of their own."
            )
        scene = every[point.scene]
        for parameter, value in point.parts.items():
            scene = with_value(scene, parameter, value)
        scene = point.running.limited(scene)
        provenance = case.provenance(point.given, quick=point.quick)
        provenance |= {"scenes": list(every), "scene": point.scene, "command": point.command}
        return scene, provenance | ({"parts": dict(point.parts)} if point.parts else {})


def run_point(
    point: Point, maker: Maker | None = None, progress: Callable[[Row], object] | None = None
) -> Outcome:
    """Run a point, keep what is to be kept of it, and return how it ended; it has no row only if killed.

    An earlier run of the same point that was interrupted is gone on with. Raises OSError where writing fails.
    """
    (point.folder / RECORD).unlink(missing_ok=True)
    status, message, summary = "refused", "", {}
    try:
        scene, provenance = (maker or Maker()).made(point)
        result = _result(point, scene, provenance, progress)
        status, message, summary = result.status, result.message, result.summary()
    except StoppedError as error:
        status, message, summary = "stopped", str(error), error.result.summary()
    except SolveError as error:  # before the first state
        status, message = "stopped", str(error)
    except ValueError as error:
        message = str(error)
    except MemoryError as error:
        status, message = "stopped", f"memory is over ({error}); use larger elements, or fewer jobs."
    except OSError:
        raise
    except Exception as error:  # of a part of the user's own, or a fault of ours: the other points go on
        return Outcome(point.name, "failed", f"{type(error).__name__}: {error}")
    _record(point, status, message, summary)
    return Outcome(point.name, status, message, summary)


def _result(
    point: Point, scene: Scene, provenance: Mapping[str, Any], progress: Callable[[Row], object] | None
) -> Result:
    if point.keep == "summary":
        return simulate(scene, progress=progress, errors=False)
    running = point.running
    return simulate(
        scene, point.folder, progress=progress, resume=not running.overwrite, overwrite=running.overwrite,
        case=provenance, frames=frames_of(point.keep, running) or 1, vtu=running.vtu, errors=False,
    )  # fmt: skip


def frames_of(keep: str, running: Running) -> int | None:
    """Return how many evenly spaced states of a point are kept; None for the last one alone."""
    return (running.frames or FRAMES) if keep == "all" else None


def _record(point: Point, status: str, message: str, summary: Mapping[str, Any]) -> None:
    if point.keep != "all" and (status in DONE or point.keep == "summary"):
        prune(point.folder, last=point.keep == "last")
    record = {
        "name": point.name, "identity": point.identity, "varied": dict(point.varied), "status": status,
        "message": message, "summary": summary,
    }  # fmt: skip
    write_whole(point.folder / RECORD, json_content(record, signed=True))
