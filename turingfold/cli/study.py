"""The folder of a study: study.json says which points it has, each of these has a folder with its record.

study.json          case, values that were set, the columns with their units, the points
<point>/point.json  how the point ended, and its numbers
sweep.csv           a row for each point that has ended; also sweep.parquet where pyarrow is installed
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..models.declared import as_text
from ..results.files import CorruptFileError, json_content, read_json, unsigned, write_whole
from ..results.lock import writer
from ..results.units import parameter_unit, with_unit
from ..studies.columns import NUMBERS, Column
from .case import Case, folder_name
from .outcome import Outcome
from .point import DONE, Point, read_record
from .table import append_row, write_parquet, write_table

STUDY = "study.json"
TABLE = "sweep.csv"
LAST = ("message",)


def described(case: Case, plan: Sequence[Point], command: str, *, si: bool) -> dict[str, Any]:
    """Return what study.json says: everything that its points are made of, and what its columns are.

    si: whether numbers are in SI units, and not in units of the case's own.
    """
    first = plan[0]
    columns = {}
    for name in first.varied:
        meaning = case.parameters[name].meaning if name in case.parameters else None
        unit = meaning.unit if meaning else parameter_unit(name) if si else ""
        columns[name] = {"label": (meaning.label if meaning else "") or name, "unit": unit}
    return {
        "case": case.name, "case_sha256": first.sha256, "quick": first.quick, "keep": first.keep,
        "command": command, "si": si, "columns": columns,
        "points": [
            {"name": one.name, "identity": one.identity, "varied": dict(one.varied)} for one in plan
        ],
    }  # fmt: skip


def read_study(base: Path) -> dict[str, Any]:
    """Return study.json of a folder; raises ValueError where there is none, or a damaged one."""
    file = base / STUDY
    if not file.is_file():
        raise ValueError(f"{base} holds no study: there is no {STUDY}; name the folder that sweep wrote.")
    found = unsigned(read_json(file), file)
    if not {"case", "columns", "points"} <= found.keys():
        raise CorruptFileError(f"{file} is damaged: it does not say which points there are.")
    return found


def write_study(base: Path, study: Mapping[str, Any]) -> None:
    """Write study.json."""
    write_whole(base / STUDY, json_content(study, signed=True))


class Rows:
    """The table of a study, which grows as its points end; at last it is in their order."""

    def __init__(
        self, file: Path, plan: Sequence[Point], ends: Mapping[str, Outcome], study: Mapping[str, Any]
    ) -> None:
        self.file, self.columns = file, columns(study)
        self._varied = {one.name: one.varied for one in plan}
        self._ends = dict(ends)
        self._write()

    def add(self, end: Outcome) -> None:
        """Add the row of a point that has ended."""
        self._ends[end.name] = end
        append_row(self.file, row(self._varied[end.name], end))

    def finish(self) -> None:
        """Write all rows in order, and for those that have pyarrow as Parquet too."""
        write_parquet(self.file.with_suffix(".parquet"), self.columns, self._write())

    def _write(self) -> list[list[Any]]:
        rows = [row(own, self._ends[name]) for name, own in self._varied.items() if name in self._ends]
        write_table(self.file, with_units(self.columns), rows)
        return rows


def columns(study: Mapping[str, Any]) -> dict[str, str]:
    """Return the columns of a study's table with their units; study: what `described` says."""
    varied = {name: str(own["unit"]) for name, own in study["columns"].items()}
    si = study.get("si", True)  # studies of earlier versions do not say it
    units = {name: column.unit if si else "" for name, column in NUMBERS.items()}
    return {"scene": "", **varied, "status": "", **units, **dict.fromkeys(LAST, "")}


def with_units(heads: Mapping[str, str]) -> list[str]:
    """Return columns as the first line of a table has them."""
    return [with_unit(name, unit) for name, unit in heads.items()]


def row(varied: Mapping[str, Any], end: Outcome) -> list[Any]:
    """Return the row of a point that has ended."""
    numbers = [end.summary.get(name) for name in NUMBERS]
    return [end.name, *(_cell(value) for value in varied.values()), end.status, *numbers, end.message]


def _cell(value: Any) -> Any:
    return as_text(value) if value is None or isinstance(value, bool) else value


def ended(point: Point) -> Outcome | None:
    """Return how a point ended that need not be run again; None for one that does."""
    record = read_record(point.folder, point.identity)
    return outcome_of(point.name, record) if record.get("status") in DONE else None


def outcome_of(name: str, record: Mapping[str, Any]) -> Outcome:
    """Return how a point ended by its record."""
    return Outcome(name, record["status"], record["message"], record["summary"] or {})


def gathered(base: Path) -> tuple[dict[str, Any], list[Outcome]]:
    """Return what study.json says, and how each of its points ended by the records.

    A point without a record is "running" or "not run". Raises as `read_study`.
    """
    study, ends = read_study(base), []
    for point in study["points"]:
        folder = base / folder_name(point["name"])
        if record := read_record(folder, point["identity"]):
            ends.append(outcome_of(point["name"], record))
        else:
            ends.append(Outcome(point["name"], "running" if writer(folder) else "not run"))
    return study, ends


def collect(base: Path) -> tuple[Path, list[Outcome]]:
    """Write a study's table from the records of its points; return its file, and how each ended."""
    study, ends = gathered(base)
    rows = [row(point["varied"], end) for point, end in zip(study["points"], ends, strict=True)]
    heads = columns(study)
    write_table(base / TABLE, with_units(heads), rows)
    write_parquet((base / TABLE).with_suffix(".parquet"), heads, rows)
    return base / TABLE, ends


def headings(study: Mapping[str, Any]) -> dict[str, Column]:
    """Return what the columns with numbers hold, by name."""
    return {name: Column(**own) for name, own in study["columns"].items()} | NUMBERS
