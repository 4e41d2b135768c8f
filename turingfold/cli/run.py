"""turingfold run and draw: scenes of a case one after the other or in processes, then its figure."""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..figures.style import mark_unfinished
from ..results.document import stored
from ..results.files import read_json
from ..results.folder import check_folder
from ..results.loading import read_result
from ..results.reading import read_summary
from ..results.result import Result
from ..results.simulate import ENOUGH, CoarseMeshWarning, coarseness
from .case import Case, explained, find_case, folder_name
from .computed import compute, read_computed
from .figure import figure_path, save_figure
from .idle import idle_words, unusual
from .outcome import STATUSES, Outcome
from .plan import (
    Planned,
    base_folder,
    changed_words,
    given_values,
    has_result,
    planned,
    stored_names,
    without_result,
)
from .progress import watching
from .request import Request, Running, Telling
from .status import Answer, Interrupted, complain, progress, say
from .summary import told
from .table import write_case_table
from .workers import Job, run_jobs


def run(request: Request, running: Running) -> Answer:
    """Run the scenes of a case, say what became of them, draw the figure."""
    case = find_case(request.case)
    plan = planned(case, request)
    check_figure(case, plan, request)
    own, _ = given_values(case, request)
    if words := idle_words(case, own, unusual(case, own), request.only):
        progress(f"note: {words}")
    return answered(case, plan, list(outcomes(case, plan, request, running)), request, running)


def answered(
    case: Case, plan: Sequence[Planned], ends: Sequence[Outcome], request: Request, running: Running
) -> Answer:
    """Say what became of the scenes of a plan that were run, and draw the figure."""
    base, every = base_folder(case, request), plan[0].provenance["scenes"]
    status = finished(ends, case, request)
    begun = [one.name for one in plan if has_result(base, one.name)]
    results = {name: read_result(base / folder_name(name), known=case.known) for name in begun}
    if words := changed_words(plan[0].provenance):
        say(f"parameters: {words}")
    for line in told(case.name, results, base):
        say(line)
    if running.telling is Telling.STEPS:
        for name, result in results.items():
            say(f"time, {name}: {_spent(result)}")
    figure, table = _pictured(case, every, base, results, request, running)
    return Answer(status, {
        "case": case.name, "folder": str(base),
        "scenes": facts_of(ends, base),
        "figures": [str(figure)] if figure else [], "table": str(table) if table else None,
    })  # fmt: skip


def check_figure(case: Case, plan: Sequence[Planned], request: Request) -> None:
    """Raise ValueError where --figure asks for what cannot be drawn."""
    if request.figure is None:
        return
    _drawing(case)
    chosen = {one.name for one in plan}
    others = [name for name in plan[0].provenance["scenes"] if name not in chosen]
    if missing := without_result(base_folder(case, request), others):
        raise ValueError(
            f"--figure: a figure shows all scenes, and these have no result yet: {', '.join(missing)}; run "
            "them too, or leave --figure out."
        )


def _pictured(
    case: Case, every: Sequence[str], base: Path, results: Mapping[str, Result], request: Request,
    running: Running,
) -> tuple[Path | None, Path | None]:  # fmt: skip
    """Draw the figure of a case and write its table, where it has them and all scenes have a result."""
    if case.draw is None and case.table is None:
        return None, None
    if missing := without_result(base, every):
        say(f"figure: not drawn, these scenes have no result yet: {', '.join(missing)}")
        return None, None
    others = set(every) - set(results)
    results = dict(results) | {
        name: read_result(base / folder_name(name), known=case.known) for name in others
    }
    results = {name: results[name] for name in every}
    compute(case, results, base, keep=running.resume)
    figure = None
    if case.draw is not None:
        figure = drawn(case, results, request, apart=bool(request.assigned))
        say(f"figure: {figure}")
    if table := write_case_table(case, results, base):
        say(f"table: {table}")
    return figure, table


def facts_of(ends: Sequence[Outcome], base: Path) -> dict[str, Any]:
    """Return by scene how it ended, and the numbers of its last state, as its folder has them."""
    return {end.name: _facts(end, base / folder_name(end.name)) for end in ends}


def _facts(end: Outcome, folder: Path) -> dict[str, Any]:
    summary = None
    with suppress(ValueError):  # of a folder that was refused
        summary = read_summary(folder)
    return {"status": end.status, "message": end.message, "folder": str(folder), "summary": summary}


def _spent(result: Result) -> str:
    """Return where the time of a run went, the longest first."""
    parts = sorted(result.seconds_by_part.items(), key=lambda part: -part[1])
    return ", ".join(f"{name} {seconds:.2f} s" for name, seconds in parts)


