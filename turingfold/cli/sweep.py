"""turingfold sweep: a case's scenes with other values of parameters, side by side; collect: their table."""

from __future__ import annotations

import shutil
import warnings
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..figures.grids import grid
from ..figures.style import sulci
from ..geometry.changes import OutlineWarning
from ..results.files import writing
from ..results.folder import expected_size
from ..results.loading import read_result
from ..results.lock import FolderLock
from ..results.plain import as_plain
from ..results.result import Result
from ..results.simulate import CoarseMeshWarning, coarseness
from ..results.units import is_si
from .case import Case, find_case, folder_name
from .cluster import LOCAL, run_on_cluster
from .design import Design, points
from .figure import save_figure
from .idle import idle_words, unusual
from .notes import note_made
from .outcome import STATUSES, Outcome
from .plan import base_folder, has_result
from .point import RECORD, Maker, Point, frames_of, is_taken
from .progress import watching
from .request import Request, Running, Telling
from .run import finer, finished
from .status import Answer, Interrupted, complain, progress, say
from .study import STUDY, TABLE, Rows, described, ended, read_study, write_study
from .study import collect as collected
from .workers import run_jobs

SIDE_BY_SIDE = 4  # pictures in a row
PAGE = 48  # pictures in a figure
PICTURED = 192  # points; of more, nobody looks at every one
COMPLAINTS = 5  # points of which it is said what went wrong; the table says it of all
RECORD_SIZE = 3e3  # bytes
MB = 1e6


@dataclass(frozen=True)
class Asked:
    """How a study is run, beside the number of processes.

    keep: see `Point`.  task: (I, N) for the I-th of N parts of the study, which schedulers run side by side.
    dask: address of a cluster's scheduler, or "local".
    """

    keep: str = "last"
    task: tuple[int, int] | None = None
    dask: str = ""

    def words(self) -> list[str]:
        """Return the words of the command line that say this."""
        found = ["--keep", self.keep] if self.keep != "last" else []
        found += ["--task", f"{self.task[0]}/{self.task[1]}"] if self.task else []
        return found + (["--dask", self.dask] if self.dask else [])


def sweep(request: Request, design: Design, running: Running, asked: Asked) -> Answer:
    """Run the points of a study, write their numbers in one table, draw them side by side.

    The table grows as points end; points that stop, or that the case refuses, have a row that says why. It is
    of this study alone: results of earlier ones stay in their folders, but are not read.
    """
    case = find_case(request.case)
    base = base_folder(case, request)
    warnings.simplefilter("ignore", OutlineWarning)  # it is noted of the first point
    every, maker = points(case, request, design, base, asked.keep)
    command = request.words(*running.words())
    plan = [replace(one, running=running, command=command) for one in _part(every, asked.task)]
    _check(request, running, asked, plan)
    _note_idle(case, request, every)
    note_made(case, plan[0].given if plan else {}, maker.latest, quick=request.quick)
    again = running.resume or (asked.task is not None and not running.overwrite)
    ends = _ended(plan, running, again=again)
    left = deque(one for one in plan if one.name not in ends)
    remedy = finer(case, request)
    first = few = _announce(plan, left, maker, base, asked.keep, remedy)
    with writing(base):
        base.mkdir(parents=True, exist_ok=True)
    with nullcontext() if asked.task else _locked(base):
        study = described(case, every, request.words(), si=all(map(is_si, maker.latest.values())))
        _begin(base, study, asked.task)
        table = Rows(base / _table(asked.task), plan, ends, study)
        for end in _run(left, request, running, asked, maker):
            ends[end.name] = end
            table.add(end)
            say(_line(end))
            few = min(few, end.summary.get("elements_through_cortex", few))
        table.finish()
    if few < first - 0.01 and (words := coarseness(few, remedy)):
        say(f"note: {words}")
    return _finish(case, request, plan, ends, asked)


def _note_idle(case: Case, request: Request, every: Sequence[Point]) -> None:
    """Say which parameters change nothing at the first point, where another point has another value."""
    first = next(point for point in every if not point.refused)
    given = first.given
    others: dict[str, Any] = {}
    for name in (name for name in first.varied if name in given):
        values = [p.given[name] for p in every if not p.refused and p.given[name] != given[name]]
        others |= {name: values[0]} if values else {}
    if words := idle_words(case, given, unusual(case, given) | others, request.only):
        progress(f"note: {words}")


