"""Which points a study has: a grid of values, the rows of a table, or samples of ranges."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from ..models.declared import Declared, find
from ..results.units import without_unit
from ..scene import Scene
from ..studies.sampling import sampled
from ..studies.sweep import check_lists, is_part, name_of, read_values
from .case import Case, check_apart, folder_name
from .plan import given_values
from .point import Maker, Point
from .request import Assignments, Request

MOST_POINTS = 100_000  # of a study; each takes 2 kB here, a folder on disk, and a run


@dataclass(frozen=True)
class Design:
    """Values as they are given: lists (and with a sampling method, ranges) by parameter, a table, samples."""

    vary: Assignments = ()
    table: Path | None = None
    method: str = ""
    samples: int = 0
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.vary and self.table is None:
            raise ValueError("nothing is varied; give --vary NAME=VALUES, or --points TABLE.csv.")

    def words(self) -> list[str]:
        """Return the words of the command line that say this."""
        found = [word for name, values in self.vary for word in ("--vary", f"{name}={values}")]
        found += ["--points", str(self.table)] if self.table else []
        found += [f"--{self.method}", str(self.samples)] if self.method else []
        return found + (["--seed", str(self.seed)] if self.seed else [])


@dataclass(frozen=True)
class _Values:
    """Values of one point: of the case's parameters, and as text of parts; or why there are none."""

    own: Mapping[str, Any]
    parts: Mapping[str, str]
    refused: str = ""

    @property
    def names(self) -> list[str]:
        """The parameters."""
        return [*self.own, *self.parts]


def points(case: Case, request: Request, design: Design, base: Path, keep: str) -> tuple[list[Point], Maker]:
    """Return the points of a study, and what has made the scenes of the first that can be made.

    Raises ValueError for unknown parameters, lists of values of another kind or out of range, points of one
    name, and where no point at all can be made. A row of a table that cannot be made is a point all the same.
    """
    own, parts = given_values(case, request)
    lists = _listed(case, design)
    every = _every(case, design, lists, {*own, *parts})
    maker = Maker(case)
    scenes = _first(case, every, own, maker, quick=request.quick)
    names = _chosen(case, scenes, request.only)
    combined = 0
    for name in names:
        of_parts = {part: read_values(text, scenes[name], part) for part, text in lists.parts.items()}
        check_lists({name: [0] for name in every[0].names} | dict(lists.own) | of_parts)
        combined += math.prod(map(len, of_parts.values()))
    _check_count(len(every) * combined)
    plain = Point(
        case.path, case.sha256, "", "", tuple(scenes), {}, {}, {}, base, request.quick, keep,
    )  # fmt: skip
    set_parts = {name: _set_values(name, scenes[name], parts) for name in names}
    found: list[Point] = []
    for values in every:
        for name in names:
            prefix = f"{name}, " if len(names) > 1 else ""
            for chosen, refused in _of_scene(scenes[name], values):
                label = prefix + name_of(chosen)
                changed = {key: value for key, value in chosen.items() if is_part(key)}
                found.append(replace(
                    plain, name=label, scene=name, given=own | dict(values.own), varied=chosen,
                    parts=set_parts[name] | changed, folder=base / folder_name(label), refused=refused,
                ))  # fmt: skip
    if all(point.refused for point in found):
        raise ValueError(found[0].refused)
    _check_names([point.name for point in found])
    check_apart([point.name for point in found], case.path)
    return found, maker


@dataclass(frozen=True)
class _Lists:
    """What --vary gives: ranges and lists of values of the case's parameters, and texts of those of parts."""

    ranges: Mapping[str, tuple[float, float]]
    own: Mapping[str, Sequence[Any]]
    parts: Mapping[str, str]


def _listed(case: Case, design: Design) -> _Lists:
    ranges: dict[str, tuple[float, float]] = {}
    lists: dict[str, list[Any]] = {}
    texts: dict[str, str] = {}
    for name, text in design.vary:
        if name in ranges or name in lists or name in texts:
            raise ValueError(f"{name} is given twice; list all its values in one --vary.")
        if is_part(name):
            texts[name] = text
        elif design.method and text.count(":") == 1:
            ranges[name] = _range(find(case.parameters, name), text)
        else:
            lists[name] = find(case.parameters, name).read_list(text)
    if design.method and not ranges:
        raise ValueError(
            f"--{design.method} samples ranges of the case's parameters, and none is given; such as "
            "--vary thickness=2e-3:4e-3."
        )
    return _Lists(ranges, lists, texts)


def _every(case: Case, design: Design, lists: _Lists, given: set[str]) -> list[_Values]:
    """Return the values of every point: rows of the table and samples, each with each of the listed ones."""
    nothing = [_Values({}, {})]
    rows = nothing if design.table is None else list(_rows(case, design.table))
    names = [*rows[0].names, *(name for name, _ in design.vary)]
    for name in names:
        if names.count(name) > 1 or name in given:
            raise ValueError(f"{name} is given twice; list all its values in one --vary.")
    _check_count(len(rows) * (design.samples or 1) * math.prod(map(len, lists.own.values())))
    samples = _samples(case, lists.ranges, design) or nothing
    grid = [dict(zip(lists.own, chosen, strict=True)) for chosen in product(*lists.own.values())]
    found = []
    for row, sample, combination in product(rows, samples, grid):
        both = {**row.own, **sample.own, **combination}
        own = {name: both[name] for name in names if name in both}
        found.append(_Values(own, {**row.parts, **lists.parts}, row.refused))
    return found


