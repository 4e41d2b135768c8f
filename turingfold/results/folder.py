"""The folder of one result: scene, history, summary, kept states, frames and checkpoints.

    scene.json, body.npz       what was run: every part and value, versions, seed; it can be rebuilt and rerun
    history.csv                a row per accepted step
    summary.json               numbers of the last state, and how the run ended; none of a killed run
    states/000012.npz          fields of the state after step 12, exactly; the last state is always there
    frames/000012.vtu, frames.pvd   the same for ParaView
    checkpoint-000012.npz      from which the run goes on bit for bit; the last two are kept
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from ..scene import Scene, reached
from ..solve.march import Progress
from ..solve.newton import Memory
from ..solve.prediction import Past
from ..state import State
from .codec import Arrays
from .document import difference, stored
from .files import (
    CorruptFileError,
    read_arrays,
    read_json,
    write_arrays,
    write_json,
    write_whole,
    writing,
)
from .history import COLUMNS, Row, lines, read_history

KEPT_CHECKPOINTS = 2
MADE = ("history.csv", "summary.json", "frames.pvd", "checkpoint-*.npz", "states/*.npz", "frames/*.vtu")


@dataclass(frozen=True)
class Checkpoint:
    """Where a run stood after `step` accepted steps, and the time spent until then; s."""

    progress: Progress
    step: int
    seconds: float
    seconds_by_part: Mapping[str, float]


class ResultFolder:
    """A folder that one run writes to; use it in a with statement.

    Raises ValueError if the folder holds another result or foreign files, OutputError if it cannot be
    written.
    """

    def __init__(
        self, path: Path, scene: Scene, *, resume: bool = False, overwrite: bool = False,
        case: Mapping[str, Any] | None = None,
    ) -> None:  # fmt: skip
        """Claim the folder for a scene; case: see `document.stored`."""
        self.path, self.scene = path, scene
        self._rows: list[Row] = []
        self._columns = list(COLUMNS)
        self._history: TextIO | None = None
        self._index: list[tuple[float, str]] = []
        self._claim(*stored(scene, case), resume=resume, overwrite=overwrite)

    def __enter__(self) -> ResultFolder:
        """Return the folder."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the history."""
        if self._history is not None:
            self._history.close()

    def _claim(self, document: dict[str, Any], arrays: Arrays, *, resume: bool, overwrite: bool) -> None:
        check_folder(self.path, document, resume=resume, overwrite=overwrite)
        described = self.path / "scene.json"
        if described.exists():
            if resume:
                return
            self._clear("scene.json", *MADE)
        write_arrays(self.path / "body.npz", arrays)
        write_json(described, document)

    def _clear(self, *patterns: str, after: int = -1) -> None:
        """Remove files, numbered ones only of steps after one."""
        for old in [file for pattern in patterns for file in self.path.glob(pattern)]:
            if not old.stem.isdecimal() or int(old.stem) > after:
                with writing(old):
                    old.unlink()

    # reading back

    def checkpoint(self) -> Checkpoint | None:
        """Return the newest checkpoint that is undamaged, and remove everything written after it.

        Without one nothing of the earlier run is left. Warns about damaged ones.
        """
        for file in sorted(self.path.glob("checkpoint-*.npz"), reverse=True):
            try:
                found = _checkpoint(read_arrays(file))
            except CorruptFileError as error:
                warnings.warn(f"{error} Going on from an older state.", stacklevel=2)
                self._clear(file.name)
                continue
            self._rows = read_history(self.path)[: found.step]
            if len(self._rows) < found.step:
                warnings.warn(f"{self.path / 'history.csv'} has lost rows; starting over.", stacklevel=2)
                break
            self._rewrite_history()
            self._index = [(t, f) for t, f in read_index(self.path) if int(Path(f).stem) <= found.step]
            self._clear("states/*.npz", "frames/*.vtu", after=found.step)
            if not reached(self.scene, found.progress.state.time):
                self._clear("summary.json")  # from here on it is not what it says
            return found
        self._rows, self._index = [], []
        self._clear(*MADE)
        return None

    def lost(self, step: int) -> bool:
        """Return whether the state after a step was kept, but is missing or damaged now."""
        file, frame = self.path / "states" / f"{step:06d}.npz", f"frames/{step:06d}.vtu"
        if not file.exists():
            return any(name == frame for _, name in self._index)
        try:
            read_arrays(file)
        except CorruptFileError:
            return True
        return not (self.path / frame).exists()

    def cut(self, step: int) -> None:
        """Remove what was written after a step, by one that was interrupted while it was written down."""
        self._clear("states/*.npz", "frames/*.vtu", after=step)
        if len(self._rows) > step:
            self._rows = self._rows[:step]
            self._rewrite_history()

    def remove_state(self, step: int) -> None:
        """Remove a state that was kept only because the run ended there."""
        self._clear(f"states/{step:06d}.npz", f"frames/{step:06d}.vtu")
        self._index = [entry for entry in self._index if entry[1] != f"frames/{step:06d}.vtu"]
        self._write_index()

    def history(self) -> list[Row]:
        """Return the rows up to the checkpoint."""
        return [dict(row) for row in self._rows]

    # writing

    def add_row(self, row: Row) -> None:
        """Append a row to the history, at once."""
        self._rows.append(row)
        if self._history is None or not set(row) <= set(self._columns):
            self._rewrite_history()
            return
        with writing(self.path / "history.csv"):
            self._history.write(lines([row], self._columns))
            self._history.flush()

    def _rewrite_history(self) -> None:
        path = self.path / "history.csv"
        extra = {name for row in self._rows for name in row} - set(COLUMNS)
        self._columns = [*COLUMNS, *sorted(extra)]
        if self._history is not None:
            self._history.close()
        write_whole(path, (",".join(self._columns) + "\n" + lines(self._rows, self._columns)).encode())
        with writing(path):
            self._history = path.open("a", newline="", encoding="utf-8")

    def add_state(self, step: int, state: State, observed: Mapping[str, NDArray[np.float64]]) -> None:
        """Keep a state, exactly and as a frame for ParaView."""
        from .vtu import frame

        name = f"{step:06d}"
        write_arrays(self.path / "states" / f"{name}.npz", {"time": np.array(state.time), **state.fields})
        write_whole(self.path / "frames" / f"{name}.vtu", frame(self.scene.body, state, observed))
        self._index = [entry for entry in self._index if entry[1] != f"frames/{name}.vtu"]
        self._index.append((state.time, f"frames/{name}.vtu"))
        self._write_index()

    def _write_index(self) -> None:
        from .vtu import index

        write_whole(self.path / "frames.pvd", index(self._index))

    def save(
        self, progress: Progress, step: int, seconds: float, seconds_by_part: Mapping[str, float]
    ) -> None:
        """Write a checkpoint and remove all but the last two."""
        checkpoint = Checkpoint(progress, step, seconds, seconds_by_part)
        write_arrays(self.path / f"checkpoint-{step:06d}.npz", _arrays(checkpoint))
        for old in sorted(self.path.glob("checkpoint-*.npz"))[:-KEPT_CHECKPOINTS]:
            with writing(old):
                old.unlink()

    def summarise(self, summary: Mapping[str, Any]) -> None:
        """Write the summary."""
        write_json(self.path / "summary.json", dict(summary))


