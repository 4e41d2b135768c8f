"""Reading a result's folder back: how its run ended, and the states that were kept."""

from __future__ import annotations

import reprlib
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import NoneType

from ..state import State
from .checkpoint import from_arrays
from .files import CorruptFileError, read_arrays, read_json
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
    summary = read_json(file)
    for name, kind in KINDS.items():
        if name in LATER and name not in summary:
            summary[name] = LATER[name]
        if not isinstance(summary.get(name), kind):
            found = reprlib.repr(summary.get(name))
            raise CorruptFileError(
                f"{file}: {name} is {found}; the file is damaged. Go on with resume=True (--resume)."
            )
    return Ending(**{name: summary[name] for name in KINDS})


def read_states(path: Path) -> list[State]:
    """Return the kept states, and the last one, which of a run that was killed is in the checkpoint only.

    Damaged ones are left out, with a warning.
    """
    states, last = [], ""
    for file in sorted((path / "states").glob("*.npz")):
        try:
            states.append(state_of(file))
            last = file.stem
        except CorruptFileError as error:
            warnings.warn(str(error), stacklevel=3)
    for file in sorted(path.glob("checkpoint-*.npz"), reverse=True):
        if file.stem.removeprefix("checkpoint-") <= last:
            break
        try:
            return [*states, from_arrays(read_arrays(file)).progress.state]
        except CorruptFileError as error:
            if file.exists():  # a run that goes on removes old ones
                warnings.warn(str(error), stacklevel=3)
    return states


def state_of(file: Path) -> State:
    """Return the state in a file; raises CorruptFileError where it is damaged."""
    fields = read_arrays(file)
    time = fields.pop("time", None)
    if time is None or time.shape or "displacement" not in fields:
        raise CorruptFileError(f"{file} holds no state.")
    return State(float(time), fields)