def _check(request: Request, running: Running, asked: Asked, plan: Sequence[Point]) -> None:
    """Raise ValueError for an option that this study could not heed."""
    undrawn = {
        "--task runs a part of the study": asked.task is not None,
        "--keep summary keeps no states": asked.keep == "summary",
        f"{len(plan)} points are too many side by side": len(plan) > PICTURED,
    }
    unheeded = {
        f"--figure: nothing is drawn, as {why}": holds and request.figure is not None
        for why, holds in undrawn.items()
    } | {
        "--frames: only --keep all keeps the states of points": running.frames and asked.keep != "all",
        "--no-vtu: --keep summary writes no states": not running.vtu and asked.keep == "summary",
        "--jobs: the cluster has workers of its own": running.jobs > 1 and asked.dask not in ("", LOCAL),
        "--verbose: a cluster does not tell of steps": asked.dask and running.telling is Telling.STEPS,
    }
    for words, holds in unheeded.items():
        if holds:
            raise ValueError(f"{words}; leave the option out.")


def _part(plan: Sequence[Point], task: tuple[int, int] | None) -> Sequence[Point]:
    """Return the points of a task: every N-th one, so that neighbours, which take alike, are shared out."""
    return plan if task is None else plan[task[0] - 1 :: task[1]]


def _table(task: tuple[int, int] | None) -> str:
    return TABLE if task is None else f"sweep-task-{task[0]}-of-{task[1]}.csv"


def _ended(plan: Sequence[Point], running: Running, *, again: bool) -> dict[str, Outcome]:
    """Return the points that need not be run again; raises ValueError for folders that are taken."""
    if running.overwrite:
        for one in plan:
            (one.folder / RECORD).unlink(missing_ok=True)
        return {}
    found = {}
    for one in plan:
        if not again and is_taken(one.folder):
            raise ValueError(
                f"{one.folder} already holds a result; choose another folder (--out), go on with the study "
                "(--resume) or replace what is there (--overwrite)."
            )
        if end := ended(one):
            found[one.name] = end
    return found


def _announce(
    plan: Sequence[Point], left: Sequence[Point], maker: Maker, base: Path, keep: str, remedy: str
) -> float:
    """Say how many points there are and what disk they need; return the elements through the cortex.

    remedy: how the user gets smaller elements.
    Raises ValueError where the disk has no room for them.
    """
    first = next((scene for scene in maker.latest.values()), None)
    few = float("inf") if first is None else first.body.elements_through_cortex
    if words := coarseness(few, remedy):
        warnings.warn(words, stacklevel=2)
    done = f", {len(plan) - len(left)} of them done" if len(left) < len(plan) else ""
    size = RECORD_SIZE
    if first is not None and keep != "summary":
        running = plan[0].running
        size += expected_size(first, frames=frames_of(keep, running), vtu=running.vtu)
    place = next(folder for folder in (base, *base.parents) if folder.is_dir())
    free, needed = shutil.disk_usage(place).free, size * len(left)
    words = f"about {needed / MB:.3g} MB of disk, {size / MB:.2g} MB each"
    say(f"{len(plan)} points{done}; --keep {keep} needs {words} ({free / MB:.3g} MB are free)")
    if needed > free:
        raise ValueError(
            f"the study needs {words}, and {free / MB:.3g} MB are free; choose --keep summary, or "
            "another folder (--out)."
        )
    return few


@contextmanager
def _locked(base: Path) -> Iterator[None]:
    with writing(base):
        lock = FolderLock(base)
    try:
        yield
    finally:
        lock.release()


def _begin(base: Path, study: Mapping[str, Any], task: tuple[int, int] | None) -> None:
    """Write study.json; raises ValueError for a task of another study than the one that is there."""
    if task and (base / STUDY).exists():
        if read_study(base)["points"] == study["points"]:
            return
        raise ValueError(
            f"{base} is of a study with other points; tasks of one study differ by --task alone. Choose "
            "another folder (--out), or remove it."
        )
    write_study(base, study)


def _run(
    left: deque[Point], request: Request, running: Running, asked: Asked, maker: Maker
) -> Iterator[Outcome]:
    warnings.simplefilter("ignore", CoarseMeshWarning)  # it is said once, of all points
    untils = {name: scene.until for name, scene in maker.latest.items()}  # about the same for all points
    ends_at = {one.name: untils.get(one.scene, 1.0) for one in left}
    try:
        with watching(ends_at, running.telling, "points") as watch:
            if asked.dask:
                ends = run_on_cluster(left, asked.dask, running.jobs)
            else:
                ends = run_jobs(left, running, watch.row, maker)
            for end in ends:
                yield end
                watch.ended(end.name)
    except KeyboardInterrupt as error:
        raise Interrupted(request.words(*running.words(), "--resume")) from error


