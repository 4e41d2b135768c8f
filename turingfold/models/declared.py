"""Parameters of a case: the keyword-only arguments of its `scenes`, read from the signature.

    Radius = Annotated[float, Parameter("m", 0.005, 0.2, "radius of the brain")]

    @quick(elements=2)
    def scenes(quick=False, *, radius: Radius = 0.0404, elements: int = 6): ...

Names and values come from the signature; unit, range, label and choices from the annotation. With the
default None ("auto" on the command line) the case chooses the value by its other parameters.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import wraps
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np

from ..checks import finite

Scenes = Callable[..., dict[str, Any]]

SWITCHES = {"on": True, "off": False, "true": True, "false": False, "yes": True, "no": False}
KINDS = {float: "a number", int: "a whole number", bool: "on or off", str: "a word"}
CHOSEN = "auto"  # None on the command line: the case chooses the value by others
QUICK = "quick_values"  # attribute of a decorated function
MOST_VALUES = 100_000  # of one parameter; six digits, as in names, tell about as many apart


@dataclass(frozen=True)
class Parameter:
    """Unit, range, label and choices of a case's parameter, given by an annotation.

    unit: "m", "Pa", ...; "" for pure numbers.  low, high: the range, both ends included.  label: what it is,
    in a few words.  choices: the words it may have.  remedy: a sentence for those who miss the range.
    """

    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    label: str = ""
    choices: tuple[str, ...] = ()
    remedy: str = ""

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(f"low={self.low!r} must be at most high={self.high!r}.")
        if isinstance(self.choices, str) or not all(isinstance(word, str) for word in self.choices):
            raise ValueError(f"choices={self.choices!r} must be a tuple of words.")


@dataclass(frozen=True)
class Declared:
    """A parameter as a case declares it: name, kind of its values, default and meaning."""

    name: str
    kind: type
    default: Any
    meaning: Parameter

    def checked(self, value: Any) -> Any:
        """Return a value in the parameter's kind; raises ValueError where it is none, or out of range."""
        if value is None and self.default is None:
            return None
        if self.kind is bool:
            if not isinstance(value, bool):
                raise self._of_another_kind(value)
            return value
        if self.kind is str:
            if not isinstance(value, str):
                raise self._of_another_kind(value)
            return self._word(value)
        try:
            number = finite(self.name, value)
        except ValueError as error:
            raise self._of_another_kind(value) from error
        if self.kind is int and not number.is_integer():
            raise self._of_another_kind(value)
        self._check_range(number)
        return int(number) if self.kind is int else number

    def read(self, text: str) -> Any:
        """Return the value that a text gives; raises ValueError for another kind, or out of range."""
        text = text.strip()
        if text == CHOSEN and self.default is None:
            return None
        if self.kind is bool:
            if text.lower() not in SWITCHES:
                raise self._of_another_kind(text)
            return SWITCHES[text.lower()]
        if self.kind is str:
            return self._word(text)
        try:
            number = float(text)
        except ValueError as error:
            raise self._of_another_kind(text) from error
        return self.checked(number)

    def read_list(self, text: str) -> list[Any]:
        """Return values from "1.5,1.7,1.9", or from "1.5:1.9:3", three evenly spaced numbers."""
        if ":" not in text or self.kind in (bool, str):
            return [self.read(word) for word in text.split(",")]
        return [self.checked(number) for number in evenly_spaced(self.name, text)]

    def shown(self, value: Any) -> str:
        """Return a value as it is given on the command line, numbers to six digits."""
        return as_text(value)

    @property
    def range(self) -> str:
        """The values it may have, in words."""
        low, high = self.meaning.low, self.meaning.high
        if self.kind is bool or self.meaning.choices:
            return " | ".join(self.meaning.choices or ("on", "off"))
        if math.isinf(low) and math.isinf(high):
            return KINDS[self.kind]
        unit = f" {self.meaning.unit}" if self.meaning.unit else ""
        if math.isinf(high):
            return f"at least {low:g}{unit}"
        return f"at most {high:g}{unit}" if math.isinf(low) else f"{low:g} to {high:g}{unit}"

    def _word(self, word: str) -> str:
        known = self.meaning.choices
        if known and word not in known:
            near = nearest(word, known) or "."
            raise ValueError(f"{self.name}={word} must be one of {', '.join(known)}{near}")
        return word

    def _check_range(self, number: float) -> None:
        low, high, unit = self.meaning.low, self.meaning.high, self.meaning.unit
        if low <= number <= high:
            return
        label = f", {self.meaning.label}" if self.meaning.label else ""
        words = f"{self.name}={number:g} is out of range ({self.range}{label})"
        if self.meaning.remedy:
            words += f"; {self.meaning.remedy}"
        elif unit == "m" and low <= 1e-3 * number <= high:
            words += f"; it is in m: {number:g} mm are {1e-3 * number:g}"
        elif unit == "Pa" and low <= 1e3 * number <= high:
            words += f"; it is in Pa: {number:g} kPa are {1e3 * number:g}"
        raise ValueError(f"{words}.")

    def _of_another_kind(self, value: Any) -> ValueError:
        kind = KINDS[self.kind] + (f" in {self.meaning.unit}" if self.meaning.unit else "")
        example = f"or {CHOSEN}" if self.default is None else f"such as {as_text(self.default)}"
        return ValueError(f"{self.name}={value} must be {kind}, {example}.")


