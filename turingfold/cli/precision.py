"""turingfold run --accuracy: elements and steps as fine as their estimated errors have to be.

The case is run coarsely; the estimates of its results say how much finer it must be; it is run again, until
the estimates are as small as asked and two runs on different meshes agree. A run is taken to be off at least
by what another's estimate leaves of their difference, and by what that tells if errors fall as the size of
the elements. A run that stops, or of whose errors there is no estimate, is followed by a finer one. The best
run is kept.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..results.files import read_json, writing
from ..results.reading import Ending, read_ending
from ..results.simulate import ENOUGH
from ..results.softness import soft_words
from .case import Case, find_case, folder_name
from .outcome import Outcome
from .plan import Planned, base_folder, given_values, planned
from .request import Request, Running
from .run import answered, check_figure, outcomes
from .status import STOPPED, Answer, Interrupted, complain, say
from .summary import named
from .trials import Errors, Size, Trial, confirmed, judged_anew, onward

ELEMENTS = "elements"
FIRST = 0.5  # elements of the first run, as a share of the case's own, and at least ENOUGH
ASIDE = ".best"  # folder of the best run while another one takes its place
FINAL = ("refused", "killed", "failed", "interrupted")  # ends of a run after which no other would do better


def run_to(accuracy: float, request: Request, running: Running) -> Answer:
    """Run the scenes of a case with elements and steps that leave relative errors of at most `accuracy`.

    The numbers are energy, pial length, gyrification index and sulcal depth. Exit status 3 where the
    estimates do not say that it was reached; what is kept is then the run with the smallest errors.
    Raises ValueError where no run has an estimate, and where a search that was killed left its best run
    beside another result.
    """
    case = find_case(request.case)
    _check(case, request, running)
    own = case.provenance(given_values(case, request)[0], quick=request.quick)["parameters"][ELEMENTS]
    search = _Search(case, request, running)
    first = Size(_allowed(case, max(ENOUGH, FIRST * own)))
    _say_moved(search, first, _move_back(search.base))
    size: Size | None = first
    try:
        while size is not None:
            search.run(size)
            size = search.next(accuracy)
    except Interrupted:
        if not search.trials:
            raise
        complain(f"the run with {search.trials[search.kept].size} is kept")
        raise KeyboardInterrupt from None
    return search.answer(accuracy)


@dataclass
class _Search:
    """Runs of a case, and how the scenes of the last and of the best one ended."""

    case: Case
    request: Request
    running: Running
    trials: list[Trial] = field(default_factory=list)
    ends: list[Outcome] = field(default_factory=list)
    kept: int = 0  # number of the run whose results are kept
    kept_ends: list[Outcome] = field(default_factory=list)

    @property
    def base(self) -> Path:
        """The folder of the case's results."""
        return base_folder(self.case, self.request)

    def asked(self, size: Size) -> Request:
        """Return the request for a run."""
        return replace(self.request, assigned=(*self.request.assigned, (ELEMENTS, f"{size.elements:g}")))

    def how(self, size: Size) -> Running:
        """Return how a run is taken: it may replace the one before."""
        again = self.running.overwrite or bool(self.trials)
        return replace(self.running, shorter=size.shorter, overwrite=again)

    def run(self, size: Size) -> None:
        """Run all scenes, judge what comes of it, and say so."""
        asked = self.asked(size)
        plan = planned(self.case, asked)
        check_figure(self.case, plan, asked)
        _refuse_motion(self.case, plan)
        with self._another(plan):
            self.ends = list(outcomes(self.case, plan, asked, self.how(size)))
            last = _judged(size, self.base, plan, self.ends)
            self.trials = judged_anew([*self.trials, last])
            if not self.kept_ends or self.trials[-1].rank < self.trials[self.kept].rank:
                self.kept, self.kept_ends = len(self.trials) - 1, self.ends
        say(f"run {len(self.trials)}, {size}: {_told(self.trials[-1], plan)}")

    @contextmanager
    def _another(self, plan: Sequence[Planned]) -> Iterator[None]:
        """Put the best run aside for another one, and back unless that one is better."""
        count, aside = len(self.trials), self.base / ASIDE
        if count:
            _move(self.base, aside, plan)
        try:
            yield
        finally:
            if count:
                if self.kept != count:
                    _move(aside, self.base, plan)
                shutil.rmtree(aside, ignore_errors=True)

    def next(self, accuracy: float) -> Size | None:
        """Return the size of the next run; None where the accuracy is reached, or there is none to try."""
        limited = math.isfinite(self.running.max_seconds)  # a finer run would need longer
        reached = self.trials[self.kept].worst <= accuracy and confirmed(self.trials)
        if reached or any(end.status in FINAL or (limited and end.status == "stopped") for end in self.ends):
            return None
        return onward(self.trials, accuracy, lambda elements: _allowed(self.case, elements))

    def answer(self, accuracy: float) -> Answer:
        """Say what was reached, and what the best run has found; raises ValueError without an estimate."""
        own = self.trials[self.kept]
        plan = planned(self.case, self.asked(own.size))
        believed = confirmed(self.trials)
        if own.errors is None and not own.soft and all(end.status == "converged" for end in self.kept_ends):
            raise ValueError(
                f"{self.case.shown}, {own.size}: --accuracy finds no estimate of its errors: {own.why}; "
                f"leave --accuracy out, or set {ELEMENTS} by hand."
            )
        answer = answered(self.case, plan, self.kept_ends, self.asked(own.size), self.how(own.size))
        if own.errors is None and not own.soft:
            return answer
        others = [one.errors for one in self.trials if one is not own and one.errors is not None]
        if own.errors is not None and any(other.folds != own.errors.folds for other in others[-1:]):
            say("accuracy: other runs have another number of sulci; errors are those of one branch")
        runs = [{**_facts(one.size, one.worst), "no_errors": one.why} for one in self.trials]
        worst = own.worst if believed else math.inf
        facts = {"asked": accuracy, **_facts(own.size, worst), "runs": runs}
        reached = max(answer.status, _reached(accuracy, worst, own.size))
        return Answer(reached, {**answer.facts, "accuracy": facts})


