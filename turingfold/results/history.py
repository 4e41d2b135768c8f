"""history.csv: a row per accepted step; an empty cell where a number does not exist."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

Row = dict[str, float]

COLUMNS = (
    "time", "growth", "energy", "newton_iterations", "factorizations", "min_jacobian", "min_gap",
    "gyrification_index", "negative_pivots", "step", "residual", "seconds",
)  # fmt: skip


def read_history(path: Path) -> list[Row]:
    """Return the rows of history.csv; a last row that was cut off is left out."""
    file = path / "history.csv"
    if not file.exists():
        return []
    table = list(csv.reader(io.StringIO(file.read_text(encoding="utf-8"), newline="")))
    whole = [line for line in table[1:] if len(line) == len(table[0])]
    return [{name: _number(cell) for name, cell in zip(table[0], line, strict=True)} for line in whole]


def lines(rows: Iterable[Row], columns: Sequence[str]) -> str:
    """Return rows as lines of CSV; numbers read back as the same bits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in rows:
        values = (row.get(name, np.nan) for name in columns)
        writer.writerow(["" if np.isnan(value) else repr(value) for value in values])
    return text.getvalue()


def _number(cell: str) -> float:
    if not cell:
        return float("nan")
    return int(cell) if cell.lstrip("-").isdigit() else float(cell)
