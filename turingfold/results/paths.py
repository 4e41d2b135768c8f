"""Paths of equilibria as arrays by name, and back: what a case stores of one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import Array
from ..stability.arc_length import EquilibriumPath, PathPoint
from ..state import State

NUMBERS = ("time", "arc", "rate", "growth", "energy", "residual", "negative_pivots")


def path_arrays(path: EquilibriumPath) -> dict[str, Array]:
    """Return numbers of the points, (n,) each, and the fields of their states as "field.name", (n, ...)."""
    names = path.points[0].state.fields if path.points else ()
    fields = {f"field.{name}": np.stack([point.state[name] for point in path.points]) for name in names}
    return {name: path.of(name) for name in NUMBERS} | fields


def path_of_arrays(arrays: Mapping[str, Array]) -> EquilibriumPath:
    """Return the path that `path_arrays` was given; other arrays are left alone."""
    fields = {name.removeprefix("field."): arrays[name] for name in arrays if name.startswith("field.")}
    times, *numbers = (arrays[name].tolist() for name in NUMBERS)
    points = []
    for k, time in enumerate(times):
        state = State(time, {name: values[k] for name, values in fields.items()})
        own = dict(zip(NUMBERS[1:], (values[k] for values in numbers), strict=True))
        own["negative_pivots"] = int(own["negative_pivots"])
        points.append(PathPoint(state=state, **own))
    return EquilibriumPath(tuple(points))
