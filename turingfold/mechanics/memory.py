"""Parts that remember: what they do at a time depends on the steps by which it was reached."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..scene import Process, Scene, State, Term
from .march import processed

SAME = 1e-6  # relative difference of fields that counts as none


def at_rest(scene: Scene) -> Scene:
    """Return the scene without the terms that resist motion, such as inertia and drag."""
    kept = tuple(term for term in scene.terms if not resists_motion(term))
    return scene if len(kept) == len(scene.terms) else replace(scene, terms=kept)


def refuse_memory(scene: Scene, start: State) -> None:
    """Raise ValueError for a part that remembers: the scene's equilibria are more than functions of time.

    start: the scene's first state, from which the processes must come to the same fields in one step as in
    two.
    """
    for term in scene.terms:
        if resists_motion(term):
            raise ValueError(
                f"terms holds {term!r}, which reads the displacement before a step: it resists motion, and a "
                "path of equilibria has none. Leave it out."
            )
    looking = [process for process in scene.processes if resists_motion(process)]
    changed = () if looking else _changed_by_stepping(scene, start)
    for process in scene.processes:
        if process in looking or any(name in changed for name in process.writes):
            raise ValueError(
                f"processes holds {process!r}, whose fields depend on the steps taken and not on the time "
                "alone; leave it out, or put in one that gives its fields at any time."
            )


def resists_motion(part: Process | Term) -> bool:
    """Return whether a part reads the last equilibrium."""
    return "displacement" in part.reads


def _changed_by_stepping(scene: Scene, start: State) -> tuple[str, ...]:
    """Return the fields that two steps of the processes change otherwise than one over the same time."""
    dt = scene.until / 3
    half_way = start.updated(start.time + dt, **processed(scene, start, dt))
    stepped, at_once = processed(scene, half_way, dt), processed(scene, start, 2 * dt)
    last = {**half_way.fields, **stepped}
    return tuple(name for name, values in at_once.items() if not _same(last[name], values))


def _same(one: Array, other: Array) -> bool:
    difference = float(np.linalg.norm(one - other))
    return difference <= SAME * float(np.linalg.norm(one) + np.linalg.norm(other))
