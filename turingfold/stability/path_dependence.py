"""Parts that remember: what they do at a time depends on the steps by which it was reached."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..parts import Process, Term
from ..scene import Scene
from ..solve.march import processed
from ..state import State

SAME = 1e-6  # relative difference of fields that counts as none


def at_rest(scene: Scene) -> Scene:
    """Return the scene without the terms that resist motion, such as inertia and drag."""
    kept = tuple(term for term in scene.terms if not resists_motion(term))
    return scene if len(kept) == len(scene.terms) else replace(scene, terms=kept)


def resists_motion(part: Process | Term) -> bool:
    """Return whether a part reads the last equilibrium."""
    return "displacement" in part.reads


def refuse_motion(scene: Scene) -> None:
    """Raise ValueError for a part that reads the last equilibrium; nothing is computed."""
    for term in scene.terms:
        if resists_motion(term):
            raise ValueError(
                f"terms holds {term!r}, which reads the displacement before a step: it resists motion, and a "
                "path of equilibria has none. Leave it out."
            )
    for process in scene.processes:
        if resists_motion(process):
            raise _remembers(process)


def refuse_memory(scene: Scene, start: State) -> None:
    """Raise ValueError for a process whose fields are more than functions of time.

    start: the scene's first state, from which the processes must come to the same fields in one step as in
    two; so they must from there on to the scene's end. A law that remembers for less than a sixth of the
    scene's time may pass.
    """
    changed = _changed_by_stepping(scene, start)
    for process in scene.processes:
        if changed.intersection(process.writes):
            raise _remembers(process)


def _remembers(process: Process) -> ValueError:
    return ValueError(
        f"processes holds {process!r}, whose fields depend on the steps taken and not on the time alone; "
        "leave it out, or put in one that gives its fields at any time."
    )


def _changed_by_stepping(scene: Scene, state: State) -> set[str]:
    """Return the fields that two steps of the processes change otherwise than one over the same time."""
    changed: set[str] = set()
    for end in (2 / 3 * scene.until, scene.until):
        at_once = _advanced(scene, state, end)
        state = _advanced(scene, _advanced(scene, state, 0.5 * (state.time + end)), end)
        for name, values in state.fields.items():
            if name not in at_once or not _same(values, at_once[name]):
                changed.add(name)
    return changed


def _advanced(scene: Scene, state: State, time: float) -> State:
    return state.updated(time, **processed(scene, state, time - state.time))


def _same(one: Array, other: Array) -> bool:
    difference = float(np.linalg.norm(one - other))
    return difference <= SAME * float(np.linalg.norm(one) + np.linalg.norm(other))
