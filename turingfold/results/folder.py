"""The folder of one result: scene, history, summary, kept states, frames and checkpoints.

scene.json, body.npz       what was run: every part and value, seed, versions, date; can be run again
history.csv                a row per accepted step
summary.json               numbers of the last state, and how the run ended; none of a killed run
states/000012.npz          fields of the state after step 12, exactly; the last state is always there
frames/000012.vtu, frames.pvd   the same for ParaView
checkpoint-000012.npz      from which the run goes on bit for bit; the last two are kept
log.txt                    command, versions, progress, warnings, and how it ended, each with the time
.lock                      held by the process that writes here, and gone with it
"""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from functools import cached_property, partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SolveError
from ..scene import Scene, reached
from ..solve.march import Progress
from ..state import State
from .checkpoint import Checkpoint, to_arrays
from .codec import Arrays
from .document import difference, origin, read_body, read_document, stored
from .files import CorruptFileError, arrays_content, json_content, read_bytes, write_whole, writing
from .history import History, Row, run_of, sound_rows
from .identity import FREE, RUN, Identity
from .lock import NAME as LOCK
from .lock import FolderLock
from .log import NAME as LOG
from .log import append, warnings_to
from .reading import check_scene_is_own, checkpoint_of, state_of
from .units import stored_unit

if TYPE_CHECKING:
    from .vtu import Frames

KEPT_CHECKPOINTS = 2
SUBFOLDERS = ("states", "frames")
LEFT = (".*.part", "states/.*.part", "frames/.*.part")  # by a process that was killed while it wrote
# bytes for each triangle: of a state, of its frame, of two checkpoints, of what is there once
STATE_SIZE, FRAME_SIZE, CHECKPOINTS_SIZE, ONCE = 265, 178, 950, 65
MADE = ("history.csv", "summary.json", "frames.pvd", "checkpoint-*.npz", "states/*.npz", "frames/*.vtu")


