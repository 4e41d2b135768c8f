"""turingfold sweep: a case's scenes with other values of some parameters, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..figures.grids import grid
from ..figures.style import sulci
from ..models.declared import as_text, find
from ..results.files import read_json
from ..results.result import Result, read_result
from ..studies.sweep import is_part, named_combinations, read_values, varied
from .case import Case, check_apart, find_case, folder_name
from .figure import save_figure
from .plan import Planned, base_folder, has_result, planned
from .request import Assignments, Request, Running
from .run import finished, outcomes
from .status import say
from .table import write_table
from .workers import Outcome

TABLE = "sweep.csv"
NUMBERS = (
    "growth", "folds", "least_fold_depth", "gyrification_index", "closed_gyrification_index", "sulcal_depth",
    "registration", "registration_p", "energy", "min_jacobian",
    "self_intersections", "saddles", "snaps", "steps", "newton_iterations", "seconds",
)  # fmt: skip
SIDE_BY_SIDE = 4  # pictures in a row
PAGE = 48  # pictures in a figure


def sweep(request: Request, vary: Assignments, running: Running) -> int:
    """Run the variations of a case's scenes, write their numbers in one table, draw them side by side.

    The table grows as points end; points that stop, or that the case refuses, have a row that says why. It is
    of this sweep alone: results of earlier ones stay in their folders, but are not read.
    """
    case = find_case(request.case)
    plan = points(case, request, vary)
    base, names = base_folder(case, request), [name for name, _ in vary]
    ends = {one.name: Outcome(one.name, "refused", one.refused) for one in plan if one.scene is None}

    def write() -> None:
        rows = [_row(one, ends[one.name], names, base) for one in plan if one.name in ends]
        write_table(base / TABLE, ("scene", *names, "status", *NUMBERS, "message"), rows)

    under_way = outcomes(case, plan, request, running)
    plan = [replace(one, scene=None) for one in plan]  # bodies go when they have run
    write()
    for end in under_way:
        ends[end.name] = end
        write()
        say(_line(end, base))
    status = finished(list(ends.values()), case, request)
    _tell(ends, base)
    shown = [one.name for one in plan if has_result(base, one.name)]
    for path, page in _pages(shown, base / f"{case.name}-sweep.png"):
        with save_figure(path) as figure:
            draw(figure, Stored(base, page, case))
        say(f"figure: {path}")
    return status


def points(case: Case, request: Request, vary: Assignments) -> list[Planned]:
    """Return each scene of a case with each combination of values, given as text by parameter.

    Raises ValueError for unknown parameters, values of another kind or out of range, values of one name, and
    where no combination at all can be made; one that cannot be made is `refused`.
    """
    names = [name for name, _ in vary]
    for name in names:
        if names.count(name) > 1 or name in dict(request.assigned):
            raise ValueError(f"{name} is given twice; list all its values in one --vary.")
    own = {name: find(case.parameters, name).read_list(text) for name, text in vary if not is_part(name)}
    parts = {name: text for name, text in vary if is_part(name)}
    found: list[Planned] = []
    for label, chosen in (named_combinations(own) if own else {"": {}}).items():
        try:
            plan = planned(case, request, chosen)
        except ValueError as error:
            found.append(Planned(label or case.name, None, {}, chosen, str(error)))
            continue
        for one in plan:
            prefix = f"{one.name}, " if len(plan) > 1 else ""
            found += [replace(point, name=prefix + point.name) for point in _of_scene(one, chosen, parts)]
    if all(one.scene is None for one in found):
        raise ValueError(found[0].refused)
    check_apart([one.name for one in found], case.path)
    return found


def _of_scene(one: Planned, chosen: Mapping[str, Any], parts: Mapping[str, str]) -> Iterator[Planned]:
    """Yield a scene with each combination of values of its parts, given as text; parameters as chosen."""
    assert one.scene is not None
    lists = {parameter: read_values(text, one.scene, parameter) for parameter, text in parts.items()}
    values = {parameter: [value] for parameter, value in chosen.items()} | lists
    for name, combination in named_combinations(values).items():
        changes = {parameter: [combination[parameter]] for parameter in parts}
        told = {parameter: as_text(combination[parameter]) for parameter in parts}
        provenance = dict(one.provenance) | ({"parts": told} if parts else {})
        try:
            scene = next(iter(varied(one.scene, changes).values())) if changes else one.scene
        except ValueError as error:
            yield Planned(name, None, provenance, combination, str(error))
        else:
            yield Planned(name, scene, provenance, combination)


def _row(one: Planned, end: Outcome, names: Sequence[str], base: Path) -> list[Any]:
    file = base / folder_name(one.name) / "summary.json"
    summary = read_json(file) if not one.refused and file.is_file() else {}
    status = end.status if end.status in ("refused", "killed") else summary.get("status", end.status)
    numbers = [summary.get(number) for number in NUMBERS]
    return [one.name, *(one.varied.get(name) for name in names), status, *numbers, end.message]


def _line(end: Outcome, base: Path) -> str:
    file = base / folder_name(end.name) / "summary.json"
    if not file.is_file():
        return f"{end.name}: {end.status}"
    summary = read_json(file)
    shape = f"{sulci(summary['folds'])}, gyrification {summary['gyrification_index']:.2f}"
    return f"{end.name}: {end.status} at growth {summary['growth']:.2f}, {shape}"


def _tell(ends: Mapping[str, Outcome], base: Path) -> None:
    kinds = [end.status for end in ends.values()]
    words = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
    say(f"{len(ends)} points: {words}")
    say(f"table: {base / TABLE}")


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