def outcomes(case: Case, plan: Sequence[Planned], request: Request, running: Running) -> Iterator[Outcome]:
    """Return an iterator that runs the scenes of a plan and yields how each ended; it keeps none in memory.

    Raises ValueError, before anything is run, where a folder may not be written to; the iterator raises
    Interrupted for Ctrl-C.
    """
    warnings.simplefilter("ignore", CoarseMeshWarning)  # it is said once, of all scenes
    base = base_folder(case, request)
    jobs = deque(
        Job(
            case.path,
            one.name,
            running.limited(one.scene),
            base / folder_name(one.name),
            {**one.provenance, "command": request.words(*running.words())},
        )
        for one in plan
    )
    for job in jobs:
        assert job.scene is not None
        try:
            document, _ = stored(job.scene, job.provenance)
            check_folder(job.folder, document, resume=running.resume, overwrite=running.overwrite)
        except ValueError as error:
            raise ValueError(f"{case.shown}, scene {job.name!r}: {error}") from error
    scenes = {job.name: job.scene for job in jobs if job.scene is not None}
    few = min((scene.body.elements_through_cortex for scene in scenes.values()), default=float("inf"))
    if words := coarseness(few, finer(case, request)):
        warnings.warn(words, stacklevel=2)
    ends = {name: scene.until for name, scene in scenes.items()}
    return _outcomes(jobs, ends, request, running)


def finer(case: Case, request: Request) -> str:
    """Return how the user gets smaller elements."""
    if request.quick and "elements" not in dict(request.assigned):
        return "drop --quick"
    return f"--set elements={ENOUGH}" if "elements" in case.parameters else "give its body smaller ones"


def _outcomes(
    jobs: deque[Job], ends: Mapping[str, float], request: Request, running: Running
) -> Iterator[Outcome]:
    try:
        with watching(ends, running.telling) as watch:
            for end in run_jobs(jobs, running, watch.row):
                watch.ended(end.name)
                yield end
    except KeyboardInterrupt as error:
        raise Interrupted(request.words(*running.words(), "--resume")) from error


def finished(ends: Sequence[Outcome], case: Case, request: Request) -> int:
    """Say what did not end as asked, and how to go on; return the exit status."""
    for end in ends:
        if end.status == "refused":
            complain(f"{case.shown}, scene {end.name!r}: {end.message}")
        elif end.status == "killed":
            again = request.with_only([end.name] if request.command[0] == "run" else request.only)
            complain(f"{end.name}: {end.message} Go on with: {again.words('--resume')}")
        elif end.message:
            complain(f"{end.name}: {end.message}")
    return max((STATUSES[end.status] for end in ends), default=0)


def draw(request: Request) -> Answer:
    """Draw a case's figure from its stored results and say where it is; raises ValueError without them."""
    request = _named(request)
    case = find_case(request.case)
    base = base_folder(case, request)
    names, changed = stored_names(case, base)
    names = names or [one.name for one in planned(case, request)]
    if missing := without_result(base, names):
        some = len(missing) < len(names)
        which = f"no results of {', '.join(missing)}" if some else "no results"
        command = request.with_only(missing if some else ()).words()
        raise ValueError(f"{base} holds {which}; run the case first: {command}")
    results = {name: read_result(base / folder_name(name), known=case.known) for name in names}
    figure = drawn(case, results, request, apart=changed)
    say(f"figure: {figure}")
    return Answer(0, {"case": case.name, "folder": str(base), "figures": [str(figure)]})


def _named(request: Request) -> Request:
    """Return the request by the name of its case where a folder of results is given: of a case or a scene."""
    given = Path(request.case)
    if not given.is_dir():
        return request
    base = given.parent if (given / "scene.json").exists() else given
    told = next((read_json(file).get("case") for file in sorted(base.glob("*/scene.json"))), None)
    if not isinstance(told, dict) or told.get("name") != base.name:
        raise ValueError(f"{given} holds no results of a case; name a case, or DIR/<case> of turingfold run.")
    return replace(request, case=base.name, out=base.parent, quick=bool(told.get("quick")))


def drawn(case: Case, results: dict[str, Result], request: Request, *, apart: bool) -> Path:
    """Draw a case's figure from results and return where it is; raises ValueError for a case without draw.

    apart: with the results, as they are not those of the case as it is.
    """
    draw = _drawing(case)
    apart = bool(apart or request.quick or request.out is not None)
    base = base_folder(case, request)
    more = () if case.computed is None else (read_computed(case, base),)
    path = request.figure or figure_path(case.path, base, apart=apart)
    with explained(case.path), save_figure(path) as figure:
        draw(results, figure, *more)
        mark_unfinished(figure, results)
    return path


def _drawing(case: Case) -> Callable[..., object]:
    """Return the function of a case that draws; raises ValueError for one without."""
    if case.draw is None:
        raise ValueError(f"{case.shown} has no function draw(results, figure), so it has no figure.")
    return case.draw