class ResultFolder:
    """A folder that one run writes to, and no other process meanwhile; use it in a with statement.

    Raises ValueError if the folder holds another result or foreign files or is being written, OutputError if
    it cannot be written, is moved or removed, or has a link for a subfolder.
    """

    def __init__(
        self, path: Path, scene: Scene, *, resume: bool = False, overwrite: bool = False,
        case: Mapping[str, Any] | None = None, vtu: bool = True,
    ) -> None:  # fmt: skip
        """Claim the folder for a scene; case: see `document.stored`; vtu: whether states get frames."""
        self.path, self.scene, self._vtu = path, scene, vtu
        document, arrays = stored(scene, case)
        check_folder(path, document, resume=resume, overwrite=overwrite)
        with writing(path):
            path.mkdir(parents=True, exist_ok=True)
        with writing(path / LOCK):
            self._lock = FolderLock(path)
        self._times: dict[int, float] = {}  # of the frames, by step
        self._place = path.stat()
        self._within = ExitStack()
        try:
            check_folder(path, document, resume=resume, overwrite=overwrite)
            self._identity = self._claim(document, arrays, resume=resume)
            self._history = History(path / "history.csv", partial(stored_unit, scene), self._identity.run)
        except BaseException:
            self._lock.release()
            raise

    def __enter__(self) -> ResultFolder:
        """Return the folder, whose log from now on hears of warnings."""
        self._within.enter_context(warnings_to(self.log))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, place: TracebackType | None
    ) -> None:
        """Close the history and give the folder back; its log hears of an error that no run expects."""
        self._within.close()
        if kind is not None and not issubclass(kind, (SolveError, KeyboardInterrupt)):
            with suppress(OSError):
                self.log(f"ended by {kind.__name__}: {error}")
        self._history.close()
        self._lock.release()

    def _claim(self, document: dict[str, Any], arrays: Arrays, *, resume: bool) -> Identity:
        for name in SUBFOLDERS:
            self._check(self.path / name)
        self._clear(*LEFT)
        again = resume and (self.path / "scene.json").exists()
        if again:
            check_scene_is_own(self.path)
        else:
            self._clear("scene.json", LOG, *MADE)
        if not (again and self._has_body(document)):
            self._write("body.npz", arrays_content(arrays))
        if not again:
            described = document | origin() | {RUN: Identity.of(document).run}
            self._write("scene.json", json_content(described, signed=True))
        for name in SUBFOLDERS if self._vtu else SUBFOLDERS[:1]:
            with writing(self.path / name):
                (self.path / name).mkdir(exist_ok=True)
        return Identity.at(self.path)

    def _has_body(self, document: Mapping[str, Any]) -> bool:
        try:
            read_body(self.path, document)
        except CorruptFileError:
            return False
        return True

    def _check(self, place: Path) -> None:
        """Raise OutputError where the folder is no more the one that was claimed, or its part is a link."""
        with writing(place):
            if not os.path.samestat(self.path.stat(), self._place):
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
            if place != self.path and place.is_symlink():
                raise OSError(errno.ELOOP, "it is a link")

    def _write(self, name: str, content: bytes, *, lasting: bool = True) -> None:
        file = self.path / name
        self._check(file.parent)
        write_whole(file, content, make_folder=False, lasting=lasting)

    def _clear(self, *patterns: str, after: int = -1) -> None:
        """Remove files, numbered ones only of steps after one."""
        for old in [file for pattern in patterns for file in self.path.glob(pattern)]:
            if not old.stem.isdecimal() or int(old.stem) > after:
                self._check(old.parent)
                with writing(old):
                    old.unlink()

    # reading back

    def checkpoint(self) -> Checkpoint | None:
        """Return the newest checkpoint that is undamaged, and remove everything written after it.

        Without one nothing of the earlier run is left. Warns about what is damaged.
        """
        rows = self._sound_rows()
        for file in sorted(self.path.glob("checkpoint-*.npz"), reverse=True):
            try:
                found = checkpoint_of(file, self._identity, rows)
                if len(rows) < found.step:
                    raise CorruptFileError(f"{self._history.path} has lost the rows up to {file.name}.")
            except CorruptFileError as error:
                warnings.warn(f"{error} Going on from an older state.", stacklevel=2)
                self._clear(file.name)
                continue
            self._history.rows = rows[: found.step]
            self._history.rewrite()
            self._clear("states/*.npz", "frames/*.vtu", after=found.step)
            if not reached(self.scene, found.progress.state.time):
                self._clear("summary.json")  # from here on it is not what it says
            return found
        self._clear(*MADE)
        self._history.rewrite()
        return None

    def _sound_rows(self) -> list[Row]:
        file = self._history.path
        if not file.exists():
            return []
        try:
            rows, damage = sound_rows(content := read_bytes(file))
            if rows or not damage:
                self._identity.check(file, run_of(content))
        except CorruptFileError as error:
            warnings.warn(str(error), stacklevel=3)
            return []
        if damage:
            warnings.warn(f"{file}: {damage}.", stacklevel=3)
        return rows

    def kept(self, before: int) -> dict[int, State]:
        """Return the undamaged states that were kept before a step, and list the frames that are there.

        Warns about damaged ones.
        """
        states = {}
        for file in sorted(self.path.glob("states/*.npz")):
            if not file.stem.isdecimal() or int(file.stem) >= before:
                continue
            try:
                states[int(file.stem)] = state_of(file, self._identity, self._history.rows)
            except CorruptFileError as error:
                warnings.warn(str(error), stacklevel=2)
        frames = [file for file in self.path.glob("frames/*.vtu") if file.stem.isdecimal()]
        shown = {int(file.stem) for file in frames if self._is_own(file)}
        self._times = {step: state.time for step, state in states.items() if step in shown}
        return states

    def _is_own(self, frame: Path) -> bool:
        try:
            self._identity.check_comment(frame)
        except CorruptFileError:
            return False
        return True

    def lacks_frame(self, step: int) -> bool:
        """Return whether a step should have a frame and has none."""
        return self._vtu and step not in self._times

    def history(self) -> list[Row]:
        """Return the rows up to the checkpoint."""
        return [dict(row) for row in self._history.rows]

    # writing

    def log(self, text: str) -> None:
        """Add a line to the log."""
        self._check(self.path)
        append(self.path / LOG, text)

    def add_row(self, row: Row) -> None:
        """Append a row to the history, at once."""
        self._check(self.path)
        self._history.add(row)

    def add_state(self, step: int, state: State, observed: Mapping[str, NDArray[np.float64]]) -> None:
        """Keep a state, exactly and, where frames are wanted, as one for ParaView."""
        name = f"{step:06d}"
        kept = {"time": np.array(state.time), **state.fields}
        self._write(f"states/{name}.npz", arrays_content(self._identity.mark(kept)))
        if self._vtu:
            self._write(f"frames/{name}.vtu", self._frames.content(state, observed))
            self._times[step] = state.time
        self._write_index()

    @cached_property
    def _frames(self) -> Frames:
        from .vtu import Frames

        return Frames(self.scene, self._identity.comment)

    def remove_state(self, step: int) -> None:
        """Remove a state that was kept only because the run ended there."""
        self._clear(f"states/{step:06d}.npz", f"frames/{step:06d}.vtu")
        self._times.pop(step, None)
        self._write_index()

    def cut(self, step: int) -> None:
        """Remove what was written after a step, by one that was interrupted while it was written down."""
        self._clear("states/*.npz", "frames/*.vtu", after=step)
        if len(self._history.rows) > step:
            self._history.rows = self._history.rows[:step]
            self._history.rewrite()

    def _write_index(self) -> None:
        if not (self._vtu or (self.path / "frames.pvd").exists()):
            return
        from .vtu import index

        frames = ((time, f"frames/{step:06d}.vtu") for step, time in self._times.items())
        self._write("frames.pvd", index(frames, self._identity.comment), lasting=False)

    def save(
        self, progress: Progress, step: int, seconds: float, seconds_by_part: Mapping[str, float]
    ) -> None:
        """Write a checkpoint and remove all but the last two."""
        checkpoint = Checkpoint(progress, step, seconds, seconds_by_part)
        self._write(f"checkpoint-{step:06d}.npz", arrays_content(self._identity.mark(to_arrays(checkpoint))))
        for old in sorted(self.path.glob("checkpoint-*.npz"))[:-KEPT_CHECKPOINTS]:
            self._clear(old.name)

    def summarise(self, summary: Mapping[str, Any]) -> None:
        """Write the summary."""
        self._write("summary.json", json_content({RUN: self._identity.run, **summary}, signed=True))


