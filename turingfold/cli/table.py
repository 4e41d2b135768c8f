"""Tables as CSV; that of a case, by its function table(results), also as Markdown."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..results.files import open_unlinked, write_whole, writing
from ..results.result import Result
from .case import Case, explained

FILES = "table.csv", "table.md"


def write_case_table(case: Case, results: Mapping[str, Result], base: Path) -> Path | None:
    """Write the table of a case beside its results; return the Markdown file, None for a case without one.

    Raises ValueError for what is no list of dicts with the same keys.
    """
    if case.table is None:
        return None
    with explained(case.path):
        rows: Any = case.table(dict(results))
    if not rows or not all(isinstance(row, dict) and row.keys() == rows[0].keys() for row in rows):
        raise ValueError(f"{case.shown}: table(results) must return a list of dicts with the same keys.")
    columns = list(rows[0])
    write_table(base / FILES[0], columns, (row.values() for row in rows))
    write_whole(base / FILES[1], as_markdown(columns, rows).encode())
    return base / FILES[1]


def write_table(path: Path, columns: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """Write a table as CSV, at once; None is written as nothing."""
    write_whole(path, _lines([columns, *rows]))


def append_row(path: Path, row: Iterable[Any]) -> None:
    """Add a row to a table."""
    with writing(path), os.fdopen(open_unlinked(path, os.O_APPEND), "ab") as file:
        file.write(_lines([row]))


def _lines(rows: Iterable[Iterable[Any]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def write_parquet(path: Path, columns: Mapping[str, str], rows: Sequence[Sequence[Any]]) -> None:
    """Write a table as Parquet where pyarrow is installed (the extra `hpc`).

    columns: units by name, stored with each column; one whose values are of several kinds is written as text.
    """
    if find_spec("pyarrow") is None:
        return
    import pyarrow
    from pyarrow import parquet

    arrays, fields = [], []
    for k, (name, unit) in enumerate(columns.items()):
        values = [row[k] for row in rows]
        try:
            array = pyarrow.array(values)
        except (pyarrow.ArrowInvalid, pyarrow.ArrowTypeError):
            array = pyarrow.array([None if value is None else str(value) for value in values])
        arrays.append(array)
        fields.append(pyarrow.field(name, array.type, metadata={"unit": unit}))
    content = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields)), content)
    write_whole(path, content.getvalue())


def as_markdown(columns: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows as a table in Markdown: numbers to three digits, nothing as a dash."""
    lines = [columns, ["---"] * len(columns), *([_shown(row[name]) for name in columns] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value).replace("|", "\\|")
