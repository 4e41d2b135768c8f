"""Which parameters of a scene are worth changing by hand, in which range, and the scene they make."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from itertools import zip_longest
from operator import attrgetter
from typing import Any, TypeAlias

import numpy as np

from ..figures.style import round_length
from ..parts import Solid
from ..scene import Scene
from ..studies.sweep import read_values, varied

Number: TypeAlias = int | float
Range: TypeAlias = tuple[float, float] | None  # None where a value says nothing about what is sensible

MOST = 8  # sliders
STEPS = 200  # of a slider, at least


def _factor(value: float) -> Range:
    """Range of a growth factor: 1 is no growth."""
    return (1.0, 1.0 + max(0.5, 2 * (value - 1.0))) if value >= 1 else (0.5 * value, 1.5)


def _amount(value: float) -> Range:
    """Range of what must be positive."""
    return (0.2 * value, 3 * value) if value > 0 else None


def _load(value: float) -> Range:
    """Range of what may vanish."""
    return (min(0.0, 3 * value), max(0.0, 3 * value)) if value else None


def _share(value: float) -> Range:
    return (0.0, 0.9) if 0 <= value <= 0.9 else None


def _count(value: float) -> Range:
    return (max(1.0, value // 2), 2 * value) if value > 0 else None


# by part, the parameter that matters most first
OFFERED: Mapping[str, Mapping[str, Callable[[float], Range]]] = {
    "Turing": {"half_waves": _count},
    "EvolvingTuring": {"turing.half_waves": _count, "pace": _amount},
    "TangentialGrowth": {"cortex": _factor, "core": _factor, "modulation": _share, "radial_core": _factor},
    "RateGrowth": {"rate": _amount, "thinning": _share, "radial_rate": _load},
    "Swelling": {"coefficient": _load, "diffusivity": _amount},
    "Imperfection": {"amplitude": _load},
    "Elastic": {"gray.mu": _amount, "white.mu": _amount, "gray.kappa": _amount, "white.kappa": _amount},
    "AxonalTension": {"strength": _load, "patches": _count},
    "PeakLoads": {"strength": _load, "distance": _amount},
    "BoundaryLoads": {"width": _amount},
    "ActiveStress": {"stress": _load},
    "SelfContact": {},
    "Inertia": {"density": _amount},
    "Drag": {"coefficient": _amount},
    "StiffnessDamping": {"time": _amount},
}


@dataclass(frozen=True)
class Knob:
    """A parameter to change: its name, such as "Elastic.gray.mu", its value in the case, and others, sorted.

    The case's own value is one of `values`; whole numbers stay whole.
    """

    parameter: str
    value: Number
    values: tuple[Number, ...]

    @property
    def part(self) -> str:
        """Name of the part it belongs to."""
        return self.parameter.partition(".")[0]

    @property
    def label(self) -> str:
        """Its name within the part."""
        return self.parameter.partition(".")[2]

    def nearest(self, value: float) -> Number:
        """Return the one of its values next to a number."""
        return min(self.values, key=lambda own: abs(own - value))


def knobs(scene: Scene) -> tuple[Knob, ...]:
    """Return at most eight parameters, in the order of the scene's parts; each part's main one before others.

    Parts that are not turingfold's own offer the plain numbers among their fields.
    """
    rows = [_knobs_of(scene, part) for part in parts(scene)]
    ranked = [knob for row in zip_longest(*rows) for knob in row if knob is not None][:MOST]
    return tuple(knob for row in rows for knob in row if knob in ranked)


def parts(scene: Scene) -> tuple[Any, ...]:
    """Return the parts that can be told apart by name, processes first."""
    every = (*scene.processes, *scene.terms)
    names = [type(part).__name__ for part in every]
    return tuple(part for part, name in zip(every, names, strict=True) if names.count(name) == 1)


def removable(part: Any) -> bool:
    """Return whether a body may do without a part: all but its elasticity."""
    return not isinstance(part, Solid)


def _knobs_of(scene: Scene, part: Any) -> list[Knob]:
    offered = OFFERED.get(type(part).__name__)
    if offered is None:
        offered = {name: _count if _is_whole(part, name) else _amount for name in _plain_numbers(part)}
    found = (_knob(scene, part, name, reach) for name, reach in offered.items())
    return [knob for knob in found if knob is not None and _accepted(scene, knob)]


def _plain_numbers(part: Any) -> list[str]:
    own = [field.name for field in fields(part) if field.init] if is_dataclass(part) else []
    return [name for name in own if type(getattr(part, name)) in (int, float)]


def _is_whole(part: Any, name: str) -> bool:
    """Return whether a field is declared as a whole number; one declared as a float may be written as 1."""
    return any(field.name == name and field.type in ("int", int) for field in fields(part))


def _knob(scene: Scene, part: Any, name: str, reach: Callable[[float], Range]) -> Knob | None:
    owner, _, last = name.rpartition(".")
    holder = attrgetter(owner)(part) if owner else part
    if holder is None:  # such as a body without white matter
        return None
    value = getattr(holder, last)
    limits = reach(value)
    if limits is None:
        return None
    if _is_whole(holder, last):
        # a mirror-symmetric pattern has an even number of half waves
        even = scene.body.mirror or getattr(holder, "symmetric", False)
        values = _whole_numbers(value, limits, 2 if even and last == "half_waves" else 1)
    else:
        values = _round_numbers(value, limits)
    return Knob(f"{type(part).__name__}.{name}", value, values)


def _whole_numbers(value: int, limits: tuple[float, float], step: int) -> tuple[Number, ...]:
    first = value - step * int((value - limits[0]) // step)
    return tuple(range(first, int(limits[1]) + 1, step))


def _round_numbers(value: float, limits: tuple[float, float]) -> tuple[Number, ...]:
    """Return evenly spaced numbers of few digits, and the value itself."""
    low, high = limits
    step = round_length((high - low) / STEPS)
    digits = -int(np.floor(np.log10(step)))
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return tuple(sorted({round(k * step, digits) for k in range(first, last + 1)} | {value}))


def _accepted(scene: Scene, knob: Knob) -> bool:
    """Return whether the scene takes another value at all: growth need not follow a pattern, for instance."""
    try:
        varied(scene, {knob.parameter: [next(v for v in knob.values if v != knob.value)]})
    except (StopIteration, ValueError):
        return False
    return True


class Settings:
    """What is changed of a scene: values by parameter, and the parts that are left out."""

    def __init__(self, scene: Scene) -> None:
        """Start from the scene as it is."""
        self.original = scene
        self.values: dict[str, Any] = {}
        self.absent: set[str] = set()

    def read(self, text: str) -> tuple[str, Any]:
        """Return parameter and value of a text such as "AxonalTension.ramp=0.2".

        Raises ValueError for what the scene does not have, not for values that its parts refuse; see `made`.
        """
        parameter, sign, word = (piece.strip() for piece in text.partition("="))
        if not (parameter and sign and word):
            raise ValueError(f"{text!r} is not of the form PART.NAME=VALUE, such as AxonalTension.ramp=0.2.")
        found = read_values(word, self.original, parameter)
        if len(found) != 1:
            raise ValueError(f"{text!r} lists {len(found)} values; give one.")
        return parameter, found[0]

    def changes(self) -> dict[str, list[Any]]:
        """Return what `varied` takes: values first, then the parts left out, each before what it reads."""
        found = {
            parameter: [value]
            for parameter, value in self.values.items()
            if parameter.partition(".")[0] not in self.absent
        }
        every = (*self.original.terms, *self.original.processes[::-1])
        names = [type(part).__name__ for part in every]
        return found | {name: ["off"] for name in names if name in self.absent}

    def made(self) -> tuple[str, Scene]:
        """Return the changed scene and its name, "" if nothing is changed; raises ValueError."""
        changes = self.changes()
        if not changes:
            return "", self.original
        ((name, scene),) = varied(self.original, changes).items()
        return name, scene

    def assignments(self) -> tuple[tuple[str, str], ...]:
        """Return the changes as texts from which `read_values` makes the same values."""
        return tuple((name, _as_text(value)) for name, (value,) in self.changes().items())


def _as_text(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return value if isinstance(value, str) else repr(value)
