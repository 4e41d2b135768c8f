"""Runs that pages start: each a command line in a process of its own, and a folder below one root.

    ROOT/20260131-142500-a1b2c3/run.json     case, scene, values and command
                               /log.txt      what the command complained of
                               /CASE/SCENE/  its result, see `results.folder`

Nothing is known of a run but what is in its folder: it outlives the page, and the server too.
"""

from __future__ import annotations

import json
import os
import platform
import re
import secrets
import shlex
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from threading import Lock
from typing import Any

from ..results.files import CorruptFileError, json_content, read_json, write_whole
from ..results.lock import writer
from ..results.reading import read_ending, read_summary
from .choices import Choice

RUN = re.compile(r"\d{8}-\d{6}-[0-9a-f]{6}")
SHOWN = 300  # runs in the list, the newest
PATIENCE = 20  # s that an interrupted run has to write down where it stands
TAIL = 4000  # bytes of what a run printed that are read
ASKED = {"case": str, "scene": str, "values": dict, "quick": bool, "began": str, "command": str}
NUMBERS = ("time", "gyrification_index", "folds", "sulcal_depth", "energy", "growth")


class UnknownRunError(LookupError):
    """There is no such run."""


class BusyError(ValueError):
    """As many runs as may be are under way."""


class NotStoppedError(OSError):
    """The system forbids this server to stop a run, which goes on."""


@dataclass(frozen=True)
class Run:
    """A run on disk: its folder, and what was asked for."""

    id: str
    folder: Path
    asked: Mapping[str, Any]

    @property
    def result(self) -> Path | None:
        """The folder of its result, once there is one; never one behind a link."""
        found = (file.parent for file in sorted(self.folder.glob("*/*/scene.json")))
        return next((path for path in found if not (path.is_symlink() or path.parent.is_symlink())), None)

    def complaint(self) -> str:
        """Return the error that its command ended with, "" if it told none but that it was stopped."""
        with suppress(OSError), (self.folder / "log.txt").open("rb") as file:
            file.seek(max(0, os.fstat(file.fileno()).st_size - TAIL))
            lines = file.read().decode(errors="replace").splitlines()
            first = next((k for k, line in enumerate(lines) if _is_error(line)), None)
            if first is not None:
                words = " ".join(lines[first:]).removeprefix("turingfold: ")
                return "" if words.startswith("stopped") else words
        return ""


def _read_asked(file: Path) -> dict[str, Any]:
    """Return what was asked of a run; raises CorruptFileError where the file does not say it."""
    asked = read_json(file)
    wrong = next((name for name, kind in ASKED.items() if type(asked.get(name)) is not kind), None)
    try:
        json.dumps(asked, allow_nan=False, ensure_ascii=False).encode()
    except ValueError as error:
        raise CorruptFileError(
            f"{file} cannot be shown ({error}); correct it, or start the run again."
        ) from error
    if wrong is not None:
        kind = {str: "a text", dict: "a table", bool: "true or false"}[ASKED[wrong]]
        found = json.dumps(asked[wrong])[:60] if wrong in asked else "missing"
        raise CorruptFileError(
            f'{file} is damaged: "{wrong}" must be {kind}, and is {found}; correct it, or start the run '
            "again."
        )
    return {name: asked[name] for name in ASKED}


def _is_error(line: str) -> bool:
    return line.startswith("turingfold: ") and not line.startswith("turingfold: note: ")


