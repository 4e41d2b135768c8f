"""turingfold run and draw: scenes of a case one after the other or in processes, then its figure."""

from __future__ import annotations

import argparse
import csv
import io
import logging
import signal
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

from ..errors import SolveError
from ..figures.style import mark_unfinished, sulci
from ..results.codec import Arrays
from ..results.document import rebuilt, stored
from ..results.files import write_whole
from ..results.folder import check_folder
from ..results.history import read_history
from ..results.result import Result, Row, length_unit, read_result
from ..results.simulate import CoarseMeshWarning, coarseness, simulate
from ..scene import Scene
from .case import Case, explained, folder_name, load_case
from .figure import figure_path, save_figure
from .status import STOPPED, complain, run_command

Report = Callable[[str, Row, int], None]  # scene, newest row, Newton iterations so far
BENT = 0.02  # difference of the two gyrification indices from which both are told
POLL = 0.2  # s between looks at what other processes have done


@dataclass(frozen=True)
class Job:
    """A scene to run: where its case is and where its result goes."""

    case: Path
    name: str
    folder: Path
    resume: bool
    overwrite: bool


def run(options: argparse.Namespace) -> int:
    """Run the scenes of a case, say what became of them, draw the figure; return the exit status."""
    return run_case(load_case(options.case), options)


def run_case(case: Case, options: argparse.Namespace) -> int:
    """Do that with a case that was read, and perhaps is varied."""
    warnings.simplefilter("ignore", CoarseMeshWarning)  # it is said once, of all scenes
    scenes = case.scenes(quick=options.quick, only=options.only or ())
    base = results_of(case, options)
    jobs = [
        Job(options.case, name, base / folder_name(name), options.resume, options.overwrite)
        for name in scenes
    ]
    _check_folders(jobs, scenes)
    with progress(scenes) as report:
        if options.jobs > 1:
            stopped = _together(jobs, scenes, options.jobs, report)
        else:
            stopped = _in_turn(jobs, scenes, report)
    begun = [job for job in jobs if (job.folder / "states").is_dir()]
    results = {job.name: read_result(job.folder, known=case.known) for job in begun}
    _warn_if_coarse(results)
    for line in told(case.name, results, base):
        print(line)
    for name, message in stopped.items():
        complain(f"{name}: {message}")
    if case.draw is not None:
        if missing := _without_result(_drawn(case, options), base):
            print(f"figure: not drawn, these scenes have no result yet: {', '.join(missing)}")
        else:
            print(f"figure: {draw(case, options)}")
    return STOPPED if stopped else 0


def _check_folders(jobs: Iterable[Job], scenes: Mapping[str, Scene]) -> None:
    """Raise ValueError, before anything is run, where one of the scenes may not write to its folder."""
    for job in jobs:
        try:
            document, _ = stored(scenes[job.name])
            check_folder(job.folder, document, resume=job.resume, overwrite=job.overwrite)
        except ValueError as error:
            raise _of_scene(job, error) from error


def _without_result(names: Iterable[str], base: Path) -> list[str]:
    return [name for name in names if not (base / folder_name(name) / "states").is_dir()]


def _warn_if_coarse(results: Mapping[str, Result]) -> None:
    few = min((r.scene.body.elements_through_cortex for r in results.values()), default=float("inf"))
    if words := coarseness(few):
        print(f"turingfold: note: {words}", file=sys.stderr)


def results_of(case: Case, options: argparse.Namespace) -> Path:
    """Return the folder of a case's results: DIR/<case>, by default in results or results/quick."""
    out: Path = options.out or (Path("results/quick") if options.quick else Path("results"))
    return out / case.name


