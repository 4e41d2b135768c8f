"""Closed curves from columns of numbers, as spreadsheets and other programs write them."""

from __future__ import annotations

import re
import warnings
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Array
from .column_words import Said

COMMENT = re.compile(r"(?:^|\s)[#%](.*)$")
MISSING = ("", "nan", "na", "n/a", "null")
INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?")
LIKE_A_NUMBER = re.compile(r"[\W_]*(\d|[oO][.,]\d|inf(inity)?$)", re.IGNORECASE)
FEWEST = 3  # points of a closed curve
OF_A_CURVE = 8  # points that make a second curve likely
JUMP = 5.0  # times the median distance of neighbours


@dataclass(frozen=True)
class Dialect:
    """How a file writes its rows: separator ";" or "," or white space (""), decimal sign "." or ","."""

    separator: str
    decimal: str

    def fields(self, line: str) -> list[str]:
        """Return the fields of a line without quotes; empty ones at its end are left out."""
        parts = line.split(self.separator) if self.separator else line.split()
        found = [part.strip(" \t\"'") for part in parts]
        while found and not found[-1]:
            found.pop()
        return found

    def number(self, text: str) -> float | None:
        """Return the number that a field holds, NaN where it is missing, None where it is something else."""
        if text.lower() in MISSING:
            return float("nan")
        if INFINITE.fullmatch(text):
            return float("inf")
        wrong = {".": ",", ",": "."}[self.decimal]
        return None if wrong in text or not NUMBER.fullmatch(text) else float(text.replace(",", "."))


def read_columns(file: Path, *, unit_is_given: bool = False) -> tuple[list[Array], float | None]:
    """Return the closed curves (2, n) in a file, and the length in m of the unit it states, if it does.

    unit_is_given: None, too, for a unit that is not clear.  Its columns are those that it names, see `Order`.
    Warns of points far from both their neighbours, by the number of the line, and as `Said.order`.
    Raises ValueError with the number of the line for fields that are no numbers, for curves of fewer than
    three points, and for closed curves that follow each other without a blank row; for a unit that is unknown
    or mentioned in passing only, and for names of columns of which the order cannot be told.
    """
    written = _text(file).splitlines()
    lines = [COMMENT.sub("", line).strip() for line in written]
    declared = re.fullmatch(r'"?sep=(.)"?', lines[0]) if lines else None
    dialect = _dialect(lines[1:], declared[1].strip()) if declared else _dialect(lines, None)
    curves: list[list[tuple[float, float, int]]] = [[]]
    said = Said(file.name)
    for number, line in enumerate(lines[bool(declared) :], start=1 + bool(declared)):
        fields = dialect.fields(line)
        if comment := COMMENT.search(written[number - 1]):
            said.comment(comment[1])
        if all(field.lower() in MISSING for field in fields):
            if curves[-1]:
                curves.append([])
        elif not curves[-1] and not any(LIKE_A_NUMBER.match(field) for field in fields):
            if len(fields) != 2:  # rows may be separated by something else
                fields = [part.strip(" \t\"'") for part in re.split("[,;\t]", line)]
            said.header(line, fields)
        else:
            curves[-1].append((*_point(fields, dialect, f"{file.name}, line {number}: {line!r}"), number))
    filled = [curve for curve in curves if curve]
    if not filled:
        raise ValueError(f"{file.name} holds no points; give two columns x, y.")
    unit = None
    with suppress(ValueError) if unit_is_given else nullcontext():
        unit = said.unit()
    order = said.order()
    return [order.placed(_closed(curve, file.name)) for curve in filled], unit


def _text(file: Path) -> str:
    content = file.read_bytes()
    wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))  # as Excel writes "Unicode text"
    if not wide and b"\0" in content:
        raise ValueError(f"{file.name} is no text: its byte {content.index(0)} is zero; save it as CSV.")
    try:
        text = content.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        if wide:
            raise ValueError(f"{file.name} is no text in UTF-16 ({error.reason}); save it as CSV.") from error
        text = content.decode("latin-1")  # numbers are the same in it, headers and comments may differ
    return text.replace("\N{MINUS SIGN}", "-")


