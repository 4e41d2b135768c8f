"""Run a scene to its end: march, measure, and write down what comes of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .checks import whole
from .mechanics.march import Progress, Step, begin, march
from .results import Result, along_pial, growth, observe, pial_closed
from .scene import NotConvergedError, Scene, SolveError, State

if TYPE_CHECKING:
    from .output.folder import ResultFolder

Array = NDArray[np.float64]
Row = dict[str, float]
FilePath = str | os.PathLike[str]

SEGMENT = 5  # steps between checkpoints


class StoppedError(NotConvergedError):
    """A march that stopped; `result` holds everything up to the last good state."""

    def __init__(self, error: SolveError, result: Result) -> None:
        """Take over message, time and residual of the error that stopped the march."""
        super().__init__(str(error), time=error.time, residual=error.residual)
        self.result = result


def simulate(
    scene: Scene,
    out: FilePath | None = None,
    *,
    progress: Callable[[Row], object] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    frames: int = 20,
) -> Result:
    """Run a scene to its end and return every accepted state.

    out: folder that the result is stored in while it is made; see `output.folder`.
    progress: is called with each new row of the history.
    resume: go on from the last checkpoint in `out`, with the same bits as a run without interruption.
    overwrite: replace a result that `out` holds.  frames: states kept on disk, evenly spaced in time.
    Raises StoppedError where no step is possible any more, ValueError where `out` holds something else,
    OutputError (an OSError) where it cannot be written.
    """
    whole("frames", frames, at_least=1)
    if out is None:
        if resume or overwrite:
            raise ValueError("resume and overwrite need a folder: simulate(scene, out=folder, ...).")
        return _Run(scene, frames, progress).to_the_end()
    from .output.folder import ResultFolder

    with ResultFolder(Path(out), scene, resume=resume, overwrite=overwrite) as folder:
        return _Run(scene, frames, progress, folder).to_the_end()


@dataclass
class _Run:
    """A run under way: what has come of the scene so far, and where it is written."""

    scene: Scene
    frames: int
    progress: Callable[[Row], object] | None = None
    folder: ResultFolder | None = None
    states: list[State] = field(default_factory=list)
    history: list[Row] = field(default_factory=list)
    parts: dict[str, float] = field(default_factory=dict)
    spent: float = 0.0  # before an interruption
    began: float = field(default_factory=perf_counter)

    def to_the_end(self) -> Result:
        """March until the scene's end; whatever stops it, what was reached is summed up."""
        try:
            for step, position, ended in _segments(self.scene, self._position(), self.began):
                self._accept(step)
                if ended:
                    self._book(step.seconds)
                    self._save(position)
        except SolveError as error:
            if not self.states:
                raise
            raise StoppedError(error, self._finish()) from error
        except KeyboardInterrupt:
            if self.states:
                self._finish()
            raise
        return self._finish()

    def _finish(self) -> Result:
        reached = self.states[-1].time >= self.scene.until * (1 - 1e-12)
        states, history = tuple(self.states), tuple(self.history)
        result = Result(self.scene, states, history, reached, self._seconds(), dict(self.parts))
        if self.folder is not None:
            self.folder.summarise(result.summary())
        return result

    def _seconds(self) -> float:
        return self.spent + perf_counter() - self.began

    def _book(self, seconds: Mapping[str, float]) -> None:
        for part, spent in seconds.items():
            self.parts[part] = self.parts.get(part, 0.0) + spent

    def _position(self) -> Progress:
        """Return where to go on: at the checkpoint, or at the start."""
        found = self.folder.checkpoint() if self.folder is not None else None
        if self.folder is None or found is None:
            position = begin(self.scene)
            self.states.append(position.state)
            self._book({"starting": self._seconds()})
            if self.folder is not None:
                self._keep(observe(self.scene, position.state, position.dt))
                self._save(position)
            return position
        from .output.folder import read_states

        state = found.progress.state
        self.history = self.folder.history()
        self.states = [s for s in read_states(self.folder.path, state.time) if s.time < state.time] + [state]
        self.parts, self.spent = dict(found.seconds_by_part), found.seconds
        return found.progress

    def _accept(self, step: Step) -> None:
        from .morphometry.shape import gyrification_index

        before, state, body = self.states[-1].time, step.state, self.scene.body
        self.states.append(state)
        pial = along_pial(body, (body.nodes + state["displacement"])[:, body.pial])
        index = gyrification_index(pial, closed=pial_closed(body))
        row = {**step.numbers, "growth": growth(state), "gyrification_index": index}
        self.history.append(row)
        if self.folder is not None:
            began = perf_counter()
            if _due(before, state.time, self.scene.until, self.frames):
                self._keep(step.observe())
            self.folder.add_row(row)
            self._book({"writing": perf_counter() - began})
        if self.progress is not None:
            self.progress(row)

    def _keep(self, observed: Mapping[str, Array]) -> None:
        if self.folder is not None:
            self.folder.add_state(len(self.history), self.states[-1], observed)

    def _save(self, position: Progress) -> None:
        from .output.folder import Checkpoint

        if self.folder is not None:
            self.folder.save(Checkpoint(position, len(self.history), self._seconds(), self.parts))


def _segments(scene: Scene, position: Progress, began: float) -> Iterator[tuple[Step, Progress, bool]]:
    """Yield steps, progress, and whether a checkpoint is due.

    After each checkpoint the march starts afresh, as it does when it is resumed: what a solver remembers of
    earlier steps would else make the two differ in the last bits.
    """
    until, limit = scene.until * (1 - 1e-12), scene.stepping.seconds
    while position.state.time < until:
        for count, (step, position) in enumerate(march(scene, position), start=1):  # noqa: B020 - on purpose
            ended = count == SEGMENT or position.state.time >= until
            yield step, position, ended
            if perf_counter() - began > limit and position.state.time < until:
                raise NotConvergedError(
                    f"the time limit of {limit:g} s was reached at t = {position.state.time:.6g} of "
                    f"{scene.until:g}; allow more with Stepping(seconds=...), or resume.",
                    time=position.state.time,
                )
            if ended:
                break


def _due(before: float, now: float, until: float, frames: int) -> bool:
    """Return whether one of `frames` evenly spaced times lies in (before, now]."""
    return int(now / until * frames + 1e-9) > int(before / until * frames + 1e-9)