def _check(case: Case, request: Request, running: Running) -> None:
    """Raise ValueError for a case and for options that leave nothing to choose or to judge by."""
    if ELEMENTS not in case.parameters:
        raise ValueError(
            f"--accuracy chooses the parameter {ELEMENTS!r}, and {case.shown} has none (it has: "
            f"{', '.join(case.parameters) or 'no parameters'}); give its scenes {ELEMENTS}=, or leave "
            "--accuracy out."
        )
    if ELEMENTS in dict(request.assigned):
        raise ValueError(f"--accuracy chooses {ELEMENTS}; leave --set {ELEMENTS}=... or --accuracy out.")
    if running.resume:
        raise ValueError("--accuracy runs each mesh from its start; leave --resume or --accuracy out.")
    if not running.errors:
        raise ValueError("--accuracy judges by estimated errors; leave --no-errors or --accuracy out.")


def _refuse_motion(case: Case, plan: Sequence[Planned]) -> None:
    for one in plan:
        for term in one.scene.terms:
            if term.resists_motion:
                raise ValueError(
                    f"{case.shown}, scene {one.name!r}: --accuracy needs estimated errors of the mesh, which "
                    f"motions ({type(term).__name__}) have none of; see turingfold accuracy."
                )


def _allowed(case: Case, elements: float) -> float:
    """Return a number of elements that the parameter may have: to a tenth, or whole."""
    parameter = case.parameters[ELEMENTS]
    rounded = math.ceil(elements) if parameter.kind is int else math.ceil(10 * elements - 1e-9) / 10
    return min(max(rounded, parameter.meaning.low), parameter.meaning.high)


def _move(source: Path, target: Path, plan: Sequence[Planned]) -> None:
    """Move the folders of scenes into another one, in place of those that it has."""
    with writing(target):
        target.mkdir(exist_ok=True)
        for name in (folder_name(one.name) for one in plan):
            if (target / name).exists():
                shutil.rmtree(target / name)
            if (source / name).exists():
                (source / name).rename(target / name)


