"""Parameters of a scene's parts: which have sensitivities, their values, and the scene with other values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..parts import Load
from ..scene import Scene
from ..studies.sweep import value_of, with_value

THICKNESS = "Body.thickness"
STEP = 1e-3  # change of a parameter in differences, relative to it
CENTRAL = (-1.0, -0.5, 0.0, 0.5, 1.0)  # where it is put, in such steps
FORWARD = (0.0, 0.5, 1.0, 1.5, 2.0)  # the same at a limit of its part
FEW = 4  # parameters that are named in a line


def counted(parameters: Sequence[str]) -> str:
    """Return parameters by name, many of them by number."""
    return ", ".join(parameters) if len(parameters) <= FEW else f"{len(parameters)} parameters"


def number_of(scene: Scene, parameter: str) -> float:
    """Return the value of a parameter that is a number; raises ValueError for any other."""
    if parameter == THICKNESS:
        return _thickness(scene)
    part = parameter.partition(".")[0]
    if part in ("Scene", "Stepping"):
        raise ValueError(f"{parameter} is no parameter of a part; give one such as TangentialGrowth.cortex.")
    if "." not in parameter:
        near = ", ".join(name for name in numbers_of(scene) if name.endswith(f".{parameter}"))
        raise ValueError(
            f"{parameter} is no number of a part; give one such as {near or 'TangentialGrowth.cortex'}. "
            "(--set has the parameters of a case.)"
        )
    value = value_of(scene, parameter)
    if isinstance(value, bool) or not isinstance(value, float):
        raise ValueError(
            f"{parameter} is {value!r}: only what changes without jumps, a number with a decimal point, has "
            "a sensitivity."
        )
    return value


def values_in(scene: Scene, parameters: Sequence[str]) -> Array:
    """Return the values of parameters, (p,); raises ValueError for what is no list of their names."""
    if isinstance(parameters, str) or not all(isinstance(name, str) for name in parameters):
        raise ValueError(f'to={parameters!r}: give a list of names, such as ["Elastic.gray.mu"].')
    return np.array([number_of(scene, name) for name in parameters], dtype=float)


def changed_in(scene: Scene, parameter: str, value: float) -> Scene:
    """Return the scene with another value of a parameter, and the same mesh.

    Raises ValueError where a part refuses the value.
    """
    if parameter == THICKNESS:
        return replace(scene, body=replace(scene.body, thickness=value))
    return with_value(scene, parameter, value)


def _thickness(scene: Scene) -> float:
    """Return the cortical thickness, which layers that pass smoothly into each other may change on a mesh.

    Raises ValueError where the mesh has the interface, or a part acts on it.
    """
    body = scene.body
    bound = [type(part).__name__ for part in scene.processes if "pattern" in part.writes]
    bound += [type(part).__name__ for part in scene.terms if isinstance(part, Load)]
    # a solvent may come from the interface
    bound += [type(part).__name__ for part in scene.processes if getattr(part, "source", "") == "interface"]
    if body.layers != "sigmoid" or body.depth_by != "thickness":
        raise ValueError(
            f"{THICKNESS}: the gray-white interface is one of the mesh, which stays; make the body with "
            'layers="sigmoid" and no interface= of its own, or run it with other thicknesses.'
        )
    if bound:
        raise ValueError(
            f"{THICKNESS}: {bound[0]} acts on the cortex that the mesh has, which stays; run the scene with "
            "other thicknesses."
        )
    return body.thickness


def numbers_of(scene: Scene) -> tuple[str, ...]:
    """Return the parameters of the scene's parts, "Part.name", that can have a sensitivity.

    Every number with a decimal point but 0, of parts that are there once, which may be a little larger or
    smaller.
    """
    parts = [*scene.terms, *scene.processes]
    kinds = [type(part).__name__ for part in parts]
    names = [
        name
        for part, kind in zip(parts, kinds, strict=True)
        if kinds.count(kind) == 1
        for name in _numbers(kind, part)
    ]
    return tuple(name for name in [*names, THICKNESS] if _may_change(scene, name))


def _numbers(name: str, value: Any) -> Iterator[str]:
    if isinstance(value, float):
        if value and np.isfinite(value):
            yield name
    elif isinstance(value, tuple):
        for number, item in enumerate(value):
            yield from _numbers(f"{name}.{number}", item)
    elif is_dataclass(value):
        for field in fields(value):
            if field.init:
                yield from _numbers(f"{name}.{field.name}", getattr(value, field.name))


def _may_change(scene: Scene, parameter: str) -> bool:
    try:
        value = number_of(scene, parameter)
    except ValueError:
        return False
    down = tuple(-place for place in FORWARD)
    return any(
        _takes(scene, parameter, [value * (1 + place * STEP) for place in way])
        for way in (CENTRAL, FORWARD, down)
    )


def _takes(scene: Scene, parameter: str, values: Sequence[float]) -> bool:
    """Return whether the scene takes all values of a parameter."""
    try:
        for value in values:
            changed_in(scene, parameter, value)
    except ValueError:
        return False
    return True
