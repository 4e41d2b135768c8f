"""Kinds of values on the command line, as argparse reads them."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

FIGURES = (".png", ".pdf", ".svg")


def at_least_one(text: str) -> int:
    """Return a whole number of at least 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number of at least 1")
    return int(text)


def natural(text: str) -> int:
    """Return a whole number of at least 0."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number of at least 0")
    return int(text)


def seconds(text: str) -> float:
    """Return a time that is positive and finite."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not 0 < found < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} must be a number of seconds above 0")
    return found


def share(text: str) -> float:
    """Return a share from 0 to 1, given as 3% or 0.03."""
    number, sign, rest = text.partition("%")
    try:
        found = float(number) / (100 if sign else 1)
    except ValueError:
        found = -1.0
    if rest or not 0 < found < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be above 0 and below 100 %, such as 3% or 0.03")
    return found


def task(text: str) -> tuple[int, int]:
    """Return I and N of I/N."""
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise argparse.ArgumentTypeError(f"{text!r} must be I/N, such as 3/20, with I from 1 to N")
    return int(number), int(count)


def assignment(text: str) -> tuple[str, str]:
    """Return a name and its value, as text."""
    name, sign, values = text.partition("=")
    if not (name and sign and values):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form NAME=VALUE")
    return name, values


def span(text: str) -> tuple[float, float]:
    """Return both ends of LOW:HIGH."""
    try:
        low, high = map(float, text.split(":"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} must be LOW:HIGH, such as 0.8:3") from error
    return low, high


def limits(text: str) -> tuple[str, tuple[float, float]]:
    """Return a name and both ends of NAME=LOW:HIGH; of LOW:HIGH, which is of all, the name ""."""
    name, _, ends = text.rpartition("=")
    return name, span(ends)


def smoothness(text: str) -> float | str:
    """Return a number, or "auto"."""
    if text == "auto":
        return text
    try:
        return float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} must be a number or auto") from error


def figure(text: str) -> Path:
    """Return the file of a figure."""
    path = Path(text)
    if path.suffix.lower() not in FIGURES:
        raise argparse.ArgumentTypeError(f"{text!r} must end with {', '.join(FIGURES[:-1])} or {FIGURES[-1]}")
    return path
