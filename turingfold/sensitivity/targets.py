"""Outlines that a body is to grow into."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import finite_array, positive
from ..morphometry.walls import self_intersections
from ..results.surface import pial_closed
from ..scene import Scene

FAR = 5.0  # a target this many times as large as the body, or as small, is in other units


def checked_targets(scene: Scene, targets: Mapping[float, Any]) -> dict[float, Array]:
    """Return the targets in order of age; raises ValueError for what cannot be one."""
    if not targets:
        raise ValueError("targets is empty; give an outline by age, such as {1.0: points}.")
    body, found = scene.body, {}
    for age, points in sorted(targets.items()):
        positive("age", age, at_most=scene.until, remedy="ages are times of the scene")
        curve = finite_array(f"targets[{age:g}]", points, (2, None))
        if pial_closed(body) and np.array_equal(curve[:, 0], curve[:, -1]):
            curve = curve[:, :-1]
        extent = float(np.ptp(curve, axis=1).max())
        ratio = extent / (2 * body.length)
        if not 1 / FAR < ratio < FAR:
            raise ValueError(
                f"targets[{age:g}] is {extent:.3g} m wide, the body {2 * body.length:.3g} m: are both in m?"
            )
        crossings = self_intersections(curve, closed=pial_closed(body))
        if crossings:
            raise ValueError(f"targets[{age:g}] crosses itself {crossings} times; repair it, see `outline`.")
        found[float(age)] = curve
    return found