def check_folder(path: Path, document: Mapping[str, Any], *, resume: bool, overwrite: bool) -> None:
    """Raise ValueError where a run may not write: to a file, beside foreign files, or over another result.

    document: what `document.stored` says of the scene.
    """
    described = path / "scene.json"
    if path.exists() and not path.is_dir():
        raise ValueError(f"out={path} is a file; results need a folder, name another one.")
    if not described.exists():
        if path.exists() and any(p.name != "body.npz" and p.suffix != ".part" for p in path.iterdir()):
            raise ValueError(f"{path} holds files that are no result; choose an empty or a new folder.")
        return
    if overwrite:
        return
    ignoring = ("versions", "case", "scene.stepping.seconds")
    other = difference(read_json(described), document, ignoring=ignoring)
    if resume and other:
        raise ValueError(
            f"{path} holds the result of another scene: {other}. Resume with the scene it was "
            "made from, or choose another folder."
        )
    if not resume:
        holds = f"the result of another scene ({other})" if other else "this result"
        remedy = "" if other else ", go on with it (resume=True, --resume)"
        raise ValueError(
            f"{path} already holds {holds}; choose another folder{remedy} or replace what is there "
            "(overwrite=True, --overwrite)."
        )


@dataclass(frozen=True)
class Ending:
    """How a stored run ended: what summary.json says, or what its absence means."""

    status: str = "interrupted"
    message: str = "It was killed and has no summary; go on with resume=True (--resume)."
    seconds: float | None = None
    seconds_by_part: Mapping[str, float] = field(default_factory=dict)