def _range(parameter: Declared, text: str) -> tuple[float, float]:
    if parameter.kind not in (int, float):
        raise ValueError(f"{parameter.name}={text}: only numbers have ranges; list the values.")
    low, high = (parameter.read(end) for end in text.split(":"))
    if low is None or high is None:
        raise ValueError(f"{parameter.name}={text} must be LOW:HIGH, two numbers.")
    return low, high


def _samples(case: Case, ranges: Mapping[str, tuple[float, float]], design: Design) -> list[_Values]:
    if not ranges:
        return []
    # a whole number's last value is as likely as the others
    whole = {name for name in ranges if case.parameters[name].kind is int}
    wide = {name: (low, high + (name in whole)) for name, (low, high) in ranges.items()}
    drawn = sampled(wide, design.samples, method=design.method, seed=design.seed)
    return [
        _Values({name: int(v[k]) if name in whole else float(v[k]) for name, v in drawn.items()}, {})
        for k in range(design.samples)
    ]


def _rows(case: Case, file: Path) -> Iterator[_Values]:
    """Yield the rows of a table, a column for each parameter; a bad value is kept as it is, and refused."""
    with file.open(newline="", encoding="utf-8-sig", errors="replace") as opened:
        table = csv.DictReader(opened, skipinitialspace=True)
        heads = [without_unit(name.strip()) for name in table.fieldnames or ()]
        names = [name for name, _ in heads]
        rows = [list(row.values()) for row in table]
        if not names or not rows or len(set(names)) < len(names):
            raise ValueError(f"{file} must have a line of different parameter names, and lines of values.")
        for name, unit in heads:
            meaning = None if is_part(name) else find(case.parameters, name).meaning
            if unit and (meaning is None or unit != meaning.unit):
                known = f"its values are in {meaning.unit}" if meaning and meaning.unit else "it has no unit"
                raise ValueError(f"{file}: {name} [{unit}]: {known}; convert the values, and say so.")
    for line, cells in enumerate(rows, 2):
        if len(cells) != len(names) or not all(isinstance(cell, str) and cell.strip() for cell in cells):
            raise ValueError(f"{file}, line {line} must have {len(names)} values: {', '.join(names)}.")
        given = {name: str(cell).strip() for name, cell in zip(names, cells, strict=True)}
        own: dict[str, Any] = {name: text for name, text in given.items() if not is_part(name)}
        refused = ""
        for name, text in own.items():
            try:
                own[name] = case.parameters[name].read(text)
            except ValueError as error:
                refused = refused or f"{file}, line {line}: {error}"
        yield _Values(own, {name: text for name, text in given.items() if is_part(name)}, refused)


def _first(
    case: Case, every: Sequence[_Values], own: Mapping[str, Any], maker: Maker, *, quick: bool
) -> dict[str, Scene]:
    """Return the scenes of the first point that can be made: others have scenes of the same names."""
    words = ""
    for values in every:
        try:
            if not values.refused:
                return maker.scenes(case, dict(own) | dict(values.own), quick=quick)
            words = words or values.refused
        except ValueError as error:
            words = words or str(error)
    raise ValueError(words)


def _chosen(case: Case, scenes: Mapping[str, Scene], only: Sequence[str]) -> list[str]:
    if unknown := [name for name in only if name not in scenes]:
        known = ", ".join(map(repr, scenes))
        raise ValueError(f"{case.shown} has no scene {unknown[0]!r}; it has: {known}.")
    return [name for name in scenes if not only or name in only]


def _set_values(name: str, scene: Scene, parts: Mapping[str, str]) -> dict[str, Any]:
    """Return values of parts of a scene that --set gives as text."""
    found = {}
    for parameter, text in parts.items():
        try:
            values = read_values(text, scene, parameter)
        except ValueError as error:
            raise ValueError(f"scene {name!r}: {error}") from error
        if len(values) != 1:
            raise ValueError(f"{parameter}={text} lists {len(values)} values; set one, or sweep --vary.")
        found[parameter] = values[0]
    return found


def _of_scene(scene: Scene, values: _Values) -> Iterator[tuple[dict[str, Any], str]]:
    """Yield each combination of values of a scene, and why it can be none, if so."""
    lists = {name: read_values(text, scene, name) for name, text in values.parts.items()}
    for chosen in product(*lists.values()):
        yield {**values.own, **dict(zip(lists, chosen, strict=True))}, values.refused


def _check_count(points: int) -> None:
    if points > MOST_POINTS:
        raise ValueError(
            f"the study would have {points} points, and may have {MOST_POINTS}: list fewer values, take "
            "fewer samples (--lhs N), or make several studies of it (--out DIR)."
        )


def _check_names(names: Sequence[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            remedy = "leave one out, or let them differ in six digits"
            raise ValueError(f"two points are named {name!r}; {remedy}.")
        seen.add(name)