def _line(end: Outcome) -> str:
    if not end.summary:
        return f"{end.name}: {end.status}"
    shape = f"{sulci(end.summary['folds'])}, gyrification {end.summary['gyrification_index']:.2f}"
    when = "" if end.status == "converged" else f" at t = {end.summary['time']:.6g}"
    return f"{end.name}: {end.status}{when} at growth {end.summary['growth']:.2f}, {shape}"


def _finish(
    case: Case, request: Request, plan: Sequence[Point], ends: Mapping[str, Outcome], asked: Asked
) -> Answer:
    """Say what came of the study and draw the points side by side."""
    base = base_folder(case, request)
    _complain(ends.values(), case, request)
    status = max(STATUSES[end.status] for end in ends.values())
    table = base / _table(asked.task)
    _tell(ends.values(), table)
    figures: list[Path] = []
    if asked.task:
        say(f"when all tasks have ended: turingfold collect {base}")
    else:
        figures = _pictured(case, plan, base, request.figure or base / f"{case.name}-sweep.png")
    varied = {one.name: one.varied for one in plan}
    return Answer(status, {
        "case": case.name, "folder": str(base), "table": str(table), "figures": [str(one) for one in figures],
        "points": [
            {
                "name": name, "varied": dict(own), "status": ends[name].status, "message": ends[name].message,
                "summary": as_plain(dict(ends[name].summary)) or None,
            }
            for name, own in varied.items()
        ],
    })  # fmt: skip


def _complain(ends: Iterable[Outcome], case: Case, request: Request) -> None:
    """Say what did not end as asked; what is the same of many points is said once."""
    said: dict[str, list[Outcome]] = {}
    for end in ends:
        if end.message:
            said.setdefault(end.message, []).append(end)
    groups = list(said.values())
    for first, *more in groups[:COMPLAINTS]:
        finished([first], case, request)
        if more:
            complain(f"{len(more)} more points: the same.")
    if left := sum(map(len, groups[COMPLAINTS:])):
        complain(f"{left} more points have a message; the table has them all.")


def _pictured(case: Case, plan: Sequence[Point], base: Path, file: Path) -> list[Path]:
    """Draw the points side by side, on several pages if need be, and return the files."""
    shown = [one.name for one in plan if has_result(base, one.name)]
    if len(shown) > PICTURED:
        say(f"figure: not drawn, {len(shown)} points are too many side by side; see turingfold plot {base}")
        return []
    found = []
    for path, page in _pages(shown, file):
        with save_figure(path) as figure:
            draw(figure, Stored(base, page, case))
        say(f"figure: {path}")
        found.append(path)
    return found


def _tell(ends: Iterable[Outcome], table: Path) -> None:
    kinds = [end.status for end in ends]
    words = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
    say(f"{len(kinds)} points: {words}")
    say(f"table: {table}")


def collect(base: Path) -> Answer:
    """Write the table of a study from the records of its points, whichever task or machine has run them."""
    table, ends = collected(base)
    _tell(ends, table)
    kinds = [end.status for end in ends]
    counts = {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)}
    return Answer(0, {"folder": str(base), "table": str(table), "points": counts})


class Stored(Mapping[str, tuple[Result, int]]):
    """The last states of stored results, each loaded when it is looked up, and not kept."""

    def __init__(self, base: Path, names: Sequence[str], case: Case) -> None:
        self.base, self.names, self.case = base, names, case

    def __getitem__(self, name: str) -> tuple[Result, int]:
        """Return a result and its last step."""
        return read_result(self.base / folder_name(name), known=self.case.known), -1

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter(self.names)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.names)


def draw(figure: Any, results: Stored) -> None:
    """Draw the last state of each result, with its numbers."""
    grid(figure, results, columns=min(len(results), SIDE_BY_SIDE))


def _pages(names: Sequence[str], path: Path) -> Iterator[tuple[Path, Sequence[str]]]:
    """Yield the files of figures with the names that each shows."""
    for k in range(0, len(names), PAGE):
        yield path if k == 0 else path.with_stem(f"{path.stem}-{k // PAGE + 1}"), names[k : k + PAGE]
