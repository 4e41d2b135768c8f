"""Scenes run in this process one after the other, or in several processes at a time.

A process gets a scene as it is stored, for a case may take long to make it, or a point of a study, whose
scene it makes; it sends back each row of the history, and stays for the next. One that is killed takes only
its scene with it; all end when the process that started them does.
"""

from __future__ import annotations

import logging
import signal
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from ..errors import SolveError
from ..geometry.changes import OutlineWarning
from ..results.document import rebuilt, stored
from ..results.result import Row
from ..results.simulate import FRAMES, CoarseMeshWarning, simulate
from ..scene import Scene
from .case import load_case
from .outcome import Outcome
from .point import Maker, Point, run_point
from .request import Running, Telling
from .status import note

Report = Callable[[str, Row, int], None]  # scene, newest row, Newton iterations so far


@dataclass(frozen=True)
class Job:
    """A scene to run: file of its case, its name, folder of its result, and what is stored with that."""

    case: Path
    name: str
    scene: Scene | None  # None where it is sent as it is stored
    folder: Path
    provenance: Mapping[str, Any]


def run_jobs(
    jobs: deque[Job] | deque[Point], running: Running, report: Report, maker: Maker | None = None
) -> Iterator[Outcome]:
    """Run scenes or points, take them off the list, and yield how each ended.

    maker: of points that are run in this process.  Raises OSError where writing fails.
    """
    if running.jobs == 1:
        while jobs:
            job = jobs.popleft()
            progress = _counting(job.name, report)
            if isinstance(job, Point):
                yield run_point(job, maker, progress)
            else:
                assert job.scene is not None
                yield _run(job, job.scene, running, progress)
            del job  # before the next is run
    else:
        yield from _together(jobs, running, report)


def _run(job: Job, scene: Scene, running: Running, progress: Callable[[Row], object]) -> Outcome:
    try:
        result = simulate(
            scene, job.folder, progress=progress, resume=running.resume, overwrite=running.overwrite,
            case=job.provenance, errors=running.errors, vtu=running.vtu,
            frames=FRAMES if running.frames is None else running.frames,
        )  # fmt: skip
    except SolveError as error:
        return Outcome(job.name, "stopped", str(error))
    except ValueError as error:
        return Outcome(job.name, "refused", str(error))
    return Outcome(job.name, result.status, result.message)


def _counting(name: str, report: Report) -> Callable[[Row], None]:
    spent = 0

    def progress(row: Row) -> None:
        nonlocal spent
        spent += int(row["newton_iterations"])
        report(name, row, spent)

    return progress


@dataclass(frozen=True)
class _Worker:
    process: Any
    link: Connection


def _together(jobs: deque[Job] | deque[Point], running: Running, report: Report) -> Iterator[Outcome]:
    busy: dict[_Worker, tuple[Job | Point, Callable[[Row], None]]] = {}
    idle: list[_Worker] = []
    try:
        while jobs or busy:
            while jobs and len(busy) < running.jobs:
                worker = idle.pop() if idle else _started()
                job = jobs.popleft()
                worker.link.send(_sent(job, running))
                busy[worker] = job, _counting(job.name, report)
            for link in connection.wait([worker.link for worker in busy]):
                worker = next(own for own in busy if own.link is link)
                job, progress = busy[worker]
                try:
                    sent = worker.link.recv()
                except (EOFError, OSError):
                    del busy[worker]
                    yield Outcome(job.name, "killed", _death(worker.process))
                    continue
                if isinstance(sent, dict):
                    progress(sent)
                    continue
                del busy[worker]
                idle.append(worker)
                if isinstance(sent, BaseException):
                    raise sent
                yield sent
    finally:
        for worker in [*busy, *idle]:
            worker.link.close()  # they end after the step they are in
        for worker in [*busy, *idle]:
            worker.process.join()


def _sent(job: Job | Point, running: Running) -> tuple[Any, ...]:
    if isinstance(job, Point):
        return job, running
    assert job.scene is not None
    return replace(job, scene=None), running, *stored(job.scene)


def _started() -> _Worker:
    """Start a process; Ctrl-C reaches the one that started it only."""
    context = get_context("spawn")
    link, other = context.Pipe()
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process inherits this
    try:
        process = context.Process(target=_serve, args=(other,), daemon=True)
        process.start()
    finally:
        signal.signal(signal.SIGINT, handler)
    other.close()
    return _Worker(process, link)


def _death(process: Any) -> str:
    process.join()
    code = process.exitcode or 0
    by = f"by {signal.Signals(-code).name}" if code < 0 else f"with status {code}"
    return f"the process that ran it ended {by}; was there enough memory?"


def _serve(link: Connection) -> None:
    """Run the scenes that are sent until the other end of the link is closed."""
    logging.getLogger("skfem").setLevel(logging.ERROR)
    warnings.showwarning = note
    sys.stdout = sys.stderr  # what a case prints is no answer of the command's

    def progress(row: Row) -> None:
        try:
            link.send(row)
        except OSError:  # the process that started this one has ended, or was told to
            raise KeyboardInterrupt from None

    maker = Maker()
    with suppress(EOFError, OSError, KeyboardInterrupt):
        while True:
            job, running, *rest = link.recv()
            quiet = running.telling is Telling.NOTHING
            warnings.simplefilter("ignore" if quiet else "default", UserWarning)
            for told in (CoarseMeshWarning, OutlineWarning):  # of all, by the process that started this one
                warnings.simplefilter("ignore", told)
            try:
                answer: Any
                if isinstance(job, Point):
                    answer = run_point(job, maker, progress)
                else:
                    document, arrays = rest
                    scene = rebuilt(document, arrays, load_case(job.case).known)
                    answer = _run(job, scene, running, progress)
            except OSError as error:  # results cannot be written: nor can those of the other scenes
                answer = error
            link.send(answer)
