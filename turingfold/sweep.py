"""Scenes that differ in the values of some parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from .checks import instance
from .scene import Scene

SWITCHES = {"true": True, "false": False, "on": True, "off": False}


def varied(scene: Scene, values: Mapping[str, Sequence[Any]]) -> dict[str, Scene]:
    """Return the scene with each combination of values, by names such as "cortex=1.7, strength=0.5".

    values: for each parameter the values it takes. A parameter is "Part.name", for a term or process that is
    there once, such as "TangentialGrowth.cortex" or "Elastic.gray.mu"; "Scene.until", "Scene.seed",
    "Stepping.largest"; or "Part" alone, with the values "on" and "off", to leave the part out.
    Raises ValueError for parameters that the scene does not have, and where a part refuses a value.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    if not values or not all(values.values()):
        raise ValueError(f"values={dict(values)!r}: give one parameter or more, and a value or more of each.")
    found = {}
    for combination in product(*values.values()):
        changed = scene
        for parameter, value in zip(values, combination, strict=True):
            changed = _with(changed, parameter, value)
        found[", ".join(map(_named, values, combination))] = changed
    return found


def read_values(text: str, scene: Scene, parameter: str) -> list[Any]:
    """Return the values of a parameter that a text lists, of the kind that it has in the scene.

    text: "1.5,1.7,1.9", or "1.5:1.9:3" for three evenly spaced numbers.
    Raises ValueError for another kind of values, and for parameters that are no number, word or switch.
    """
    part, *names = parameter.split(".")
    now = _part(scene, part)
    for name in names:
        now = _value(now, name, parameter)
    words = text.split(",")
    try:
        if not names or isinstance(now, str):
            return words
        if isinstance(now, bool):
            return [SWITCHES[word] for word in words]
        if not isinstance(now, (int, float)):
            raise ValueError(f"{parameter} is neither a number nor a word")
        if ":" in text:
            start, stop, count = text.split(":")
            return [float(value) for value in np.linspace(float(start), float(stop), int(count))]
        return [int(word) if isinstance(now, int) and word.isdecimal() else float(word) for word in words]
    except (ValueError, KeyError) as error:
        raise ValueError(
            f"{parameter}={text}: it is {now!r} in the case; list values of that kind, such as 1.5,1.7 or, "
            "for numbers, 1:2:5."
        ) from error


def _named(parameter: str, value: Any) -> str:
    shown = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"{parameter.rpartition('.')[2]}={shown}"


def _with(scene: Scene, parameter: str, value: Any) -> Scene:
    part, *names = parameter.split(".")
    old = _part(scene, part)
    if not names:
        if value not in ("on", "off"):
            raise ValueError(f"{parameter}={value!r}: a part is 'on' or 'off'; or vary its {_names(old)}.")
        return scene if value == "on" else _without(scene, old)
    new = _changed(old, names, value, parameter)
    if isinstance(new, Scene):
        return new
    if old is scene.stepping:
        return replace(scene, stepping=new)
    return replace(
        scene,
        terms=tuple(new if term is old else term for term in scene.terms),
        processes=tuple(new if process is old else process for process in scene.processes),
    )


def _without(scene: Scene, part: Any) -> Scene:
    if part is scene or part is scene.stepping:
        raise ValueError(f"{type(part).__name__} cannot be left out; vary its {_names(part)}.")
    terms = tuple(term for term in scene.terms if term is not part)
    return replace(scene, terms=terms, processes=tuple(p for p in scene.processes if p is not part))


def _changed(part: Any, names: Sequence[str], value: Any, parameter: str) -> Any:
    old = _value(part, names[0], parameter)
    new = value if len(names) == 1 else _changed(old, names[1:], value, parameter)
    return replace(part, **{names[0]: new})


def _part(scene: Scene, name: str) -> Any:
    parts = [scene, scene.stepping, *scene.terms, *scene.processes]
    found = [part for part in parts if type(part).__name__ == name]
    if len(found) != 1:
        known = ", ".join(dict.fromkeys(type(part).__name__ for part in parts))
        raise ValueError(f"the scene has {len(found) or 'no'} {name}; it has: {known}.")
    return found[0]


def _value(part: Any, name: str, parameter: str) -> Any:
    if not is_dataclass(part) or name not in _own(part):
        raise ValueError(f"{parameter}: {type(part).__name__} has no {name!r}; it has: {_names(part)}.")
    return getattr(part, name)


def _own(part: Any) -> Iterable[str]:
    return [field.name for field in fields(part) if field.init] if is_dataclass(part) else []


def _names(part: Any) -> str:
    return ", ".join(_own(part)) or "no values"