def _say_moved(search: _Search, size: Size, names: Sequence[str]) -> None:
    """Say what was moved back; raises ValueError where the search would have to replace it, and may not."""
    words = f"{search.base}: the best run of a search that was killed is moved back from {ASIDE}"
    own = {folder_name(one.name) for one in planned(search.case, search.asked(size))}
    if own.intersection(names) and not search.running.overwrite:
        raise ValueError(
            f"{words}, so that the folder already holds a result; keep that (turingfold draw shows it), "
            "replace it by a new search with --overwrite, or search in another folder (--out DIR)."
        )
    if names:
        say(words)


def _move_back(base: Path) -> list[str]:
    """Move the best run of a search that was killed back, in place of the one that it was killed in.

    Returns the folders of its scenes.

    Raises ValueError, and moves nothing, where that would replace any other result, or one being written.
    """
    aside = base / ASIDE
    names = sorted(found.name for found in aside.iterdir() if found.is_dir()) if aside.is_dir() else []
    kept = [name for name in names if (base / name).exists() and read_ending(base / name) != Ending()]
    if kept:
        raise ValueError(
            f"{aside} holds the best run of a search that was killed or still runs, and {base} has another "
            f"result of {', '.join(kept)}; wait for that search, or keep one of them: delete {aside}, or put "
            f"its folders in place of those in {base}."
        )
    for name in names:
        with writing(base):
            shutil.rmtree(base / name, ignore_errors=True)
            (aside / name).rename(base / name)
    if names:
        shutil.rmtree(aside, ignore_errors=True)
    return names


def _judged(size: Size, base: Path, plan: Sequence[Planned], ends: Sequence[Outcome]) -> Trial:
    """Return a run as what it left in its folder says of its errors, or why it says nothing."""
    for end in ends:
        if end.status != "converged":
            return Trial(size, why=f"scene {end.name!r}: {end.message}")
    found, folds = [], {}
    for one in plan:
        summary = read_json(base / folder_name(one.name) / "summary.json")
        for errors in ("errors", "step_errors"):
            if not summary[errors]:
                return Trial(size, why=f"scene {one.name!r}: {summary[f'no_{errors}']}")
        soft = soft_words(summary["softness"])
        if summary["softness"] is None:
            soft = "how near it is to a limit of stability is not known"
        if soft:
            return Trial(size, why=f"scene {one.name!r}: {soft}", soft=True)
        sizes = {"sulcal_depth": one.scene.body.thickness}  # of a number that is nothing, such as no depth
        for name in summary["errors"]:
            if unit := abs(summary[name]) or sizes.get(name, 0.0):
                found.append(((one.name, name), unit, summary))
        folds[one.name] = summary["folds"]
    return Trial.judged(size, Errors(
        values={key: summary[key[1]] for key, _, summary in found},
        units={key: unit for key, unit, _ in found},
        mesh={key: abs(summary["errors"][key[1]]) / unit for key, unit, summary in found},
        steps={key: abs(summary["step_errors"].get(key[1], 0.0)) / unit for key, unit, summary in found},
        folds=folds,
    ), [])  # fmt: skip


def _facts(size: Size, reached: float) -> dict[str, float | None]:
    worst = reached if math.isfinite(reached) else None
    return {"elements": size.elements, "shorter_steps": size.shorter, "reached": worst}


def _told(trial: Trial, plan: Sequence[Planned]) -> str:
    if trial.errors is None:
        return f"no estimate of its errors, {trial.why}"
    scene, number = trial.of
    of = named(number) if len(plan) == 1 else f"{named(number)} of {scene}"
    return f"errors of up to {_percent(trial.worst)} ({of})"


def _reached(accuracy: float, worst: float, size: Size) -> int:
    """Say what was reached; return the exit status."""
    if worst <= accuracy:
        say(f"accuracy: {_percent(worst)} by the estimates, asked {_percent(accuracy)}; {size}")
        return 0
    if not math.isfinite(worst):
        complain(
            f"--accuracy {_percent(accuracy)} was not reached: there are no two runs to compare that ended "
            f"well, finer than any near a limit of stability; {size} is kept."
        )
        return STOPPED
    complain(
        f"--accuracy {_percent(accuracy)} was not reached: {size}, the best run, leaves errors of up to "
        f"{_percent(worst)} by the estimates."
    )
    return STOPPED


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
