"""Cells in processes of their own, each with a time limit; a table that a later call goes on with."""

from __future__ import annotations

import csv
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context
from pathlib import Path
from time import perf_counter
from typing import Any

from ...errors import SolveError
from ...results.simulate import StoppedError, simulate
from .cells import KINDS, drawn, scene

VALID, TOLD, STOPPED, REFUSED = "valid", "told invalid", "stopped", "refused"
LIE, UNTYPED, HANG = FORBIDDEN = "LIE", "UNTYPED ERROR", "HANG"
OUTCOMES = (VALID, TOLD, STOPPED, REFUSED, *FORBIDDEN)
COLUMNS = ("number", "seed", "outcome", "reason", "seconds", "steps", "iterations", "factorizations")
PATIENCE = 4.0  # times the limit, and STARTING, s, after which a cell that has not answered hangs
STARTING = 30.0
Row = dict[str, Any]
Job = tuple[str, int, int, float]  # kind, number, seed, limit in s


def judged(kind: str, number: int, seed: int, seconds: float) -> Row:
    """Return the row of one cell: what it became, why, and what it took."""
    cell, began = drawn(kind, number, seed), perf_counter()
    effort: Mapping[str, float] = {}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            outcome, reason, effort = _became(kind, cell, seconds)
    except StoppedError as error:
        outcome, reason = STOPPED, str(error)
        effort = _effort(error.result.summary())
    except SolveError as error:
        outcome, reason = STOPPED, f"{type(error).__name__}: {error}"
    except ValueError as error:
        outcome, reason = REFUSED, str(error)
    except Exception as error:  # what a user must never see
        outcome, reason = UNTYPED, f"{type(error).__name__}: {error}"
    spent = perf_counter() - began
    row = {"number": number, "seed": seed, "outcome": outcome, "reason": reason, "seconds": round(spent, 2)}
    return {**row, **{name: effort.get(name, "") for name in COLUMNS[5:]}, **cell}


def _became(kind: str, cell: Mapping[str, Any], seconds: float) -> tuple[str, str, Mapping[str, float]]:
    if kind in ("pattern", "march"):
        from . import patterns

        found, effort = (patterns.steady if kind == "pattern" else patterns.marched)(cell, seconds)
        return LIE if found else VALID, "; ".join(found), effort
    from .judge import faults

    result = simulate(scene(kind, cell, seconds))
    effort = _effort(result.summary())
    if not result.converged:
        return TOLD, result.message, effort
    found = faults(result)
    return LIE if found else VALID, "; ".join(found), effort


def _effort(summary: Mapping[str, Any]) -> dict[str, float]:
    names = {"steps": "steps", "iterations": "newton_iterations", "factorizations": "factorizations"}
    return {name: summary[own] for name, own in names.items()}


@dataclass(frozen=True)
class _Worker:
    process: Any
    link: connection.Connection


def run(
    folder: Path, counts: Mapping[str, int], *, seed: int, seconds: float, jobs: int,
    progress: Callable[[str, Row], object],
) -> dict[str, list[Row]]:  # fmt: skip
    """Return the rows of so many cells of each kind, by number.

    Those in the folder's tables are not run, but for cells that stopped with less time than they have now.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, dict[int, Row]] = {kind: {} for kind in KINDS}
    for kind in KINDS:
        own = [row for row in read(folder, kind) if int(row["seed"]) == seed]
        rows[kind] = {int(row["number"]): row for row in own}
    left = deque(
        (kind, number, seed, seconds)
        for kind in KINDS
        for number in range(counts.get(kind, 0))
        if number not in rows[kind] or _stopped_before(rows[kind][number], seconds)
    )
    for kind, row in _answers(left, seconds, jobs):
        _append(folder, kind, row)
        rows[kind][row["number"]] = row
        progress(kind, row)
    return {kind: [own[number] for number in sorted(own)] for kind, own in rows.items()}


def _stopped_before(row: Row, seconds: float) -> bool:
    return bool(row["outcome"] == STOPPED and float(row["seconds"]) < 0.9 * seconds)


def read(folder: Path, kind: str) -> list[Row]:
    """Return the rows of a kind that a folder has."""
    file = folder / f"{kind}.csv"
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


def _append(folder: Path, kind: str, row: Row) -> None:
    file = folder / f"{kind}.csv"
    new = not file.exists()
    with file.open("a", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, list(row))
        if new:
            writer.writeheader()
        writer.writerow(row)


def _answers(left: deque[Job], seconds: float, jobs: int) -> Iterator[tuple[str, Row]]:
    """Yield the rows of all cells as they come; a process that does not answer is ended."""
    busy: dict[connection.Connection, tuple[_Worker, Job, float]] = {}
    idle: list[_Worker] = []
    limit = PATIENCE * seconds + STARTING
    try:
        while left or busy:
            while left and len(busy) < jobs:
                worker, job = idle.pop() if idle else _started(), left.popleft()
                worker.link.send(job)
                busy[worker.link] = worker, job, perf_counter()
            answered = connection.wait(list(busy), timeout=1.0)
            for link in [*busy]:
                worker, job, since = busy[link]
                if link in answered:
                    del busy[link]
                    try:
                        yield job[0], link.recv()
                        idle.append(worker)
                    except EOFError:
                        yield job[0], _ended(job, UNTYPED, "its process ended", perf_counter() - since)
                elif perf_counter() - since > limit:
                    del busy[link]
                    worker.process.kill()
                    yield job[0], _ended(job, HANG, f"no answer after {limit:.0f} s", limit)
    finally:
        for worker in [*idle, *(own for own, _, _ in busy.values())]:
            worker.process.kill()


def _ended(job: Job, outcome: str, reason: str, spent: float) -> Row:
    kind, number, seed, _ = job
    row = {"number": number, "seed": seed, "outcome": outcome, "reason": reason, "seconds": round(spent, 2)}
    return {**row, **dict.fromkeys(COLUMNS[5:], ""), **drawn(kind, number, seed)}


def _started() -> _Worker:
    context = get_context("spawn")
    link, other = context.Pipe()
    process = context.Process(target=_serve, args=(other,), daemon=True)
    process.start()
    return _Worker(process, link)


def _serve(link: connection.Connection) -> None:
    """Judge cells until who asks is gone."""
    with suppress(EOFError, ConnectionError, KeyboardInterrupt):
        while True:
            link.send(judged(*link.recv()))
