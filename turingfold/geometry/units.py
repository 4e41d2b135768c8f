"""Units of length of files, and words where numbers look like another unit."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..checks import positive

METRES = {
    "m": 1.0, "meter": 1.0, "metre": 1.0, "cm": 1e-2, "centimetre": 1e-2, "centimeter": 1e-2,
    "mm": 1e-3, "millimetre": 1e-3, "millimeter": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "micron": 1e-6,
    "micrometre": 1e-6, "micrometer": 1e-6, "nm": 1e-9, "nanometre": 1e-9, "nanometer": 1e-9,
    "in": 0.0254, "inch": 0.0254, "inches": 0.0254,
}  # fmt: skip
KNOWN = "m, cm, mm, um, µm, micron, nm, in, inch"
NOT_READ = (  # known, too, and refused
    "px", "pixel", "voxel", "decimetre", "decimeter", "furlong", "angstrom", "percent", "pascal",
)  # fmt: skip
WORDS = ("m", "in")  # units that are other words besides
DIRECTION = re.compile(
    "[xyzlrapsidvnew]|ap|pa|dv|ml|lr|rl|is|si|ras|lps|las|lpi|up|down|left|right|top|back|in|out|"
    "east|west|lat|med|ant|post|sup|inf|rows?|cols?"
)
SHORT = 4  # letters of an abbreviation
UNIT = rf"(?:{'|'.join(sorted((*METRES, *NOT_READ), key=len, reverse=True))})s?"
CLEAR = rf"(?!(?:{'|'.join(WORDS)})s?(?![^\W_])){UNIT}"
UNMISTAKABLE = rf"(?<![^\W_])({CLEAR})(?![^\W_])"
BRACKETS = re.compile(r"[\[({<]\s*([^\])}>]*?)\s*[\])}>]")
IN_BRACKETS = re.compile(r".*[\[({<]\s*([^\])}>]*?)\s*[\])}>]")
AT_THE_END = re.compile(rf"(?:[xy][\W_]*|.*/\s*)({UNIT})|(?:.*[\W_])?({CLEAR})", re.IGNORECASE)
AMONG_WORDS = re.compile(UNMISTAKABLE, re.IGNORECASE)
OF_NO_NUMBER = re.compile(rf"(?<!\d\s){UNMISTAKABLE}", re.IGNORECASE)
COLUMNS = re.compile(r"\W*(x\b.*?)[,;\s]\s*(y\b.*)", re.IGNORECASE)
DECLARED = re.compile(
    r"\bunits?(?:\s+of\s+length)?\s*(?:[:=]|\bis\b|\bare\b)[\s\"'\[(]*(?:in\s+(?=[^\W\d_]))?((?:[\d.,]+(?:e[-+]?\d+)?\s*)?[^\W\d_]+)",
    re.IGNORECASE,
)
BRIEF = re.compile(rf"(?:.*\bunits?)?\W*(?:in\s+)?{UNMISTAKABLE}\W*(?:{UNIT}|units?)?\W*", re.IGNORECASE)
ALL = r"\b(?:coordinates|points|positions|lengths|distances|numbers|values|all)\b"
OF_ALL = rf"{ALL}[^.;:]*"
SPOKEN = re.compile(rf"{OF_ALL}\bin\s+{UNMISTAKABLE}", re.IGNORECASE)
BRACKETED = re.compile(
    rf"{OF_ALL}[\[({{<]\s*({CLEAR})\s*[\])}}>]|{ALL}\s*[\[({{<]\s*({UNIT})\s*[\])}}>]", re.IGNORECASE
)
MEASURE = rf"[.,]?\d[\d.,]*(?:e[-+]?\d+)?\s*{CLEAR}(?![^\W_])"
PIXEL = r"(?:px|pixels?|voxels?|units?)\b"
SCALED = re.compile(
    rf"\bscale\s*(?:(?:[:=\[({{<]|is\b)\s*(?:in\s+)?|in\s+)({CLEAR}(?![^\W_])|{MEASURE})"
    rf"|\bscale\s*(?:[:=\[({{<]|is\b)\s*({UNIT})\s*(?:$|[\])}}>,;.])|\b(?:scale(?!\W*bar)|spacing|resolution|{PIXEL})"
    rf"[^,;.\d]{{0,20}}({MEASURE})|({MEASURE})\s*(?:/|per\b)\s*{PIXEL}",
    re.IGNORECASE,
)
LARGE = 10.0  # no brain has so many metres, and a body without units is seldom drawn so large


def unit_of(word: str) -> float | None:
    """Return the length in m of a unit that a file names, in capitals or not, or None if it is none."""
    found = word.strip().lower()
    return METRES.get(found, METRES.get(found.removesuffix("s")))


def metres(unit: str | float) -> float:
    """Return the length in m of a unit: a word such as "mm", or a number of metres.

    Raises ValueError for words that are no unit of length, and for numbers that are not positive.
    """
    if not isinstance(unit, str):
        return positive("unit", unit, remedy='give the length of a unit in m, or a word such as "mm"')
    found = unit_of(unit)
    if found is None:
        raise ValueError(f"unit={unit!r} must be one of {KNOWN}, or a number of metres.")
    return found


def is_unit(word: str) -> bool:
    """Return whether what a file has in brackets, or as a whole field, stands for a unit, known or not.

    Numbers, dashes, directions, several words, and words longer than abbreviations do not, unless a unit is
    among them.
    """
    found = word.lower()
    if found in METRES or AMONG_WORDS.search(found):
        return True
    letters = re.findall(r"[^\W\d_]+", found)
    if not letters:
        return bool(re.search(r"[^\d\s.,+-]", found))  # as "%"
    several = sum(part.isalpha() for part in found.split()) > 1
    short = max(map(len, letters)) <= SHORT
    return short and not several and not all(map(DIRECTION.fullmatch, letters))


def units_of_header(fields: Sequence[str]) -> list[str]:
    """Return the words that stand for units in the fields of a header: "x (mm)", "x_mm", "xmm", "mm".

    What two columns have in brackets may be units, known or not, and so may a word that is both fields. Among
    the words of other text only those count that mean nothing else, so neither "in" nor "m", and that are not
    of a number: "smoothed by 2 mm".
    """
    line = " ".join(fields)
    if len(fields) != 2:
        both = BRACKETS.findall(line)
        if len(both) == 2 and both[0] == both[1]:
            return [word for word in both if is_unit(word)]
        return OF_NO_NUMBER.findall(line)
    matches = [IN_BRACKETS.fullmatch(field) for field in fields]
    brackets = [match[1] for match in matches if match]
    whole = fields[0] == fields[1] or all(unit_of(field) for field in fields)
    if len(brackets) == 2 or whole:
        words = [word for word in (brackets or fields) if is_unit(word)]
        return words if len(words) == 2 else [word for word in words if word.lower() not in WORDS]
    ends = [match[1] if match else unit_of_name(f) for match, f in zip(matches, fields, strict=True)]
    return [word for word in ends if word and re.fullmatch(UNIT, word, re.IGNORECASE)]


def units_of_comment(text: str) -> list[str]:
    """Return the words that stand for units in a comment as in a header: "units: cm", "x (mm), y (mm)"."""
    columns = COLUMNS.fullmatch(text.strip())
    found = units_of_header([columns[1].strip(" ,;"), columns[2].strip()]) if columns else []
    return found or DECLARED.findall(text)


def units_spoken(text: str) -> list[str]:
    """Return the units that a comment says in words: "all points in mm", "coordinates (cm)", "mm, mm"."""
    brief = BRIEF.fullmatch(text)
    found = SPOKEN.findall(text) or ["".join(words) for words in BRACKETED.findall(text)]
    return found or ([brief[1]] if brief else [])


def units_in_passing(text: str) -> list[str]:
    """Return the units that a header or a comment mentions otherwise: "sampled every mm", not "2 mm"."""
    return OF_NO_NUMBER.findall(text)


def scales_of(text: str) -> list[str]:
    """Return what text says that a unit is long: "scale: mm", "1 px = 0.1 mm", "0.1 mm per pixel"."""
    return ["".join(found).strip() for found in SCALED.findall(text)]


def unit_of_name(column: str) -> str | None:
    """Return the word at the end of a column's name that stands for a unit: "thickness_mm", "x in", "t / m".

    "in" and "m" are other words in names such as "growth_in".
    """
    found = AT_THE_END.fullmatch(column)
    return found and (found[1] or found[2])


def note_large(source: str, loops: Sequence[Array], remedy: str, unit: float | None = None) -> None:
    """Warn of curves (2, n) of 10 m or more: their numbers are probably millimetres.

    unit: in which they were read, m, if it was stated: then that is wrong. A single point far off makes no
    curve large.
    """
    if not loops:
        return
    points = np.concatenate(list(loops), axis=1)
    width, height = np.ptp(points, axis=1)
    most = np.ptp(np.quantile(points, (0.05, 0.95), axis=1), axis=0)
    if max(width, height) < LARGE or max(most) < LARGE / 2:
        return
    words = f"{source} is {width:g} by {height:g} large, read as metres; if they are mm, {remedy}."
    if unit is not None:
        words = (
            f"{source} is {width:g} by {height:g} m large, its numbers read in units of {unit:g} m, as "
            "stated; if they are in others, give unit=."
        )
    warnings.warn(words, stacklevel=3)
