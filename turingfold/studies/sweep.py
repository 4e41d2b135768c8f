"""Scenes that differ in the values of some parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import permutations, product
from typing import Any

from ..checks import instance
from ..models.declared import Declared, Parameter, as_text
from ..scene import Scene


def varied(scene: Scene, values: Mapping[str, Sequence[Any]]) -> dict[str, Scene]:
    """Return the scene with each combination of values, by names such as "cortex=1.7, strength=0.5".

    A name has numbers to six digits, and as much of the end of each parameter as tells it from the others:
    "gray.mu=2, white.mu=3".
    values: for each parameter the values it takes. A parameter is "Part.name", for a term or process that is
    there once, such as "TangentialGrowth.cortex" or "Elastic.gray.mu"; "Scene.until", "Scene.seed",
    "Stepping.largest"; or "Part" alone, with the values "on" and "off", to leave the part out.
    Raises ValueError for parameters that the scene does not have, where a part refuses a value, for values of
    one name, and for a parameter beside a part of it, such as "AxonalTension" and "AxonalTension.strength".
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    check_lists(values)
    found = {}
    for combination in product(*values.values()):
        chosen, changed = dict(zip(values, combination, strict=True)), scene
        for parameter, value in chosen.items():
            changed = with_value(changed, parameter, value)
        found[name_of(chosen)] = changed
    return found


def check_lists(values: Mapping[str, Sequence[Any]]) -> None:
    """Raise ValueError for no values, values of one name, and a parameter beside a part of it."""
    _check(values)
    labels = _labels(values)
    for parameter, listed in values.items():
        _check_names(parameter, [_named(labels[parameter], value) for value in listed], listed)


def name_of(values: Mapping[str, Any]) -> str:
    """Return the name of values by parameter, such as "cortex=1.7, strength=0.5"; see `varied`."""
    return ", ".join(map(_named, _labels(values).values(), values.values()))


def read_values(text: str, scene: Scene, parameter: str) -> list[Any]:
    """Return the values of a parameter that a text lists, of the kind that it has in the scene.

    text: "1.5,1.7,1.9", or "1.5:1.9:3" for three evenly spaced numbers, whole ones where it is whole now.
    Raises ValueError for another kind of values, and for parameters that are no number, word or switch.
    """
    if "." not in parameter:
        _part(scene, parameter)
        return text.split(",")
    part, *names = parameter.split(".")
    owner = _part(scene, part)
    for name in names[:-1]:
        owner = _value(owner, name, parameter)
    now = _value(owner, names[-1], parameter)
    if not isinstance(now, str | int | float):
        raise ValueError(f"{parameter} is {now!r}, neither a number nor a word; vary one of its values.")
    kind: type = type(now)
    if kind is int:  # perhaps a whole number in the place of any
        kind = int if _types(owner)[names[-1]] in (int, "int") else float
    return Declared(parameter, kind, now, Parameter()).read_list(text)


def settable(scene: Scene) -> dict[str, Any]:
    """Return what `varied` can change of a scene, numbers, words and switches, by name, with their values.

    Parts that are there more than once, and what is neither, cannot be named.
    """
    parts = [scene, scene.stepping, *scene.terms, *scene.processes]
    kinds = Counter(type(part).__name__ for part in parts)
    found: dict[str, Any] = {}
    for part in parts:
        if kinds[name := type(part).__name__] == 1:
            for own in ("until", "seed") if part is scene else _own(part):
                found.update(_plain(f"{name}.{own}", getattr(part, own)))
    return found


def _plain(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, str | int | float):
        yield name, value
    elif isinstance(value, tuple):
        for number, item in enumerate(value):
            yield from _plain(f"{name}.{number}", item)
    else:
        for own in _own(value):
            yield from _plain(f"{name}.{own}", getattr(value, own))


def is_part(parameter: str) -> bool:
    """Return whether a name is one of a part, or of a value of it, and not of a case's parameter."""
    return "." in parameter or parameter[:1].isupper()