class Runs:
    """The runs below a root folder; raises ValueError where that is no folder, or is a link.

    most: runs at a time.
    """

    def __init__(self, root: Path, *, most: int) -> None:
        if root.is_symlink() or (root.exists() and not root.is_dir()):
            raise ValueError(f"folder={root} must be a folder, and no link; name another one.")
        root.mkdir(parents=True, exist_ok=True)
        self.root, self.most = root.resolve(), most
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._told: set[str] = set()  # to stop
        self._lock = Lock()

    def find(self, name: str) -> Run:
        """Return a run by its id; raises UnknownRunError, CorruptFileError where its run.json is damaged."""
        folder = self.root / name
        if RUN.fullmatch(name) and not folder.is_symlink() and (folder / "run.json").exists():
            return Run(name, folder, _read_asked(folder / "run.json"))
        raise UnknownRunError(f"there is no run {name[:40]!r}.")

    def listed(self) -> list[dict[str, Any]]:
        """Return the newest runs, newest first: what was asked for, how they stand, and their numbers."""
        found = []
        for name in sorted((path.name for path in self.root.iterdir()), reverse=True)[:SHOWN]:
            with suppress(UnknownRunError):
                found.append({"id": name, **self._in_list(name)})
        return found

    def _in_list(self, name: str) -> dict[str, Any]:
        try:
            run = self.find(name)
        except CorruptFileError as error:
            unknown = {key: kind() for key, kind in ASKED.items()}
            return {**unknown, "status": "damaged", "message": str(error)}
        status, message = self.status(run)
        return {**run.asked, "status": status, "message": message, **numbers(run)}

    def begin(self, choice: Choice, scene: str, values: Mapping[str, Any], *, quick: bool) -> str:
        """Start a run and return its id; raises ValueError for bad values, BusyError for too many runs."""
        changed = choice.changed(values, quick=quick)
        words = choice.words(scene, changed, quick=quick)
        now = datetime.now().astimezone()
        name = f"{now:%Y%m%d-%H%M%S}-{secrets.token_hex(3)}"
        asked = {
            "case": choice.name, "scene": scene, "values": changed, "quick": quick,
            "began": now.isoformat(timespec="seconds"), "command": shlex.join(["turingfold", *words]),
        }  # fmt: skip
        with self._lock:
            self._check_room()
            (self.root / name).mkdir()
            write_whole(self.root / name / "run.json", json_content(asked, signed=False))
            self._start(Run(name, self.root / name, asked), words)
        return name

    def resume(self, run: Run, choice: Choice) -> None:
        """Go on with a run that was stopped; raises ValueError for one that is under way or at its end."""
        asked = run.asked
        changed = choice.changed(asked["values"], quick=bool(asked["quick"]))
        words = choice.words(str(asked["scene"]), changed, quick=bool(asked["quick"]))
        with self._lock:  # of two that ask at once, the second finds it under way
            status, _ = self.status(run)
            if status not in ("interrupted", "stopped"):
                raise ValueError(f"the run is {status}; only one that was stopped can go on.")
            self._check_room()
            self._told.discard(run.id)
            self._start(run, [*words, "--resume"])

    def _check_room(self) -> None:
        # others that live have their result, and draw its figure
        busy = sum(self.status(run)[0] in ("starting", "running") for run in self._living())
        if busy >= self.most:
            raise BusyError(f"{busy} runs are under way, as many as may be here; wait, or stop one.")

    def _start(self, run: Run, words: Sequence[str]) -> None:
        command = [sys.executable, "-P", "-m", "turingfold", *words, "--out", str(run.folder)]
        with (run.folder / "log.txt").open("wb") as log:
            # a session or group of its own: Ctrl-C in the server's terminal is the server's, which then stops
            # its runs
            self._processes[run.id] = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
                start_new_session=True, creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )  # fmt: skip

    def status(self, run: Run) -> tuple[str, str]:
        """Return how a run stands, and what to know about it.

        "starting", "running", or its end: "refused" (bad input) or the status of a result.
        """
        result, alive = run.result, self._alive(run)
        if result is None:
            return ("starting", "") if alive else _unbegun(run)
        if writer(result):
            return "running", ""
        try:
            ending = read_ending(result)
        except ValueError as error:  # damage, or a format of another version
            return "damaged", str(error)
        if alive and ending.status in ("interrupted", "stopped"):  # it takes or gives back its lock
            return "running", ""
        if ending.status == "interrupted" and not any((result / "states").glob("*.npz")):
            return _unbegun(run)
        return ending.status, ending.message

    def _alive(self, run: Run) -> bool:
        process = self._processes.get(run.id)
        return process is not None and process.poll() is None

    def stop(self, run: Run) -> None:
        """Tell a run to stop, as Ctrl-C does: it writes down where it stands; a second time, end it.

        Raises NotStoppedError where the system forbids it.
        """
        process = self._process(run)
        if process is None:
            return
        try:
            _tell(process, again=run.id in self._told)
        except OSError as error:
            if self._process(run) == process:  # else it has ended meanwhile
                raise NotStoppedError(
                    f"the run goes on: the system forbids this server to stop its process {process} "
                    f"({error.strerror}); let the user who started it stop it, or wait until it has ended."
                ) from error
        self._told.add(run.id)

    def _process(self, run: Run) -> int | None:
        """Return the process of a run that is under way on this machine, perhaps of a server before this."""
        if self._alive(run):
            return self._processes[run.id].pid
        return None if run.result is None else _process(writer(run.result))

    def _living(self) -> list[Run]:
        return [run for name in self._processes if self._alive(run := Run(name, self.root / name, {}))]

    def close(self) -> None:
        """Stop the runs that this server has started, and wait until each has stored where it stands."""
        living = self._living()
        for run in living:
            with suppress(NotStoppedError):  # it goes on; the next server finds it
                self.stop(run)
        for run in living:
            with suppress(subprocess.TimeoutExpired):
                self._processes[run.id].wait(PATIENCE)


def _unbegun(run: Run) -> tuple[str, str]:
    """Return how a run stands that has ended without a state."""
    words = run.complaint()
    return ("refused", words) if words else ("interrupted", "It was stopped before its first state.")


def numbers(run: Run) -> dict[str, Any]:
    """Return the numbers that a list shows of a run that has ended."""
    if run.result is not None:
        with suppress(ValueError):
            summary = read_summary(run.result)
            return {name: summary.get(name) for name in NUMBERS}
    return {}


def _tell(process: int, *, again: bool) -> None:
    # Windows ends a process at any signal but Ctrl-Break, which the command line hears as Ctrl-C
    stop = getattr(signal, "CTRL_BREAK_EVENT", signal.SIGINT)
    os.kill(process, signal.SIGTERM if again else stop)


def _process(words: str) -> int | None:
    """Return the process that a lock names, if it is one of this machine: the lock is held, so it lives."""
    found = re.fullmatch(r"process (\d+) on (.*)", words)
    return int(found[1]) if found and found[2] == platform.node() else None
