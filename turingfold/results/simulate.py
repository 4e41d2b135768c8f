"""Run a scene to its end: march, measure, and write down what comes of it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from ..arrays import Array
from ..checks import instance, whole
from ..errors import NotConvergedError, SolveError
from ..growth.ages import ages_of
from ..growth.measure import largest_growth
from ..scene import Scene, reached
from ..solve.march import Progress, Step, begin, march
from ..solve.problem import Problem
from ..solve.threads import one_thread
from ..state import State
from ..terms.boundary import crossings
from .callers import level_outside
from .document import origin
from .files import FilePath
from .holding import warn_of_holding
from .log import is_due
from .measures import gyrification, inverted
from .result import Result, Row, observe
from .validity import ended
from .watch import Tracker, watcher

if TYPE_CHECKING:
    from .folder import ResultFolder

GO_ON = "The last accepted state is kept; go on with resume=True (--resume)."
FRAMES = 20  # states kept on disk
CUT = "The estimate was interrupted."
OUT_OF_TIME = "The time limit was reached."
CHECKPOINT = 1.0  # s between checkpoints
ENOUGH = 3  # elements through the cortex: the onset of buckling is then within 0.1 %, with 2 within 0.3 %


class CoarseMeshWarning(UserWarning):
    """Too few elements through a growing cortex for numbers to quote."""


class StoppedError(NotConvergedError):
    """A march that stopped; `result` holds everything up to the last good state."""

    def __init__(self, error: SolveError, result: Result) -> None:
        """Take over message, time and residual of the error that stopped the march."""
        super().__init__(str(error), time=error.time, residual=error.residual)
        self.result = result


@one_thread
def simulate(
    scene: Scene,
    out: FilePath | None = None,
    *,
    progress: Callable[[Row], object] | bool | None = None,
    trackers: Sequence[Tracker] = (),
    resume: bool = False,
    overwrite: bool = False,
    frames: int = FRAMES,
    vtu: bool = True,
    case: Mapping[str, Any] | None = None,
    errors: bool | None = None,
) -> Result:
    """Run a scene to its end and return every accepted state.

    out: folder that the result is stored in while it is made; see `output.folder`.
    progress: is called with each new row of the history; True shows a line of progress.
    trackers: functions that are called with states and their fields, see `Tracker`.
    resume: go on from the last checkpoint in `out`, with the same bits as a run without interruption.
    overwrite: replace a result that `out` holds; not with `resume`.
    frames: states kept on disk, evenly spaced in time, beside those at the stops of its stepping.
    vtu: whether these are also written as frames for ParaView.
    errors: whether to estimate how far the last state's numbers are off, by the mesh and by the steps; by
    default where `out` keeps them. Of scenes that move or remember that takes half as long as the march. None
    after a time limit.
    case: what the scene comes from, numbers and words that scene.json keeps as "case".
    It works with one thread of OpenBLAS or MKL, so that results repeat bit for bit, or as many as
    OMP_NUM_THREADS, OPENBLAS_NUM_THREADS or MKL_NUM_THREADS says.
    Warns (CoarseMeshWarning) of fewer than three elements through a growing cortex, and of parts that push on
    the nodes that only hold them in place (HoldingForceWarning).
    Raises StoppedError where no step is possible any more, ValueError where `out` holds something else and
    for processes of different ages, OutputError (an OSError) where it cannot be written.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    ages_of(scene.processes)
    _warn_if_coarse(scene)
    whole("frames", frames, at_least=1)
    watch = watcher(progress, scene.until)
    for tracker in trackers:
        instance("trackers", tracker, Tracker, "Tracker(call=function, times=(0.5, 1.0))")
    if resume and overwrite:
        raise ValueError(
            "resume=True goes on with what `out` holds and overwrite=True replaces it; choose one of the two."
        )
    if out is None:
        if resume or overwrite:
            raise ValueError("resume and overwrite need a folder: simulate(scene, out=folder, ...).")
        return _Run(scene, frames, watch, trackers, errors=bool(errors)).to_the_end()
    from .folder import ResultFolder

    with ResultFolder(Path(out), scene, resume=resume, overwrite=overwrite, case=case, vtu=vtu) as folder:
        command = str((case or {}).get("command", "simulate"))
        run = _Run(scene, frames, watch, trackers, folder, errors=errors is not False, command=command)
        return run.to_the_end()


def coarseness(elements: float, remedy: str = "make size= smaller (elements= larger)") -> str:
    """Return what to say of so few elements through a growing cortex, or nothing where they are enough."""
    if elements >= ENOUGH - 0.01:
        return ""
    return (
        f"only {elements:.2g} element(s) through the cortex; folds form too late with fewer than {ENOUGH}, "
        f"so {remedy} for numbers to quote"
    )


def _warn_if_coarse(scene: Scene) -> None:
    words = coarseness(scene.body.elements_through_cortex)
    if words and any("growth" in process.writes for process in scene.processes):
        warnings.warn(words, CoarseMeshWarning, stacklevel=level_outside())