def value_of(scene: Scene, parameter: str) -> Any:
    """Return the value of a parameter, or whether a part is there: "on" or "off"."""
    part, *names = parameter.split(".")
    if not names:
        return "on" if part in (type(own).__name__ for own in (*scene.terms, *scene.processes)) else "off"
    now = _part(scene, part)
    for name in names:
        now = _value(now, name, parameter)
    return now


def _check(values: Mapping[str, Sequence[Any]]) -> None:
    """Raise ValueError for what are no values of parameters, and for parameters that change each other."""
    for parameter, listed in values.items():
        if isinstance(listed, str) or not isinstance(listed, Sequence):
            raise ValueError(f"{parameter}={listed!r} must be a list or tuple of values, also of one.")
    if not values or not all(values.values()):
        raise ValueError(f"values={dict(values)!r}: give one parameter or more, and a value or more of each.")
    for whole, part in permutations(values, 2):
        if part.startswith(f"{whole}."):
            raise ValueError(
                f"{whole} and {part}, a part of it, cannot be varied together; vary them in two sweeps."
            )


def _check_names(parameter: str, names: Sequence[str], values: Sequence[Any]) -> None:
    """Raise ValueError where two values of a parameter have one name."""
    seen: dict[str, Any] = {}
    for name, value in zip(names, values, strict=True):
        if name in seen:
            raise ValueError(
                f"{parameter} has the values {seen[name]!r} and {value!r}, both named {name!r}; leave one "
                "out, or let them differ in six digits."
            )
        seen[name] = value


def _labels(parameters: Iterable[str]) -> dict[str, str]:
    """Return by parameter the shortest end of its name, in whole words, that is no end of another's."""
    ends = {}
    for parameter in parameters:
        words = parameter.split(".")
        ends[parameter] = [".".join(words[-count:]) for count in range(1, len(words) + 1)]
    shared = Counter(end for own in ends.values() for end in own)
    return {whole: next((end for end in own if shared[end] == 1), whole) for whole, own in ends.items()}


def _named(label: str, value: Any) -> str:
    return f"{label}={as_text(value)}"


def with_value(scene: Scene, parameter: str, value: Any) -> Scene:
    """Return the scene with another value of one parameter; see `varied`."""
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
    if isinstance(part, tuple):
        return tuple(new if number == int(names[0]) else item for number, item in enumerate(part))
    return replace(part, **{names[0]: new})


def _part(scene: Scene, name: str) -> Any:
    parts = [scene, scene.stepping, *scene.terms, *scene.processes]
    found = [part for part in parts if type(part).__name__ == name]
    if len(found) != 1:
        known = ", ".join(dict.fromkeys(type(part).__name__ for part in parts))
        raise ValueError(f"the scene has {len(found) or 'no'} {name}; it has: {known}.")
    return found[0]


def _value(part: Any, name: str, parameter: str) -> Any:
    if isinstance(part, Scene) and name == "body":
        raise ValueError(
            f"{parameter} would leave the mesh, and all that is made from it, as it is; vary the parameter "
            "of the case that its body is made with (turingfold list CASE names them), or make another body."
        )
    if isinstance(part, tuple):
        if not name.isdecimal() or int(name) >= len(part):
            raise ValueError(f"{parameter}: {name!r} is none of the numbers from 0 to {len(part) - 1}.")
        return part[int(name)]
    if not is_dataclass(part) or name not in _own(part):
        raise ValueError(f"{parameter}: {type(part).__name__} has no {name!r}; it has: {_names(part)}.")
    return getattr(part, name)


def _types(part: Any) -> dict[str, Any]:
    return {field.name: field.type for field in fields(part)}


def _own(part: Any) -> Iterable[str]:
    return [field.name for field in fields(part) if field.init] if is_dataclass(part) else []


def _names(part: Any) -> str:
    return ", ".join(_own(part)) or "no values"