def write_table(path: Path, columns: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """Write a table as CSV, at once, and say where; None is written as nothing."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows(rows)
    write_whole(path, text.getvalue().encode())
    print(f"table: {path}")


def draw(case: Case, options: argparse.Namespace) -> Path:
    """Draw a case's figure from its stored results and return where it is."""
    if case.draw is None:
        raise ValueError(f"{case.path} has no function draw(results, figure), so it has no figure.")
    base = results_of(case, options)
    names = _drawn(case, options)
    if missing := _without_result(names, base):
        which = "no results" if len(missing) == len(names) else f"no results of {', '.join(missing)}"
        if case.variation:  # of which single scenes cannot be chosen
            command = run_command(options, options.only or (), "--resume")
        else:
            command = run_command(options, missing if len(missing) < len(names) else ())
        raise ValueError(f"{base} holds {which}; run the case first: {command}")
    results = {name: read_result(base / folder_name(name), known=case.known) for name in names}
    apart = bool(options.quick or options.out is not None or case.variation)
    path = figure_path(case.path.with_stem(case.name), base, apart=apart)
    with explained(case.path), save_figure(path) as figure:
        case.draw(results, figure)
        mark_unfinished(figure, results)
    return path


def _drawn(case: Case, options: argparse.Namespace) -> dict[str, Scene]:
    """Return the scenes that the figure shows: all of a case, the chosen ones of a variation."""
    return case.scenes(quick=options.quick, only=(options.only or ()) if case.variation else ())


def _in_turn(jobs: list[Job], scenes: Mapping[str, Scene], report: Report) -> dict[str, str]:
    """Run scenes one after the other; return the messages of those that stopped."""
    stopped = {}
    for job in jobs:
        spent = 0

        def show(row: Row, name: str = job.name) -> None:
            nonlocal spent
            spent += int(row["newton_iterations"])
            report(name, row, spent)

        try:
            simulate(
                scenes[job.name], job.folder, progress=show, resume=job.resume, overwrite=job.overwrite
            )
        except SolveError as error:
            stopped[job.name] = str(error)
        except ValueError as error:
            raise _of_scene(job, error) from error
    return stopped


def _together(
    jobs: list[Job], scenes: Mapping[str, Scene], count: int, report: Report
) -> dict[str, str]:
    """Run scenes in `count` processes; return the messages of those that stopped.

    The processes get the scenes as they are stored: a case may take long to make them. Ctrl-C reaches this
    process only; the others stop after the step they are in.
    """
    context = get_context("spawn")
    halt = context.Event()
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the processes inherit this
    with ProcessPoolExecutor(count, mp_context=context, initializer=_prepare, initargs=(halt,)) as pool:
        futures = {pool.submit(_alone, job, *stored(scenes[job.name])): job for job in jobs}
        signal.signal(signal.SIGINT, handler)
        running: set[Future[str]] = set(futures)
        try:
            while running:
                done, running = wait(running, timeout=POLL)
                for future in [*done, *(f for f in running if f.running())]:
                    rows = read_history(futures[future].folder)
                    if rows:
                        spent = int(sum(row["newton_iterations"] for row in rows))
                        report(futures[future].name, rows[-1], spent)
                for future in done:
                    if isinstance(error := future.exception(), ValueError):
                        raise _of_scene(futures[future], error) from error
                    future.result()
        except BaseException:
            halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
        return {job.name: future.result() for future, job in futures.items() if future.result()}


def _of_scene(job: Job, error: ValueError) -> ValueError:
    return ValueError(f"{job.case}, scene {job.name!r}: {error}")


_halt: list[Event] = []  # of this process, set by the one that started it


def _prepare(halt: Event) -> None:
    logging.getLogger("skfem").setLevel(logging.ERROR)
    warnings.simplefilter("ignore", CoarseMeshWarning)
    _halt.append(halt)


def _alone(job: Job, document: dict[str, Any], arrays: Arrays) -> str:
    """Run one stored scene in a process of its own; return why it stopped, or nothing."""

    def heed(row: Row) -> None:
        if any(halt.is_set() for halt in _halt):
            raise KeyboardInterrupt

    scene = rebuilt(document, arrays, load_case(job.case).known)
    try:
        simulate(scene, job.folder, progress=heed, resume=job.resume, overwrite=job.overwrite)
    except SolveError as error:
        return str(error)
    return ""


@contextmanager
def progress(scenes: Mapping[str, Scene]) -> Iterator[Report]:
    """Show a bar per scene on the terminal; silent where standard error is none."""
    if not sys.stderr.isatty():
        yield lambda name, row, iterations: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(),
        TextColumn("growth {task.fields[growth]:.3f}, {task.fields[iterations]} iterations,"),
        TimeRemainingColumn(), TextColumn("left"),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True)) as bars:
        tasks = {
            name: bars.add_task(name, total=scene.until, growth=1.0, iterations=0)
            for name, scene in scenes.items()
        }

        def report(name: str, row: Row, iterations: int) -> None:
            bars.update(tasks[name], completed=row["time"], growth=row["growth"], iterations=iterations)

        yield report


