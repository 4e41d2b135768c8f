"""Outlines that a body is to grow into."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import finite_array, positive
from ..geometry.body import Body
from ..morphometry.walls import self_intersections
from ..results.surface import along_pial, mirror_line, outer_ends, pial_closed
from ..scene import Scene

FAR = 5.0  # a target this many times as large as the body, or as small, is in other units
FEWEST = 8  # points of a target
EVEN = 0.5  # the lesser of a target's two halves is at least this share of the other as wide


def checked_targets(scene: Scene, targets: Mapping[float, Any]) -> dict[float, Array]:
    """Return the targets in order of age; raises ValueError for what cannot be one."""
    if not isinstance(targets, Mapping):
        raise ValueError(
            f"targets is {type(targets).__name__}; give outlines by age, such as {{1.0: points}}."
        )
    if not targets:
        raise ValueError("targets is empty; give an outline by age, such as {1.0: points}.")
    body, found = scene.body, {}
    if len(body.pial_paths) > 1:
        raise ValueError(
            f"the body's pial surface has {len(body.pial_paths)} parts; a fit compares one outline with one, "
            "so give a body of one part."
        )
    for age, points in sorted(targets.items()):
        positive("age", age, at_most=scene.until, remedy="ages are times of the scene")
        curve = finite_array(f"targets[{age:g}]", points, (2, None))
        if pial_closed(body) and np.array_equal(curve[:, 0], curve[:, -1]):
            curve = curve[:, :-1]
        if curve.shape[1] < FEWEST:
            raise ValueError(f"targets[{age:g}] has {curve.shape[1]} points; at least {FEWEST} are needed.")
        extent = float(np.ptp(curve, axis=1).max())
        ratio = extent / (2 * body.length)
        if not 1 / FAR < ratio < FAR:
            raise ValueError(
                f"targets[{age:g}] is {extent:.3g} m wide, the body {2 * body.length:.3g} m: are both in m?"
            )
        try:
            crossings = self_intersections(curve, closed=pial_closed(body))
        except ValueError as error:
            raise ValueError(f"targets[{age:g}]: {error}") from None
        if crossings:
            raise ValueError(f"targets[{age:g}] crosses itself {crossings} times; repair it, see `outline`.")
        _check_both_halves(body, f"targets[{age:g}]", curve)
        _check_ends(body, f"targets[{age:g}]", curve)
        found[float(age)] = curve
    return found


def _check_both_halves(body: Body, name: str, curve: Array) -> None:
    """Raise ValueError for an outline that lies mostly on one side of the body's mirror."""
    if not body.mirror:
        return
    x = curve[0] - mirror_line(body)
    if min(-x.min(), x.max()) < EVEN * max(-x.min(), x.max()):
        raise ValueError(
            f"{name} reaches from x = {curve[0].min():.3g} to {curve[0].max():.3g} m, and the body's mirror "
            f"is at {mirror_line(body):.3g} m; give the whole outline, with the half beyond the mirror."
        )


def _check_ends(body: Body, name: str, curve: Array) -> None:
    """Raise ValueError for an open outline whose ends are where those of the pial surface cannot come."""
    if pial_closed(body):
        return
    rest, ends = along_pial(body, body.nodes[:, body.pial])[:, [0, -1]], curve[:, [0, -1]]
    outer = outer_ends(body)
    fixed = np.asarray(np.isin([2 * outer, 2 * outer + 1], body.supported).all(axis=1))
    off = min(float(np.hypot(*(fixed[:, None] * (ends[:, way] - rest))).max()) for way in ([0, 1], [1, 0]))
    if off > body.thickness:
        raise ValueError(
            f"an end of {name} is {off:.3g} m from where the pial surface ends, which its base does not let "
            f"it go; give the outline from {rest[:, 0].round(4)} to {rest[:, 1].round(4)} m or near."
        )
