"""Results as they are read back from their folders."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .document import read_scene
from .files import CorruptFileError, FilePath
from .history import read_history
from .identity import Identity
from .reading import check_frames, read_ending, read_states
from .result import Result


class UnfinishedWarning(UserWarning):
    """A stored result whose last state is not the end of its scene, or is no valid one."""


def load(folder: FilePath, *, known: Iterable[Any] = ()) -> Result:
    """Return the result stored in a folder; its states are those that were kept, and the last one.

    known: classes and functions from outside turingfold that the scene is made of.
    Warns (UnfinishedWarning) of a result that did not reach its scene's end.
    Raises ValueError if the folder holds no result or one whose scene cannot be rebuilt, CorruptFileError
    where a file is damaged or of another run.
    """
    result = read_result(folder, known=known)
    if end := result.unfinished:
        said = result.message if end in result.message else f"{end}. {result.message}"
        warnings.warn(f"{folder}: {said}", UnfinishedWarning, stacklevel=2)
    return result


def read_result(folder: FilePath, *, known: Iterable[Any] = ()) -> Result:
    """Do what `load` does, without a warning."""
    path = Path(folder)
    scene, ending, identity = read_scene(path, known), read_ending(path), Identity.at(path)
    rows = read_history(path, identity)
    states = read_states(path, identity, rows)
    check_frames(path, identity)
    if not states:
        raise ValueError(f"{path} holds no state yet; run the scene first, or go on with resume=True.")
    # a killed run loses what is beyond the last state with a row, or the last row with a state
    history = [row for row in rows if row["time"] <= states[-1].time]
    states = [state for state in states if state.time <= (history[-1]["time"] if history else 0.0)]
    found = states[-1].time if states else None, len(history)
    if ending.time is not None and found != (ending.time, ending.steps):
        raise CorruptFileError(
            f"{path}: the last state, of t = {ending.time:g}, or the history that leads to it is missing or "
            "damaged; go on with resume=True (--resume), or run the scene again."
        )
    seconds = sum(row["seconds"] for row in history) if ending.seconds is None else ending.seconds
    return Result(
        scene, tuple(states), tuple(history), ending.status, ending.message, seconds, ending.seconds_by_part,
        ending.errors, ending.no_errors, ending.step_errors or {}, ending.no_step_errors,
        ending.quadrature_errors or {}, ending.softness,
    )  # fmt: skip
