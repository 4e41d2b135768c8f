"""A checkpoint as arrays: everything from which a run goes on bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..solve.equilibrium import Memory
from ..solve.march import Progress
from ..solve.prediction import Past
from ..state import State
from .codec import Arrays
from .files import DAMAGE, CorruptFileError


@dataclass(frozen=True)
class Checkpoint:
    """Where a run stood after `step` accepted steps, and the time spent until then; s."""

    progress: Progress
    step: int
    seconds: float
    seconds_by_part: Mapping[str, float]


def to_arrays(checkpoint: Checkpoint) -> Arrays:
    """Return a checkpoint as arrays by name."""
    progress, parts = checkpoint.progress, checkpoint.seconds_by_part
    arrays: Arrays = {f"field.{name}": values for name, values in progress.state.fields.items()}
    arrays["numbers"] = np.array([progress.state.time, progress.dt, progress.previous_dt, checkpoint.seconds])
    arrays["usual_dt"] = np.array(progress.usual_dt)
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


def from_arrays(arrays: Arrays) -> Checkpoint:
    """Return the checkpoint that arrays hold; raises CorruptFileError where they hold none."""
    try:
        return _checkpoint(arrays)
    except DAMAGE as error:
        raise CorruptFileError(f"the checkpoint cannot be read: {error or type(error).__name__}.") from error


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
    usual_dt = float(arrays.get("usual_dt", np.array(dt)))
    progress = Progress(State(time, fields), dt, previous_dt, past, memory, usual_dt)
    parts = dict(zip(arrays["parts"].tolist(), arrays["seconds"].tolist(), strict=True))
    return Checkpoint(progress, int(arrays["step"]), seconds, parts)
