"""Parts that remember: what they do at a time depends on the steps by which it was reached."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..parts import Process
from ..scene import Scene
from ..solve.problem import Problem
from ..state import State
from ..stepping import EULER

SAME = 1e-6  # relative difference of fields that counts as none


def at_rest(scene: Scene) -> Scene:
    """Return the scene without the terms that resist motion, such as inertia and drag."""
    kept = tuple(term for term in scene.terms if not term.resists_motion)
    stepping = replace(scene.stepping, scheme=EULER)
    return scene if len(kept) == len(scene.terms) else replace(scene, terms=kept, stepping=stepping)


def refuse_motion(scene: Scene) -> None:
    """Raise ValueError for a term that resists motion; nothing is computed."""
    for term in scene.terms:
        if term.resists_motion:
            raise ValueError(
                f"terms holds {term!r}, which resists motion; a path of equilibria has none. Leave it out."
            )
    for process in scene.processes:
        if remembers(process, scene):
            raise _remembers(process)


def remembers(process: Process, scene: Scene) -> bool:
    """Return whether a process of a scene says that it remembers, or reads what belongs to equilibria."""
    of_equilibria = {"displacement", *(name for term in scene.terms for name in term.writes)}
    return process.remembers or bool(of_equilibria.intersection((*process.reads, *process.optional)))


def refuse_memory(problem: Problem, start: State) -> None:
    """Raise ValueError for a process whose fields are more than functions of time.

    start: the scene's first state, from which the processes that do not say so themselves must come to the
    same fields in one step as in two; so they must from there on to the scene's end.
    """
    changed = _changed_by_stepping(problem, start)
    for process in problem.scene.processes:
        if changed.intersection(process.writes):
            raise _remembers(process)


def _remembers(process: Process) -> ValueError:
    return ValueError(
        f"processes holds {process!r}, whose fields depend on the steps taken and not on the time alone; "
        "leave it out, or put in one that gives its fields at any time."
    )


def _changed_by_stepping(problem: Problem, state: State) -> set[str]:
    """Return the fields that two steps of the processes change otherwise than one over the same time."""
    changed: set[str] = set()
    until = problem.scene.until
    for end in (2 / 3 * until, until):
        at_once = problem.processed(state, end - state.time)
        state = problem.processed(state, 0.5 * (end - state.time))
        state = problem.processed(state, end - state.time)
        for name, values in state.fields.items():
            if name not in at_once or not _same(values, at_once[name]):
                changed.add(name)
    return changed


def _same(one: Array, other: Array) -> bool:
    difference = float(np.linalg.norm(one - other))
    return difference <= SAME * float(np.linalg.norm(one) + np.linalg.norm(other))
