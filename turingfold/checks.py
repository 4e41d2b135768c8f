"""Checks of input: each raises a ValueError that names the argument, its value, the bound and a remedy."""

from __future__ import annotations

import os
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FEW, LONGEST = 6, 200  # values of an array, and signs, that a message repeats


def finite(name: str, value: Any, remedy: str = "") -> float:
    """Return value as a float if it is a finite real number."""
    if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(float(value)):
        raise ValueError(_message(name, value, "a finite number", remedy))
    return float(value)


def positive(name: str, value: Any, *, at_most: float = float("inf"), remedy: str = "") -> float:
    """Return value as a float if 0 < value <= at_most."""
    number = finite(name, value, remedy)
    if not 0 < number <= at_most:
        bound = "positive" if np.isinf(at_most) else f"positive and at most {at_most:g}"
        raise ValueError(_message(name, value, bound, remedy))
    return number


def between(name: str, value: Any, low: float, high: float, remedy: str = "") -> float:
    """Return value as a float if low <= value <= high."""
    number = finite(name, value, remedy)
    if not low <= number <= high:
        raise ValueError(_message(name, value, f"between {low:g} and {high:g}", remedy))
    return number


def instance(name: str, value: Any, kind: type, example: str) -> None:
    """Refuse what is no instance of a class or protocol; a class itself is none."""
    if isinstance(value, type) or not isinstance(value, kind):
        shown = f"{value.__name__} (a class)" if isinstance(value, type) else repr(value)
        raise ValueError(f"{name}={shown} must be a {kind.__name__} object, such as {example}.")


def whole(name: str, value: Any, *, at_least: int, remedy: str = "") -> int:
    """Return value as an int if it is a whole number >= at_least."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < at_least:
        raise ValueError(_message(name, value, f"a whole number of at least {at_least}", remedy))
    return int(value)


def file_path(name: str, value: Any, kinds: str) -> Path:
    """Return value as a path if it is a text or a path, and a file is there."""
    if not isinstance(value, str | os.PathLike):
        raise ValueError(f"{name}={value!r} must be the path of {kinds}, as a text or a Path.")
    file = Path(value)
    if not file.is_file():
        raise ValueError(f"there is no file {file}; give the path of {kinds}.")
    return file


def one_of(name: str, value: Any, known: tuple[str, ...]) -> str:
    """Return value if it is one of the known words."""
    if value not in known:
        raise ValueError(_message(name, value, "one of " + ", ".join(map(repr, known)), ""))
    return str(value)


def real_array(name: str, value: Any) -> NDArray[np.float64]:
    """Return value as an array of real numbers."""
    try:
        given = np.asarray(value)
        complex_numbers = given.dtype.kind == "c"
        array = np.asarray(given.real if complex_numbers else given, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}={_shown(value)} must be an array of numbers.") from error
    if complex_numbers:
        raise ValueError(f"{name} is complex; it must be real: give points as rows of x and of y.")
    return array


def finite_array(name: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """Return value as a real array of the given shape (None: any length) without NaN or infinity."""
    array = real_array(name, value)
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        lengths = ", ".join("n" if n is None else str(n) for n in shape)
        wanted = f"({lengths},)" if len(shape) == 1 else f"({lengths})"
        raise ValueError(f"{name} has shape {array.shape}; it must be {wanted}.")
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} is {array[where]} at index {where}; every value must be finite.")
    return array


def _shown(value: Any) -> str:
    """Return a value as Python writes it; of many numbers and long texts only the ends."""
    if isinstance(value, np.ndarray) and value.size > FEW:
        return f"an array of shape {value.shape}"
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 4 :]}"


def _message(name: str, value: Any, bound: str, remedy: str) -> str:
    shown = f"{value:g}" if isinstance(value, float) else _shown(value)
    return f"{name}={shown} must be {bound}" + (f"; {remedy}" if remedy else "") + "."
