"""turingfold run --accuracy: elements and steps as fine as their estimated errors have to be.

The case is run coarsely; the estimates of its results say how much finer it must be; it is run again, until
the estimates are as small as asked. Where two runs differ by more than the coarser one's estimate, the finer
one is taken to be off by the rest at least.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..results.files import read_json
from .case import Case, find_case, folder_name
from .plan import Planned, base_folder, given_values, planned
from .request import Request, Running
from .run import answered, check_figure, outcomes
from .status import STOPPED, Answer, complain, say
from .summary import named

ELEMENTS = "elements"
FIRST, FEWEST = 0.5, 2.0  # elements of the first run: share of the case's own, and at least
LONGEST = 2.0  # times as fine as the run before at most
RUNS = 5
SAFETY = 1.4  # of what is claimed: estimates of Figure 3 on eleven meshes were short by 1.32 at most
ROOM = 0.85  # share of the error asked for that is aimed at
SLOWEST, USUAL, FASTEST = 0.7, 1.0, 3.0  # orders of the error in the size of the elements
Numbers = dict[tuple[str, str], float]  # by scene and name


@dataclass(frozen=True)
class Trial:
    """A run of all scenes, and what its results say of their errors.

    values: of the numbers that have an estimate.  mesh, steps: errors relative to them.  folds: by scene.
    """

    elements: float
    shorter: float
    values: Numbers
    mesh: Numbers
    steps: Numbers
    folds: Mapping[str, int]

    def errors(self, before: Trial | None) -> Numbers:
        """Return bounds of the relative errors, no smaller than what the run before leaves of them."""
        found = {key: SAFETY * self.mesh[key] + self.steps.get(key, 0.0) for key in self.mesh}
        if before is None:
            return found
        for key, error in before.errors(None).items():
            if key in found:
                apart = abs(self.values[key] - before.values[key]) - error * abs(before.values[key])
                found[key] = max(found[key], apart / abs(self.values[key]))
        return found


def run_to(accuracy: float, request: Request, running: Running) -> Answer:
    """Run the scenes of a case with elements and steps that leave relative errors of at most `accuracy`.

    The numbers are energy, pial length, gyrification index and sulcal depth. Exit status 3 where the
    estimates do not say that it was reached.
    """
    case = find_case(request.case)
    _check(case, request, running)
    own = case.provenance(given_values(case, request)[0], quick=request.quick)["parameters"][ELEMENTS]
    elements, shorter = _allowed(case, max(FEWEST, FIRST * own)), 1.0
    trials: list[Trial] = []
    while True:
        asked = replace(request, assigned=(*request.assigned, (ELEMENTS, f"{elements:g}")))
        how = replace(running, shorter=shorter, overwrite=running.overwrite or bool(trials))
        plan = planned(case, asked)
        check_figure(case, plan, asked)
        _refuse_motion(case, plan)
        ends = list(outcomes(case, plan, asked, how))
        if any(end.status != "converged" for end in ends):
            return answered(case, plan, ends, asked, how)
        trials.append(_trial(elements, shorter, plan, case, asked))
        worst, key = _worst(trials)
        say(f"run {len(trials)}, {_size(trials[-1])}: errors of up to {_percent(worst)} ({_of(key, plan)})")
        onward = None if worst <= accuracy else _next(trials, accuracy, case)
        if onward is None:
            break
        elements, shorter = onward
    answer = answered(case, plan, ends, asked, how)
    status = _told(trials, accuracy, worst)
    facts = {"asked": accuracy, "reached": worst, "elements": elements, "shorter_steps": shorter}
    return Answer(max(answer.status, status), {**answer.facts, "accuracy": facts})


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


def _trial(elements: float, shorter: float, plan: Sequence[Planned], case: Case, request: Request) -> Trial:
    """Read what a run left in its folder; raises ValueError for a scene without an estimate."""
    values: Numbers = {}
    mesh: Numbers = {}
    steps: Numbers = {}
    folds = {}
    for one in plan:
        folder = base_folder(case, request) / folder_name(one.name)
        summary: dict[str, Any] = read_json(folder / "summary.json")
        for errors in ("errors", "step_errors"):
            if not summary[errors]:
                why = summary[f"no_{errors}"]
                raise ValueError(
                    f"{case.shown}, scene {one.name!r}, {ELEMENTS}={elements:g}: --accuracy finds no "
                    f"estimate of its errors: {why}; leave --accuracy out, or set {ELEMENTS} by hand."
                )
        for name, error in summary["errors"].items():
            if value := summary[name]:
                key = one.name, name
                values[key], mesh[key] = value, abs(error / value)
                steps[key] = abs(summary["step_errors"].get(name, 0.0) / value)
        folds[one.name] = summary["folds"]
    return Trial(elements, shorter, values, mesh, steps, folds)


def _worst(trials: Sequence[Trial]) -> tuple[float, tuple[str, str]]:
    """Return the largest relative error of the last run, and of what it is."""
    found = trials[-1].errors(trials[-2] if len(trials) > 1 else None)
    key = max(found, key=lambda key: found[key])
    return found[key], key


def _next(trials: Sequence[Trial], accuracy: float, case: Case) -> tuple[float, float] | None:
    """Return elements and shortness of steps for the next run; None where there is none to try."""
    last = trials[-1]
    steps = max(last.steps.values())
    aim = ROOM * accuracy * (0.5 if steps > 0 else 1.0)
    worst, _ = _worst(trials)
    finer = min(max(worst - steps, 0.0) / aim, LONGEST**SLOWEST) ** (1 / _order(trials))
    elements = _allowed(case, last.elements * min(max(finer, 1.0), LONGEST))
    shorter = last.shorter * min(max(steps / aim, 1.0), LONGEST)
    if len(trials) == RUNS or (elements, shorter) == (last.elements, last.shorter):
        return None
    return elements, shorter


def _order(trials: Sequence[Trial]) -> float:
    """Return the order of the mesh's errors in the size of the elements, as the last two runs have it."""
    if len(trials) == 1 or trials[-1].elements == trials[-2].elements:
        return USUAL
    before, now = (max(trial.mesh.values()) for trial in trials[-2:])
    seen = math.log(before / now) / math.log(trials[-1].elements / trials[-2].elements)
    return min(max(seen, SLOWEST), FASTEST)


def _told(trials: Sequence[Trial], accuracy: float, worst: float) -> int:
    """Say what was reached; return the exit status."""
    if len(trials) > 1 and trials[-1].folds != trials[-2].folds:
        say("accuracy: the two last runs differ in their number of sulci; errors are those of one branch")
    if worst <= accuracy:
        say(f"accuracy: {_percent(worst)} by the estimates, asked {_percent(accuracy)}; {_size(trials[-1])}")
        return 0
    complain(
        f"--accuracy {_percent(accuracy)} was not reached: {_size(trials[-1])} leave errors of up to "
        f"{_percent(worst)} by the estimates."
    )
    return STOPPED


def _size(trial: Trial) -> str:
    steps = f", steps {trial.shorter:.3g} times as short" if trial.shorter > 1 else ""
    return f"elements={trial.elements:g}{steps}"


def _of(key: tuple[str, str], plan: Sequence[Planned]) -> str:
    scene, number = key
    return named(number) if len(plan) == 1 else f"{named(number)} of {scene}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