def _dialect(lines: list[str], declared: str | None) -> Dialect:
    """Return how rows are written, as those that begin with a number show it.

    A comma is the decimal sign where something else separates the fields, else the separator.
    """
    rows = [line for line in lines if LIKE_A_NUMBER.match(line)]
    separator = declared
    if separator is None:
        first = rows[0] if rows else ""
        words = first.split()
        decimal = len(words) > 1 and not any(word[0] == "," or word[-1] == "," for word in words)
        separator = ";" if ";" in first else "," if "," in first and not decimal else ""
    comma = separator != "," and any("," in row for row in rows) and not any("." in row for row in rows)
    return Dialect(separator, "," if comma else ".")


def _point(fields: list[str], dialect: Dialect, where: str) -> tuple[float, float]:
    values = [dialect.number(field) for field in fields]
    if dialect.separator == "," and len(fields) == 4:
        raise ValueError(f"{where} has 4 fields; if commas are decimal signs, put semicolons between them.")
    if len(values) != 2 or values[0] is None or values[1] is None:
        raise ValueError(f"{where} is not two numbers x, y; blank rows separate curves.")
    if not np.isfinite([values[0], values[1]]).all():
        raise ValueError(f"{where} is not finite; leave that point out.")
    return values[0], values[1]


def _closed(curve: list[tuple[float, float, int]], name: str) -> Array:
    """Return a curve as points (2, n), without its first point at the end again."""
    points = np.array([row[:2] for row in curve]).T
    while points.shape[1] > FEWEST and (points[:, 0] == points[:, -1]).all():
        points = points[:, :-1]
    line = curve[0][2]
    if points.shape[1] < FEWEST:
        raise ValueError(
            f"{name}, line {line}: a curve of {points.shape[1]} point(s); give at least {FEWEST}. "
            "Blank rows begin a new curve: leave them out between the points of one."
        )
    if joint := _joint(points):
        raise ValueError(
            f"{name}, lines {line} and {curve[joint][2]}: closed curves begin here, joined to one; put a "
            "blank row between them."
        )
    if far := _far_off(points):
        shown = "; ".join(
            f"line {curve[k][2]}: ({x:g}, {y:g}) is {times:.2g} times as far from both its neighbours as "
            "others are"
            for (k, times), (x, y) in zip(far, points[:, [k for k, _ in far]].T.tolist(), strict=True)
        )
        warnings.warn(f"{name}, {shown}; is a digit or the decimal sign wrong?", stacklevel=4)
    return points


def _far_off(points: Array) -> list[tuple[int, float]]:
    """Return the points that lie far from both their neighbours though these are near each other.

    With each the distance, over the median distance of neighbours.
    """
    before, after = np.roll(points, 1, axis=1), np.roll(points, -1, axis=1)
    usual = float(np.median(np.hypot(*(points - before))))
    if usual == 0:
        return []
    away = np.minimum(np.hypot(*(points - before)), np.hypot(*(after - points)))
    near = np.maximum(np.hypot(*(after - before)), usual)
    return [(k, float(away[k] / usual)) for k in np.flatnonzero(away > JUMP * near).tolist()]


def _joint(points: Array) -> int:
    """Return the number of the point at which a second closed curve begins, or 0.

    There the first point has just been repeated; or long steps cut the row of points into pieces of which
    each closes by itself.
    """
    again = np.flatnonzero((points[:, FEWEST:] == points[:, :1]).all(0))
    if len(again):
        return int(again[0]) + FEWEST + 1
    steps = np.hypot(*np.diff(points))
    usual = np.median(steps)
    begins = (np.flatnonzero(steps > JUMP * usual) + 1).tolist()
    pieces = np.split(points, begins, axis=1)
    gaps = [np.hypot(*(piece[:, 0] - piece[:, -1])) for piece in pieces]
    whole = all(piece.shape[1] >= OF_A_CURVE for piece in pieces)
    return int(begins[0]) if begins and whole and max(gaps) < 0.5 * JUMP * usual else 0
