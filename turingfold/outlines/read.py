"""Outlines from files: columns of numbers (CSV) and drawings (SVG)."""

from __future__ import annotations

import csv
import itertools
import re
from math import isfinite
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..checks import file_path, positive, whole

SHAPES = ("path", "polygon", "polyline")
ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2}
SMOOTH = {"S": ("C", "S"), "T": ("Q", "T")}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def read_outline(path: str | Path, *, name: str = "", scale: float = 1.0, samples: int = 12) -> Array:
    """Return the points (2, n) of an outline in a CSV or SVG file, in file units times `scale`.

    CSV: two columns x, y (comma, semicolon, tab or space between them), with or without a header line.
    SVG: the path, polygon or polyline with the id `name`, or the only one there is. The y axis is turned to
    point upward. Bézier curves are sampled at `samples` points each; of a path with several parts the longest
    is taken.
    Raises ValueError for other files, unreadable numbers, elliptic arcs and transforms, saying where.
    """
    positive("scale", scale)
    whole("samples", samples, at_least=1)
    file = file_path("path", path, "a CSV or SVG file")
    if file.suffix.lower() == ".svg":
        return scale * _svg(file, name, samples)
    if file.suffix.lower() in (".csv", ".txt", ".dat", ".tsv"):
        return scale * _columns(file)
    raise ValueError(
        f"{file.name} ends in {file.suffix!r}; outlines are read from .csv, .txt, .dat, .tsv and .svg."
    )


def _columns(file: Path) -> Array:
    rows: list[tuple[float, float]] = []
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{file.name} is not text in UTF-8 ({error.reason} at byte {error.start}); save it as CSV."
        ) from error
    for number, line in enumerate(text.splitlines(), start=1):
        parts = next(csv.reader([re.sub(r"[;\t ]+", ",", line.strip())]), [])
        parts = [part for part in parts if part]
        if not parts or parts[0].startswith("#"):
            continue
        try:
            x, y = (float(part) for part in parts)
        except ValueError as error:
            if not rows and number == 1:
                continue  # a header
            raise ValueError(
                f"{file.name}, line {number}: {line.strip()!r} is not two numbers x, y."
            ) from error
        if not (isfinite(x) and isfinite(y)):
            raise ValueError(
                f"{file.name}, line {number}: {line.strip()!r} is not finite; leave that point out."
            )
        rows.append((x, y))
    if not rows:
        raise ValueError(f"{file.name} holds no points; give two columns x, y.")
    return np.array(rows).T


def _svg(file: Path, name: str, samples: int) -> Array:
    try:
        root = ElementTree.parse(file).getroot()
    except ElementTree.ParseError as error:
        raise ValueError(f"{file.name} is not well-formed SVG: {error}.") from error
    shapes = {shape.get("id") or f"number {k}": shape for k, shape in enumerate(_shapes(root), start=1)}
    if name not in shapes if name else len(shapes) != 1:
        raise ValueError(
            f"name={name!r}: {file.name} holds {len(shapes)} outlines ({', '.join(shapes) or 'none'}); name "
            f"one by id. Only {', '.join(SHAPES[:-1])} and {SHAPES[-1]} are read: turn others into paths."
        )
    shape = shapes[name] if name else next(iter(shapes.values()))
    if any("transform" in element.attrib for element in root.iter()):
        raise ValueError(
            f"{file.name} has a transform; apply it to the drawing (in Inkscape: ungroup, save as plain)."
        )
    if shape.tag.rpartition("}")[2] == "path":
        points = _path(shape.get("d", ""), samples, file.name)
    else:
        points = np.array([float(n) for n in NUMBER.findall(shape.get("points", ""))])
        if points.size % 2 or not points.size:
            raise ValueError(
                f"{file.name}: the attribute points has {points.size} numbers; they must make pairs x, y."
            )
        points = points.reshape(-1, 2).T
    return np.stack([points[0], -points[1]])


def _shapes(root: ElementTree.Element) -> list[ElementTree.Element]:
    return [element for element in root.iter() if element.tag.rpartition("}")[2] in SHAPES]


def _path(text: str, samples: int, where: str) -> Array:
    """Return the points of the longest part of an SVG path, (2, n)."""
    parts: list[list[complex]] = []
    pen = start = handle = 0j
    before = ""
    for command, numbers in re.findall(r"([a-zA-Z])([^a-df-zA-DF-Z]*)", text):
        kind, values = command.upper(), [float(n) for n in NUMBER.findall(numbers)]
        if not parts and kind != "M":
            raise ValueError(f"{where}: the path begins with {command!r}; it must begin with M or m.")
        if kind == "Z":
            pen, before = start, kind
            continue
        if kind not in ARGUMENTS:
            raise ValueError(
                f"{where}: path command {command!r} is not read; turn arcs into Bézier curves first."
            )
        count = ARGUMENTS[kind]
        if not values or len(values) % count:
            raise ValueError(
                f"{where}: path command {command!r} has {len(values)} numbers, not a multiple of {count}."
            )
        for k in range(0, len(values), count):
            origin = pen if command.islower() else 0j
            if kind == "H":
                targets = [complex(origin.real + values[k], pen.imag)]
            elif kind == "V":
                targets = [complex(pen.real, origin.imag + values[k])]
            else:
                targets = [origin + complex(*values[m : m + 2]) for m in range(k, k + count, 2)]
            if kind == "M" and k == 0:
                start = targets[0]
                parts.append([start])
            else:
                if kind in SMOOTH:  # the handle goes on straight from a curve of its kind, else there is none
                    targets = [2 * pen - handle if before in SMOOTH[kind] else pen, *targets]
                parts[-1] += _bezier([pen, *targets], samples if len(targets) > 1 else 1)
            handle = targets[-2] if len(targets) > 1 else targets[-1]
            pen, before = targets[-1], kind
    if not parts:
        raise ValueError(f"{where}: the path is empty; give an outline with at least 8 points.")
    longest = np.array(max(parts, key=lambda part: float(np.abs(np.diff(part)).sum())))
    return np.stack([longest.real, longest.imag])


def _bezier(controls: list[complex], samples: int) -> list[complex]:
    """Return points on a Bézier curve at t = 1/samples ... 1, by repeated interpolation."""
    t = np.arange(1, samples + 1) / samples
    points = [np.full(samples, c) for c in controls]
    while len(points) > 1:
        points = [(1 - t) * a + t * b for a, b in itertools.pairwise(points)]
    return [complex(p) for p in points[0]]