def prune(path: Path, *, last: bool) -> None:
    """Remove from the folder of a run that has ended all but its last state; that too where not `last`.

    What is left can be loaded; it cannot be gone on with.
    """
    unneeded = ["checkpoint-*.npz"] if last else ["scene.json", "body.npz", LOG, *MADE]
    for name in SUBFOLDERS:
        if (path / name).is_symlink():
            continue
        files = sorted(path.glob(f"{name}/*"))
        for file in files[:-1] if last else files:
            file.unlink()
        if not last and (path / name).is_dir():
            (path / name).rmdir()
    for file in [file for pattern in unneeded for file in path.glob(pattern)]:
        file.unlink()
    if last and (listed := path / "frames.pvd").is_file():
        from .vtu import entries, index

        comment = Identity.at(path).comment
        write_whole(listed, index(entries(listed.read_bytes())[-1:], comment))


def expected_size(scene: Scene, *, frames: int | None, vtu: bool) -> float:
    """Return about how many bytes the folder of a scene's result has, with so many frames or (None) pruned.

    By what is stored for a triangle, measured on cases of 768 to 2756 triangles: within 7 per cent.
    """
    states = 1 if frames is None else frames + 1
    own = ONCE + states * (STATE_SIZE + (FRAME_SIZE if vtu else 0))
    return float(scene.body.mesh.nelements) * (own if frames is None else own + CHECKPOINTS_SIZE)


def check_folder(path: Path, document: Mapping[str, Any], *, resume: bool, overwrite: bool) -> None:
    """Raise ValueError where a run may not write: to a file, beside foreign files, or over another result.

    document: what `document.stored` says of the scene.
    """
    described = path / "scene.json"
    if path.exists() and not path.is_dir():
        raise ValueError(f"out={path} is a file; results need a folder, name another one.")
    if not described.exists():
        first = ("body.npz", LOCK)  # of a run that was killed before it had written scene.json
        if path.exists() and any(p.name not in first and p.suffix != ".part" for p in path.iterdir()):
            raise ValueError(f"{path} holds files that are no result; choose an empty or a new folder.")
        return
    if overwrite:
        return
    old = read_document(path)
    if other := difference(old, document, ignoring=FREE):
        given = (one.get("case", {}).get("parameters") for one in (old, document))
        other = difference(*given) or other
    if resume and other:
        raise ValueError(
            f"{path} holds the result of another scene: {other}. A run that goes on may have another time "
            "limit (Stepping(seconds=...), --max-seconds), and else the scene that it began with; other "
            "values, such as more iterations or smaller steps, are a new run: choose another folder "
            "(out=..., --out DIR) or replace what is there (overwrite=True, --overwrite)."
        )
    if not resume:
        own = "this result" if (path / "summary.json").exists() else "this result, not finished"
        holds = f"the result of another scene ({other})" if other else own
        remedy = "" if other else ", go on with it (resume=True, --resume)"
        raise ValueError(
            f"{path} already holds {holds}; choose another folder (out=..., --out DIR){remedy} or replace "
            "what is there (overwrite=True, --overwrite)."
        )
