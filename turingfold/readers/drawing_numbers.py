"""The numbers of paths and polygons in the SVG format, examined and in the form that every reader agrees on.

The library that reads them on passes over what it cannot read, takes "40." for the end of a path, and
reflects the last control point in S and T after any curve, where the standard does so after a like one only.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from .drawing_view import NUMBER

FLAG = "[01]"
COMMAND = re.compile(r"([a-zA-Z])([^a-df-zA-DF-Z]*)")
ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
FULL = {"S": "C", "T": "Q"}  # by the command that gives their first control point, too

Sets = list[tuple[str, list[float]]]  # commands, each with one set of numbers


def path_data(text: str, where: str) -> str:
    """Return path data with absolute commands M, L, C, Q, A and Z, one for each set of numbers.

    Raises ValueError, beginning with `where`, for commands that there are not, wrong counts of numbers,
    numbers that are not finite, and data that begin without M.
    """
    words = []
    for command, values in _absolute(_sets(text, where)):
        if not np.isfinite(values).all():
            raise ValueError(f"{where}: the path has numbers too large to be read; write it smaller.")
        words += [command, *(repr(value) for value in values[:3])]
        words += [repr(int(v)) if command == "A" and k < 2 else repr(v) for k, v in enumerate(values[3:])]
    return " ".join(words)


def points_data(text: str, where: str) -> str:
    """Return the points of a polygon in numbers with decimals; ValueError unless they are pairs."""
    numbers, left = re.findall(NUMBER, text), re.sub(NUMBER, "", text)
    if len(numbers) % 2 or re.sub(r"[\s,]", "", left):
        raise ValueError(f"{where}: the attribute points must be pairs of numbers x, y.")
    values = [float(number) for number in numbers]
    if not np.isfinite(values).all():
        raise ValueError(f"{where}: points has numbers too large to be read; write it smaller.")
    return " ".join(map(repr, values))


def _sets(text: str, where: str) -> Sets:
    """Return the commands of path data; raises as `path_data`."""
    commands = COMMAND.findall(text)
    if re.sub(r"\s", "", text) != re.sub(r"\s", "", "".join(a + b for a, b in commands)):
        raise ValueError(f"{where}: the path begins with {text.strip()[:10]!r}; it must begin with M or m.")
    found: Sets = []
    for command, values in commands:
        kind = command.upper()
        if not found and kind != "M":
            raise ValueError(f"{where}: the path begins with {command!r}; it must begin with M or m.")
        if kind not in ARGUMENTS:
            raise ValueError(f"{where}: there is no path command {command!r}.")
        one = [NUMBER] * ARGUMENTS[kind]
        if kind == "A":
            one[3] = one[4] = FLAG  # "a1 1 0 011 1": flags need no space after them
        row = r"[\s,]*".join(one)
        if not re.fullmatch(rf"\s*(?:{row}[\s,]*)+" if one else r"\s*", values):
            raise ValueError(
                f"{where}: path command {command!r} has {values.strip()[:40]!r}, which are not sets of "
                f"{ARGUMENTS[kind]} numbers."
            )
        rows = re.finditer(r"[\s,]*".join(f"({each})" for each in one), values) if one else ()
        numbers = [[float(number) for number in match.groups()] for match in rows]
        line = {"M": "L", "m": "l"}.get(command, command)  # what further pairs after a move are
        found += [(line if k else command, row) for k, row in enumerate(numbers or [[]])]
    return found


def _absolute(sets: Sets) -> Iterator[tuple[str, list[float]]]:
    """Yield the commands with places from the origin, lines as L, and curves with all their points."""
    here = begin = np.zeros(2)
    before, control = "", np.zeros(2)  # of the last curve
    for command, numbers in sets:
        kind, from_ = command.upper(), here if command.islower() else np.zeros(2)
        if kind == "Z":
            here, before = begin, "Z"
            yield "Z", []
            continue
        if kind in "HV":
            axis = "HV".index(kind)
            places = [here.copy()]
            places[0][axis] = numbers[0] + from_[axis]
            kind = "L"
        elif kind == "A":
            places = [np.array(numbers[5:]) + from_]
        else:
            places = [*(np.reshape(numbers, (-1, 2)) + from_)]
        if kind in FULL:
            kind = FULL[kind]
            places.insert(0, 2 * here - control if before == kind else here)
        if kind == "M":
            begin = places[-1]
        here, before = places[-1], kind
        control = places[-2] if kind in "CQ" else here
        yield kind, [*(numbers[:5] if kind == "A" else []), *(float(v) for place in places for v in place)]