@dataclass
class _Run:
    """A run under way: what has come of the scene so far, and where it is written."""

    scene: Scene
    frames: int
    progress: Callable[[Row], object] | None = None
    trackers: Sequence[Tracker] = ()
    folder: ResultFolder | None = None
    errors: bool = False
    command: str = ""
    states: list[State] = field(default_factory=list)
    history: list[Row] = field(default_factory=list)
    parts: dict[str, float] = field(default_factory=dict)  # seconds, without those of the present march
    marching: Mapping[str, float] = field(default_factory=dict)  # seconds of the present march
    spent: float = 0.0  # seconds before an interruption
    began: float = field(default_factory=perf_counter)
    position: Progress | None = None
    saved: float = 0.0  # when the last checkpoint was written

    @cached_property
    def problem(self) -> Problem:
        """The scene on its body."""
        return Problem(self.scene)

    def to_the_end(self) -> Result:
        """March until the scene's end; whatever stops it, what was reached is kept and summed up."""
        self._begin_log()
        try:
            self.position = self._start()
        except SolveError as error:
            self._log(f"stopped before the first state: {error}")
            raise
        self._log(f"{'goes on' if self.history else 'begins'}: {self._where()}")
        try:
            for step, position in march(self.scene, self.position, self.problem):
                self._accept(step, position)
                del step  # the next one needs the memory
        except SolveError as error:
            raise StoppedError(error, self._finish("stopped", str(error))) from error
        except KeyboardInterrupt:
            self._finish("interrupted", GO_ON)
            raise
        return self._finish()

    def _start(self) -> Progress:
        """Return where to go on: at the checkpoint, or at the start."""
        found = self.folder.checkpoint() if self.folder is not None else None
        if self.folder is None or found is None:
            position = begin(self.scene, self.problem)
            self.states.append(position.state)
            self._track(-1.0, position.state, lambda: observe(self.problem, position.state, self._first()))
            self.parts["starting"] = self._seconds()
            if self.folder is not None:
                self._keep(0, position.state)
                self._save(position)
            return position
        self.history = self.folder.history()
        self.states = self._restored(found.step, found.progress.state)
        self.parts, self.spent = dict(found.seconds_by_part), found.seconds
        return found.progress

    def _restored(self, step: int, state: State) -> list[State]:
        """Return the states until the checkpoint's; make what is missing on disk anew as far as possible."""
        assert self.folder is not None
        kept = self.folder.kept(before=step)
        for number, own in kept.items():
            if self.folder.lacks_frame(number):
                self._keep(number, own)
        before = self.history[-2]["time"] if step > 1 else 0.0
        if step == 0 or _due(before, state.time, self.scene, self.frames):
            self._keep(step, state)
        else:  # if it was kept, then only because the run ended there
            self.folder.remove_state(step)
        return [*kept.values(), state]

    def _accept(self, step: Step, position: Progress) -> None:
        """Measure a step, write it down, and only then count it."""
        before, state, body = self.states[-1].time, step.state, self.scene.body
        index = gyrification(body, state["displacement"])
        row = {**step.numbers, "growth": largest_growth(state), "gyrification_index": index}
        row["inverted_elements"] = inverted(body, state)
        row["self_intersections"] = crossings(body, state["displacement"])
        began = perf_counter()
        if self.folder is not None:
            if _due(before, state.time, self.scene, self.frames):
                self.folder.add_state(len(self.history) + 1, state, step.observe())
            self.folder.add_row(row)
        if "holding_force" in row:
            warn_of_holding(self.scene, self.history, row["holding_force"])
        self.states.append(state)
        self.history.append(row)
        self.position, self.marching = position, step.seconds
        if perf_counter() - self.saved > CHECKPOINT:
            self._save(position)
        if is_due(before / self.scene.until, state.time / self.scene.until):
            self._log(f"{state.time / self.scene.until:4.0%}, {self._where()}")
        if self.folder is not None:
            self.parts["writing"] = self.parts.get("writing", 0.0) + perf_counter() - began
        if self.progress is not None:
            self.progress(row)
        self._track(before, state, step.observe)

    def _track(self, before: float, state: State, fields: Callable[[], Mapping[str, Array]]) -> None:
        """Call the trackers that are due, with a state and its fields."""
        if due := [tracker for tracker in self.trackers if tracker.is_due(before, state.time)]:
            shown = fields()
            for tracker in due:
                tracker.call(state, shown)

    def _finish(self, status: str = "interrupted", message: str = GO_ON) -> Result:
        """Write down the last accepted state, and return what has come of the scene."""
        if self.position is not None:
            end = self.position.state.time  # of what an interrupt left half counted, nothing stays
            self.states = [state for state in self.states if state.time <= end]
            self.history = [row for row in self.history if row["time"] <= end]
            if self.folder is not None:
                self.folder.cut(len(self.history))
            self._save(self.position)
        if reached(self.scene, self.states[-1].time):
            moves = any(term.resists_motion for term in self.scene.terms)
            status, message = ended(self.history, moves=moves)
        elif self.folder is not None and self.position is not None:
            self._keep(len(self.history), self.states[-1])
        states, history = tuple(self.states), tuple(self.history)
        result = Result(self.scene, states, history, status, message, self._seconds(), self._parts())
        self._log(f"{status}: {self._where()}" + (f"\n{message}" if message else ""))
        if self.errors and history and status == "stopped" and perf_counter() > self.problem.deadline:
            result = replace(result, no_errors=OUT_OF_TIME, no_step_errors=OUT_OF_TIME)
        elif self.errors and history and status != "interrupted":
            result = self._with_errors(result)
        if self.folder is not None:
            self.folder.summarise(result.summary())
        return result

    def _begin_log(self) -> None:
        """Write down what is run, and with what."""
        if self.folder is None:
            return
        made = " ".join(f"{name} {own}" for name, own in origin()["versions"].items())
        self._log(f"{self.command}\n{made}")
        body = self.scene.body
        for remark in body.changes.remarks() if body.changes is not None else ():
            self._log(f"outline: {remark}")
        self._log(f"{body.mesh.nelements} triangles, {body.elements_through_cortex:.2g} through the cortex")

    def _where(self) -> str:
        """Return where the run stands, as text."""
        last = self.states[-1]
        iterations = sum(row["newton_iterations"] for row in self.history)
        return (
            f"t = {last.time:.6g} of {self.scene.until:g}, growth {largest_growth(last):.4f}, "
            f"{len(self.history)} steps, {iterations:.0f} iterations, {self._seconds():.1f} s"
        )

    def _log(self, text: str) -> None:
        if self.folder is not None:
            self.folder.log(text)

    def _with_errors(self, result: Result) -> Result:
        """Return a result with how far its last numbers are off by the mesh and by the steps."""
        from .estimate import estimated
        from .quadrature_error import quadrature_errors
        from .softness import softness
        from .step_error import step_errors

        if self.folder is not None:  # it is not lost if this is interrupted
            self.folder.summarise(replace(result, no_errors=CUT, no_step_errors=CUT).summary())
        last, times = self.history[-1], [row["time"] for row in self.history]
        mesh = self._tried("error estimate", lambda: estimated(self.problem, result.last))
        rule = self._tried("error estimate", lambda: quadrature_errors(self.problem, result.last))
        soft = self._tried("error estimate", lambda: {"softness": softness(self.problem, result.last)})
        steps: tuple[dict[str, float], str] = {}, "The march stopped."
        if result.status != "stopped":
            steps = self._tried(
                "error estimate of steps",
                lambda: step_errors(self.scene, times, result.last, last["energy"]),
            )
        return replace(
            result, seconds=self._seconds(), seconds_by_part=self._parts(), errors=mesh[0], no_errors=mesh[1],
            step_errors=steps[0], no_step_errors=steps[1], quadrature_errors=rule[0],
            softness=soft[0].get("softness"),
        )  # fmt: skip

    def _tried(self, part: str, estimate: Callable[[], dict[str, float]]) -> tuple[dict[str, float], str]:
        """Return what an estimate of errors gives, or why it gives nothing; part: what its time counts as."""
        from .carried import NoEstimateError

        began = perf_counter()
        try:
            return estimate(), ""
        except (NoEstimateError, SolveError, ValueError, MemoryError) as error:  # the run stays what it is
            return {}, str(error)
        finally:
            self.parts[part] = self.parts.get(part, 0.0) + perf_counter() - began

    def _keep(self, step: int, state: State) -> None:
        """Keep the state of a step that was not just taken, on disk."""
        assert self.folder is not None
        dt = self.history[step - 1]["step"] if step else self._first()
        self.folder.add_state(step, state, observe(self.problem, state, dt))

    def _first(self) -> float:
        return self.scene.stepping.first * self.scene.until

    def _save(self, position: Progress) -> None:
        if self.folder is not None:
            self.folder.save(position, len(self.history), self._seconds(), self._parts())
            self.saved = perf_counter()

    def _seconds(self) -> float:
        return self.spent + perf_counter() - self.began

    def _parts(self) -> dict[str, float]:
        parts = [*self.parts, *(part for part in self.marching if part not in self.parts)]
        return {part: self.parts.get(part, 0.0) + self.marching.get(part, 0.0) for part in parts}


def _due(before: float, now: float, scene: Scene, frames: int) -> bool:
    """Return whether one of `frames` evenly spaced times, or of the scene's stops, lies in (before, now]."""
    share, slack = frames / scene.until, 1e-12 * scene.until
    stopped = any(before < stop - slack and stop <= now + slack for stop in scene.stepping.stops)
    return stopped or int(now * share + 1e-9) > int(before * share + 1e-9)