def quick(**values: Any) -> Callable[[Scenes], Scenes]:
    """Return a decorator of `scenes` that gives parameters other defaults in the quick version.

    What a caller gives wins there, too. Raises ValueError for names that `scenes` does not have.
    """

    def decorated(scenes: Scenes) -> Scenes:
        @wraps(scenes)
        def made(quick: bool = False, **given: Any) -> dict[str, Any]:
            return scenes(quick, **(values | given if quick else given))

        setattr(made, QUICK, values)
        known = declared(made)
        for name, value in values.items():
            find(known, name).checked(value)
        return made

    return decorated


def declared(scenes: Scenes) -> dict[str, Declared]:
    """Return the parameters of a case by name, from the signature of its `scenes`.

    Raises ValueError for one without a default, or whose kind is neither number, switch nor word.
    """
    hints = get_type_hints(scenes, include_extras=True)
    found = {}
    for name, given in inspect.signature(scenes).parameters.items():
        if given.kind is not inspect.Parameter.KEYWORD_ONLY:
            continue
        kind, meaning = _annotated(hints.get(name), given.default)
        if given.default is inspect.Parameter.empty or kind not in KINDS:
            raise ValueError(
                f"scenes(..., *, {given}): a parameter of a case has a default, and is a number, a whole "
                f"number, True or False, or a word; such as {name}: float = 1.0."
            )
        found[name] = Declared(name, kind, given.default, meaning)
    return found


def values_of(scenes: Scenes, given: Mapping[str, Any], *, quick: bool) -> dict[str, Any]:
    """Return the values of all parameters: defaults, those of the quick version, and what is given."""
    own = getattr(scenes, QUICK, {}) if quick else {}
    return {name: one.default for name, one in declared(scenes).items()} | own | dict(given)


def find(known: Mapping[str, Declared], name: str) -> Declared:
    """Return a parameter by its name; raises ValueError for an unknown one, with the nearest known."""
    if name in known:
        return known[name]
    if not known:
        raise ValueError(
            f"the case has no parameter {name}: its scenes() takes none. Give it one as a keyword argument, "
            f"def scenes(quick=False, *, {name}: float = ...), or vary a value of a part, PART.NAME."
        )
    raise ValueError(f"the case has no parameter {name}{nearest(name, known)}; it has: {', '.join(known)}.")


def nearest(word: str, known: Mapping[str, Any] | tuple[str, ...]) -> str:
    """Return "; did you mean X?" for the known word that is spelt most alike, "" if none is."""
    lower = {name.lower(): name for name in known}
    close = get_close_matches(word.lower(), lower, 1)
    return f"; did you mean {lower[close[0]]}?" if close else ""


def evenly_spaced(name: str, text: str) -> list[float]:
    """Return the numbers of "first:last:count"; raises ValueError where it says none, or too many."""
    try:
        low, high, number = text.split(":")
        first, last, count = float(low), float(high), int(number)
    except ValueError as error:
        raise ValueError(f"{name}={text} must be FIRST:LAST:COUNT, such as 1.5:1.9:3.") from error
    for end, value in (("first", first), ("last", last)):
        if not math.isfinite(value):
            raise ValueError(f"{name}={text}: the {end} value is {value}; give two finite numbers.")
    if count < 1:
        raise ValueError(f"{name}={text} lists no value; the count must be at least 1.")
    if count > MOST_VALUES:
        raise ValueError(
            f"{name}={text} lists {count} values; the count must be at most {MOST_VALUES}: give fewer, or a "
            "part of the range at a time."
        )
    numbers: list[float] = np.linspace(first, last, count).tolist()
    return numbers


def as_text(value: Any) -> str:
    """Return a value as the command line reads it, numbers to six digits."""
    if value is None:
        return CHOSEN
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _annotated(hint: Any, default: Any) -> tuple[type, Parameter]:
    """Return kind and meaning that an annotation gives, else the kind of the default."""
    meaning = Parameter()
    if get_origin(hint) is Annotated:
        hint, *more = get_args(hint)
        meaning = next((one for one in more if isinstance(one, Parameter)), meaning)
    if get_origin(hint) is UnionType:  # `int | None`: None where the case chooses
        hint = next(one for one in get_args(hint) if one is not NoneType)
    if get_origin(hint) is Literal:
        words = get_args(hint)
        return str, Parameter(label=meaning.label, choices=words)
    return (hint if isinstance(hint, type) else type(default)), meaning
