"""Reading a result's folder back: how its run ended, and the states that were kept."""

from __future__ import annotations

import reprlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import NoneType
from typing import Any

from ..state import State
from .checkpoint import Checkpoint, from_arrays
from .files import CHECKSUM, CorruptFileError, read_json, unsigned
from .history import Row, read_history
from .identity import RUN, ForeignFileError, Identity
from .lock import writer

# what results of earlier versions do not say
NOT_YET = "Its program did not estimate errors."
LATER: Mapping[str, object] = {
    "errors": {}, "no_errors": NOT_YET, "step_errors": None, "no_step_errors": NOT_YET,
    "quadrature_errors": None, "softness": None,
}  # fmt: skip
KINDS: dict[str, type | tuple[type, ...]] = {
    "status": str, "message": str, "seconds": (int, float), "seconds_by_part": dict, "time": (int, float),
    "steps": int, "errors": dict, "no_errors": str, "step_errors": (dict, NoneType),
    "no_step_errors": str, "quadrature_errors": (dict, NoneType),
    "softness": (int, float, NoneType),
}  # fmt: skip


@dataclass(frozen=True)
class Ending:
    """How a stored run ended: what summary.json says, or what its absence means.

    time, steps: of the last state, None where nothing says so.
    """

    status: str = "interrupted"
    message: str = "It was killed and has no summary; go on with resume=True (--resume)."
    seconds: float | None = None
    seconds_by_part: Mapping[str, float] = field(default_factory=dict)
    time: float | None = None
    steps: int | None = None
    errors: Mapping[str, float] = field(default_factory=dict)
    no_errors: str = ""
    step_errors: Mapping[str, float] | None = None
    no_step_errors: str = ""
    quadrature_errors: Mapping[str, float] | None = None
    softness: float | None = None


def read_ending(path: Path) -> Ending:
    """Return how the run of a folder ended; raises CorruptFileError where summary.json does not say it."""
    file = path / "summary.json"
    if not file.exists():
        name = writer(path)
        return Ending("running", f"It is being written by {name}.") if name else Ending()
    summary = read_summary(path)
    for name, kind in KINDS.items():
        if name in LATER and name not in summary:
            summary[name] = LATER[name]
        if not isinstance(summary.get(name), kind):
            found = reprlib.repr(summary.get(name))
            raise CorruptFileError(
                f"{file}: {name} is {found}; the file is damaged. Go on with resume=True (--resume)."
            )
    return Ending(**{name: summary[name] for name in KINDS})


def read_summary(path: Path) -> dict[str, Any]:
    """Return what summary.json says; raises CorruptFileError where it was changed or is of another run."""
    file, identity = path / "summary.json", Identity.at(path)
    summary = read_json(file)
    if identity.everywhere or CHECKSUM in summary:
        try:
            summary = unsigned(summary, file)
        except CorruptFileError as error:
            remedy = "Go on with resume=True (--resume), which writes it anew."
            raise CorruptFileError(f"{error} {remedy}") from error
    identity.check(file, summary.get(RUN))
    return summary


def read_states(path: Path, identity: Identity, rows: Sequence[Row]) -> list[State]:
    """Return the kept states, and the last one, which of a run that was killed is in the checkpoint only.

    rows: of the history.  Damaged ones, and those of another run or step, are left out, with a warning.
    """
    states, last = [], ""
    for file in sorted((path / "states").glob("*.npz")):
        try:
            states.append(state_of(file, identity, rows))
            last = file.stem
        except CorruptFileError as error:
            warnings.warn(str(error), stacklevel=3)
    for file in sorted(path.glob("checkpoint-*.npz"), reverse=True):
        if file.stem.removeprefix("checkpoint-") <= last:
            break
        try:
            return [*states, checkpoint_of(file, identity, rows).progress.state]
        except CorruptFileError as error:
            if file.exists():  # a run that goes on removes old ones
                warnings.warn(str(error), stacklevel=3)
    return states


def state_of(file: Path, identity: Identity, rows: Sequence[Row]) -> State:
    """Return the state in a file; raises CorruptFileError where it is damaged, or of another run or step."""
    fields = identity.read(file)
    time = fields.pop("time", None)
    if time is None or time.shape or "displacement" not in fields:
        raise CorruptFileError(f"{file} holds no state.")
    _check_step(file, float(time), rows)
    return State(float(time), fields)


def checkpoint_of(file: Path, identity: Identity, rows: Sequence[Row]) -> Checkpoint:
    """Return the checkpoint in a file; raises as `state_of`."""
    found = from_arrays(identity.read(file))
    _check_step(file, found.progress.state.time, rows)
    return found


def _check_step(file: Path, time: float, rows: Sequence[Row]) -> None:
    """Raise CorruptFileError unless a file is named by a step, and its state's time is that of this step.

    Where a killed run has lost the row of that step, unless it is later than the rows that there are.
    """
    number = file.stem.removeprefix("checkpoint-")
    if not number.isdecimal():  # as of a copy
        raise CorruptFileError(f"{file} is not named by its step, as 000001.npz is.")
    step, known = int(number), [0.0, *(row["time"] for row in rows)]
    lost = step >= len(known)
    if time > known[-1] if lost else time == known[step]:
        return
    wanted = f"comes after t = {known[-1]:g}" if lost else f"ended at t = {known[step]:g}"
    raise CorruptFileError(
        f"{file} holds the state of t = {time:g}, but by history.csv step {step} {wanted}: it is a file of "
        "another step. Put back the file that was here, or run the scene again (overwrite=True, --overwrite)."
    )


def check_frames(path: Path, identity: Identity) -> None:
    """Warn of the list of frames, and of frames, that are damaged or of another run."""
    listed = path / "frames.pvd"
    for file in [*([listed] if listed.exists() else []), *sorted((path / "frames").glob("*.vtu"))]:
        try:
            identity.check_comment(file)
        except CorruptFileError as error:
            if file.exists():  # a run that goes on removes some
                warnings.warn(str(error), stacklevel=3)


def check_scene_is_own(path: Path) -> None:
    """Raise ForeignFileError for a scene.json that is of another run than everything beside it."""
    identity, own, other = Identity.at(path), 0, 0
    checks: dict[Path, Callable[[], object]] = {
        path / "history.csv": partial(read_history, path, identity),
        path / "summary.json": partial(read_summary, path),
        **{file: partial(identity.read, file) for file in path.glob("checkpoint-*.npz")},
    }
    for file, check in checks.items():
        if not file.exists():
            continue
        try:
            check()
            own += 1
        except ForeignFileError:
            other += 1
        except CorruptFileError:  # of damage it is not known
            continue
    if other and not own:
        raise ForeignFileError(
            f"{path / 'scene.json'} is of another run than the files beside it. Put back the one that was "
            "here, choose another folder (out=..., --out DIR), or replace what is here (overwrite=True, "
            "--overwrite)."
        )
