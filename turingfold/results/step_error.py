"""How far numbers of a state are off by its steps: what steps twice as long change of them.

A state at rest whose fields are functions of time alone is an equilibrium, whatever the steps that led there:
they choose no more than the branch. Motions, and fields that remember, depend on every step: the march is
taken again with every second of its times, to J' in place of a number J. With steps r times as long and a
method of order p, J is off by (J' - J)/(rᵖ - 1) (Richardson). That takes up to half the time of the march.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..errors import SolveError
from ..scene import Scene
from ..solve.march import begin, march
from ..solve.problem import Problem
from ..stability.path_dependence import remembers
from ..state import State
from ..stepping import MIDPOINT
from .carried import NoEstimateError
from .estimate import ENERGY, LENGTH, Numbers
from .measures import shape_numbers

FEWEST = 4  # steps that are enough for half of them to mean anything
LEAST = 1.25  # times as many steps in a march as in the one with longer ones
NAMES = (ENERGY, LENGTH, "gyrification_index", "sulcal_depth")


def steps_matter(scene: Scene) -> bool:
    """Return whether a scene has terms that resist motion or processes that remember."""
    return any(term.resists_motion for term in scene.terms) or _remembers(scene)


def step_errors(scene: Scene, times: Sequence[float], state: State, energy: float) -> Numbers:
    """Return by how much the steps that ended at `times` leave the numbers of the last state, at rest 0.

    The names are those of `estimated`; energy: of the state, J/m.
    Raises NoEstimateError for fewer than four steps, and where longer ones do not lead to the end.
    """
    if not steps_matter(scene):
        return dict.fromkeys(NAMES, 0.0)
    if len(times) < FEWEST:
        raise NoEstimateError(f"{len(times)} step(s) are too few to tell the errors of steps")
    coarse = list(times[::-1][::2][::-1])
    try:
        longer, numbers, count = _marched(scene, coarse)
    except SolveError as error:
        raise NoEstimateError(f"steps twice as long do not lead to the end: {error}") from error
    ratio = len(times) / count
    if ratio < LEAST:
        raise NoEstimateError("steps twice as long do not lead to the end in fewer")
    share = 1 / (ratio ** _order(scene) - 1)
    body = scene.body
    found = shape_numbers(body, state["displacement"]) | {ENERGY: energy}
    other = shape_numbers(body, longer["displacement"]) | {ENERGY: numbers["energy"]}
    return {name: share * abs(other[name] - found[name]) for name in NAMES}


def _remembers(scene: Scene) -> bool:
    return any(remembers(process, scene) for process in scene.processes)


def _order(scene: Scene) -> int:
    """Return the order of the steps: the midpoint rule has 2, processes that remember have 1."""
    return 2 if scene.stepping.scheme == MIDPOINT and not _remembers(scene) else 1


def _marched(scene: Scene, times: Sequence[float]) -> tuple[State, dict[str, float], int]:
    """Return the state at the last of some times, its numbers, and how many steps led there."""
    stepping = replace(scene.stepping, first=1.0, largest=1.0, stops=tuple(times), local_error=None)
    scene = replace(scene, stepping=stepping)
    problem = Problem(scene)
    for count, (step, _) in enumerate(march(scene, begin(scene, problem), problem), start=1):
        if step.state.time >= times[-1] * (1 - 1e-12):
            return step.state, step.numbers, count
    raise AssertionError("a march ends at its stops")