def read_ending(path: Path) -> Ending:
    """Return how the run of a folder ended."""
    file = path / "summary.json"
    if not file.exists():
        return Ending()
    summary = read_json(file)
    return Ending(*(summary[name] for name in ("status", "message", "seconds", "seconds_by_part")))


def read_states(path: Path) -> list[State]:
    """Return the kept states, and the last one, which of a run that was killed is in the checkpoint only."""
    states = kept_states(path)
    last = max((file.stem for file in (path / "states").glob("*.npz")), default="")
    for file in sorted(path.glob("checkpoint-*.npz"), reverse=True):
        if file.stem.removeprefix("checkpoint-") <= last:
            break
        try:
            return [*states, _checkpoint(read_arrays(file)).progress.state]
        except CorruptFileError as error:
            warnings.warn(str(error), stacklevel=2)
    return states


def kept_states(path: Path) -> list[State]:
    """Return the kept states; damaged ones are left out, with a warning."""
    states = []
    for file in sorted((path / "states").glob("*.npz")):
        try:
            fields = read_arrays(file)
        except CorruptFileError as error:
            warnings.warn(str(error), stacklevel=2)
            continue
        states.append(State(float(fields.pop("time")), fields))
    return states


def read_index(path: Path) -> list[tuple[float, str]]:
    """Return time and file of each frame that is listed."""
    from .vtu import entries

    file = path / "frames.pvd"
    return entries(file.read_bytes()) if file.exists() else []


def _arrays(checkpoint: Checkpoint) -> Arrays:
    progress, parts = checkpoint.progress, checkpoint.seconds_by_part
    arrays: Arrays = {f"field.{name}": values for name, values in progress.state.fields.items()}
    arrays["numbers"] = np.array([progress.state.time, progress.dt, progress.previous_dt, checkpoint.seconds])
    arrays["step"] = np.array(checkpoint.step)
    arrays["parts"], arrays["seconds"] = np.array(list(parts), dtype=np.str_), np.array(list(parts.values()))
    if progress.past:
        arrays["past.times"] = np.array([past.time for past in progress.past])
        arrays["past.displacements"] = np.stack([past.displacement for past in progress.past])
    if (memory := progress.memory) is not None:
        arrays["memory.changing"] = memory.changing
        arrays["memory.convexity"] = np.array(memory.convexity)
        arrays["memory.missed"] = np.array(memory.missed)
        if memory.point is not None:
            arrays["memory.point"] = memory.point
    return arrays


def _checkpoint(arrays: Arrays) -> Checkpoint:
    time, dt, previous_dt, seconds = arrays["numbers"].tolist()
    own = [name for name in arrays if name.startswith("field.")]
    fields = {name.removeprefix("field."): arrays[name] for name in own}
    memory = None
    if "memory.changing" in arrays:
        level, missed = int(arrays["memory.convexity"]), float(arrays.get("memory.missed", np.inf))
        memory = Memory(arrays["memory.changing"], level, arrays.get("memory.point"), missed)
    past: tuple[Past, ...] = ()
    if "past.times" in arrays:
        pairs = zip(arrays["past.times"].tolist(), arrays["past.displacements"], strict=True)
        past = tuple(Past(*pair) for pair in pairs)
    progress = Progress(State(time, fields), dt, previous_dt, past, memory)
    parts = dict(zip(arrays["parts"].tolist(), arrays["seconds"].tolist(), strict=True))
    return Checkpoint(progress, int(arrays["step"]), seconds, parts)