def told(case: str, results: Mapping[str, Result], base: Path) -> Iterator[str]:
    """Yield what a person wants to know: five lines for one scene, a line each for several.

    Lengths are in mm, or in cortical thicknesses for bodies in units of their own (`results.length_unit`).
    """
    summaries = {name: result.summary() for name, result in results.items()}
    if len(results) != 1:
        width = max(map(len, results), default=0)
        for name, s in summaries.items():
            yield (
                f"{name:<{width}}  growth {s['growth']:.2f}  {sulci(s['folds']):>9}  gyrification "
                f"{s['gyrification_index']:.2f}  {_gyri(s['registration'])}  {s['steps']} steps, "
                f"{s['seconds']:.0f} s{'' if s['converged'] else '  ' + s['status'].upper()}"
            )
        yield f"results: {base}"
        return
    name, s = next(iter(summaries.items()))
    end = results[name].unfinished or "reached the end"
    yield (
        f"{case}, {name}: {end} at growth {s['growth']:.2f} in {s['seconds']:.0f} s ({s['steps']} steps, "
        f"{s['newton_iterations']} Newton iterations, {s['dofs']} unknowns)"
    )
    unit, word = length_unit(results[name].scene.body)
    thickness = " (T: cortical thickness)" if word == "T" else ""
    deep = f", {s['sulcal_depth'] / unit:.2f} {word} deep on average{thickness}" if s["folds"] else ""
    hull, closed = s["gyrification_index"], s["closed_gyrification_index"]
    index = f"gyrification index {hull:.2f}"
    if abs(hull - closed) > BENT:
        disc = f"the closing by a disc of radius {s['closing_radius'] / unit:.2g} {word}"
        index += f" against the convex hull, {closed:.2f} against {disc}"
    yield f"folds: {sulci(s['folds'])}{deep}; {index}"
    gap = "no contact"
    if s["min_gap"] is not None:
        gap = f"smallest gap between walls {s['min_gap'] / unit:.2g} {word}"
    jacobian = "" if s["min_jacobian"] is None else f"; smallest J* {s['min_jacobian']:.2f}"
    if s["inverted_elements"]:
        jacobian += f"; {s['inverted_elements']} element(s) turned over at a corner: use smaller ones"
    yield f"walls: {gap}; {s['self_intersections']} self-intersections{jacobian}"
    chance = ""
    if s["registration"]:
        chance = f"; {100 * s['registration_p']:.1f} % of the pattern's phases register as well or better"
    yield f"pattern: {_gyri(s['registration'])}{chance}"
    yield f"results: {base / folder_name(name)}"


def _gyri(registration: float | None) -> str:
    """Return where the gyri stand, as text."""
    if registration is None:
        return "no pattern"
    if abs(registration) < 0.5:
        return f"registration {registration:+.2f}"
    where = "on" if registration > 0 else "between"
    return f"registration {registration:+.2f}, gyri {where} the activator's peaks"
