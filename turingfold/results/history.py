"""history.csv: a row per accepted step; an empty cell where a number does not exist.

Names stand there with their units, such as "energy [J/m]"; where they are read, without.

The last column is the CRC-32 of the line before it and of all lines above: a changed digit is noticed. Its
name says of which run they are.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TextIO
from zlib import crc32

import numpy as np

from .files import CorruptFileError, open_unlinked, read_bytes, write_whole, writing
from .identity import Identity
from .units import with_unit, without_unit

Row = dict[str, float]

COLUMNS = (
    "time", "growth", "energy", "newton_iterations", "factorizations", "min_jacobian", "min_gap",
    "inverted_elements", "gyrification_index", "negative_pivots", "step", "residual", "seconds",
)  # fmt: skip
CHECK, OF_RUN = "crc32", " of run "


class History:
    """The file while it is written: rows are appended, and all are written anew when columns are added."""

    def __init__(self, path: Path, unit: Callable[[str], str] = lambda name: "", run: str = "") -> None:
        """Begin with no rows; unit: of the numbers of a name.  run: whose rows they are."""
        self.path, self._unit, self._run = path, unit, run
        self.rows: list[Row] = []
        self._columns: list[str] = []
        self._check = 0
        self._file: TextIO | None = None

    def add(self, row: Row) -> None:
        """Append a row, at once."""
        self.rows.append(row)
        if self._file is None or not set(row) <= set(self._columns):
            self.rewrite()
            return
        with writing(self.path):
            self._file.write(self._signed(lines([row], self._columns)))
            self._file.flush()

    def rewrite(self) -> None:
        """Write all rows anew."""
        extra = {name for row in self.rows for name in row} - set(COLUMNS)
        self._columns, self._check = [*COLUMNS, *sorted(extra)], 0
        self.close()
        names = (with_unit(name, self._unit(name)) for name in self._columns)
        table = ",".join(names) + "\n" + lines(self.rows, self._columns)
        head, *rows = table.splitlines(keepends=True)
        first = f"{head.rstrip()},{CHECK}{OF_RUN}{self._run}\n" if self._run else f"{head.rstrip()},{CHECK}\n"
        self._check = crc32((first if self._run else head).encode())
        signed = first + "".join(map(self._signed, rows))
        write_whole(self.path, signed.encode(), make_folder=False)
        with writing(self.path):
            self._file = os.fdopen(open_unlinked(self.path, os.O_APPEND), "a", newline="", encoding="utf-8")

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _signed(self, line: str) -> str:
        self._check = crc32(line.encode(), self._check)
        return f"{line.rstrip()},{self._check}\n"


def read_history(path: Path, identity: Identity | None = None) -> list[Row]:
    """Return the rows of the history in a folder, none where there is no file yet.

    A last row that was cut off is left out. Raises CorruptFileError where another one is damaged, or where
    they are not of the run.
    """
    file = path / "history.csv"
    if not file.exists():
        return []
    content = read_bytes(file)
    rows, damage = sound_rows(content)
    if damage:
        raise CorruptFileError(f"{file}: {damage}. Go on with resume=True (--resume), or run it again.")
    if identity is not None:
        identity.check(file, run_of(content))
    return rows


def run_of(content: bytes) -> str | None:
    """Return of which run a history says it is; None of one of an earlier version, which says nothing."""
    _, found, run = content.partition(b"\n")[0].decode(errors="replace").rpartition(CHECK + OF_RUN)
    return run if found else None


def sound_rows(content: bytes) -> tuple[list[Row], str]:
    """Return the rows of a history up to the first damaged one, and what is wrong with that one, if any."""
    head, *lines_after = content.split(b"\n")[:-1] or [b""]  # what follows the last line's end is no line yet
    names, _, last = head.rpartition(b",")
    if last.split(b" ")[0] != CHECK.encode():
        return [], "its first line is damaged"
    columns = [without_unit(name)[0] for name in names.decode(errors="replace").split(",")]
    check = crc32((names if last == CHECK.encode() else head) + b"\n")
    rows: list[Row] = []
    for k, line in enumerate(lines_after):
        numbers, _, found = line.rpartition(b",")
        check = crc32(numbers + b"\n", check)
        cells = numbers.decode(errors="replace").split(",")
        try:
            if found != str(check).encode():
                raise ValueError
            rows.append(dict(zip(columns, map(_number, cells), strict=True)))
        except ValueError:
            return rows, f"line {k + 2} was changed after it was written: its checksum does not match"
    return rows, ""


def lines(rows: Iterable[Row], columns: Sequence[str]) -> str:
    """Return rows as lines of CSV; numbers read back as the same bits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in rows:
        values = (row.get(name, np.nan) for name in columns)
        writer.writerow(["" if np.isnan(value) else repr(np.asarray(value).item()) for value in values])
    return text.getvalue()


def _number(cell: str) -> float:
    if not cell:
        return float("nan")
    return int(cell) if cell.lstrip("-").isdigit() else float(cell)
