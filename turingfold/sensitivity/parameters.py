"""How forces and energy change with a parameter of a part while the body stays where it is.

The part is made anew with the parameter a little larger and smaller, and with it the processes that its
change reaches; everything else is kept. Differences over h and h/2 are extrapolated, so that errors are of
order h⁴, and how far the two lie apart says how large they are. At a limit of its part, as a Poisson's ratio
of 0, the parameter goes the other way only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..parts import Load, Operator, Process, TimeStep
from ..scene import Scene, stress_scale
from ..solve.problem import Problem
from ..state import State
from ..studies.sweep import value_of, with_value

THICKNESS = "Body.thickness"
STEP = 1e-3  # change of a parameter, relative to it; of one that is 0, in its own unit
ROUNDED = 1e-6  # an error of ∂g/∂p beyond which a parameter may be too near 0 for a relative change
TINY = 1e-9  # a parameter of which it is
ROUND_OFF = 1e-13  # share of its part's forces below which a change of them is none
# differences of fourth order, and coarser ones that say how large their errors are: places in h, weights
CENTRAL = ((-1.0, -0.5, 0.5, 1.0), (1 / 6, -4 / 3, 4 / 3, -1 / 6), (0.0, -1.0, 1.0, 0.0))
FORWARD = ((0.0, 0.5, 1.0, 1.5, 2.0), (-25 / 6, 8.0, -6.0, 8 / 3, -0.5), (-11 / 3, 6.0, -3.0, 2 / 3, 0.0))


@dataclass(frozen=True, eq=False)
class Change:
    """∂g/∂p, (2 n_nodes,), and ∂E/∂p at a fixed displacement.  error: of ∂g/∂p, relative."""

    gradient: Array
    energy: float
    error: float


def change(problem: Problem, state: State, x: Array, parameter: str, step: TimeStep) -> Change:
    """Return how forces and energy at x change with a parameter, "Part.name".

    state: the fields at x; those that the parameter changes are made anew.
    Raises ValueError for what is no number of a part.
    """
    value = number_of(problem.scene, parameter)
    found = _change_by(problem, state, x, parameter, step, value, STEP * abs(value) if value else STEP)
    if value and (abs(value) < TINY or found.error > ROUNDED):
        try:
            other = _change_by(problem, state, x, parameter, step, value, STEP)
        except ValueError:  # its part refuses so large a change
            return found
        if other.gradient.any() and (other.error < found.error or not found.gradient.any()):
            return other
    return found


def _change_by(
    problem: Problem, state: State, x: Array, parameter: str, step: TimeStep, value: float, h: float
) -> Change:
    """Return how forces and energy change, by differences over h; where a part refuses them, to one side.

    Raises ValueError where it refuses both.
    """
    try:
        return _differences(problem, state, x, parameter, step, value, h, CENTRAL)
    except ValueError as error:
        for one_way in (h, -h):
            try:
                return _differences(problem, state, x, parameter, step, value, one_way, FORWARD)
            except ValueError:
                continue
        raise ValueError(
            f"{parameter} is {value!r}, and its part takes no values up to {2 * h:.3g} below or above it; "
            f"a derivative needs them: {error}"
        ) from error


def _differences(
    problem: Problem, state: State, x: Array, parameter: str, step: TimeStep, value: float, h: float,
    rule: tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]],
) -> Change:  # fmt: skip
    """Return how forces and energy change, by a rule for differences over h."""
    places, fine, coarse = rule
    forces = np.stack(
        [
            _forces(problem, changed_in(problem.scene, parameter, value + place * h), state, x, step)
            for place in places
        ]
    )
    found, rough = (np.array(weights) @ forces / h for weights in (fine, coarse))
    size = float(np.linalg.norm(found[:-1]))
    if size * abs(h) <= ROUND_OFF * float(np.linalg.norm(forces[:, :-1], axis=1).max()):
        return Change(np.zeros_like(found[:-1]), float(found[-1]), 0.0)
    error = float(np.linalg.norm((found - rough)[:-1])) / size if size > 0 else 0.0
    return Change(found[:-1], float(found[-1]), error)


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
    either, up = CENTRAL[0], FORWARD[0]
    down = tuple(-place for place in up)
    return any(
        _takes(scene, parameter, [value * (1 + place * STEP) for place in way]) for way in (either, up, down)
    )


def _takes(scene: Scene, parameter: str, values: Sequence[float]) -> bool:
    """Return whether the scene takes all values of a parameter."""
    try:
        for value in values:
            changed_in(scene, parameter, value)
    except ValueError:
        return False
    return True


def _forces(problem: Problem, changed: Scene, state: State, x: Array, step: TimeStep) -> Array:
    """Return the forces and the energy of the parts that a change reaches, (2 n_nodes + 1,)."""
    scene = problem.scene
    fields = fields_of(scene, changed, state)
    now = state.updated(**fields)
    total = np.zeros(len(x) + 1)
    operators = operators_of(problem, changed)
    for old, operator, own in zip(scene.terms, operators, problem.operators, strict=True):
        if operator is own and not {*old.reads, *old.optional} & set(fields):
            continue
        potential = operator.during(now, step)
        at = None if potential is None else potential.evaluate(x)
        if at is not None:
            total[:-1] += at.gradient()[0]
            total[-1] += at.energy
    return total


def operators_of(problem: Problem, changed: Scene) -> list[Operator]:
    """Return the operators of a changed scene's terms; those of terms that did not change are kept."""
    same = changed.body is problem.scene.body
    return [
        own if same and new is old else new.on(changed.body)
        for old, new, own in zip(problem.scene.terms, changed.terms, problem.operators, strict=True)
    ]


def fields_of(scene: Scene, changed: Scene, state: State) -> dict[str, Array]:
    """Return the fields that are otherwise in the changed scene at the state's time."""
    fields, scale = _processed(scene, changed, state), stress_scale(changed.terms)
    if scale != stress_scale(scene.terms):  # the unit of stress is that of the stiffest layer
        fields["stress_scale"] = np.array(scale)
    return fields


def _processed(scene: Scene, changed: Scene, state: State) -> dict[str, Array]:
    """Return the fields that the processes of the changed scene make otherwise."""
    reached: list[Process] = []
    names: set[str] = set()
    for old, new in zip(scene.processes, changed.processes, strict=True):
        other = new is not old or changed.body is not scene.body
        if other or names & {*new.reads, *new.optional, *new.writes}:
            reached.append(new)
            names |= set(new.writes)
    if not reached:
        return {}
    # laws that multiply or rewrite one field are needed from the first one on
    reached = [p for p in changed.processes if names & set(p.writes)]
    made = {name for process in reached for name in process.writes}
    kept = {name: state[name] for name in state.fields if name not in made}
    evolutions = [(process, process.on(changed.body)) for process in reached]
    before, now = State(0.0, kept), State(state.time, kept)
    for _, evolution in evolutions:
        before = before.updated(**evolution.start(before, scene.seed))
    for process, evolution in evolutions:
        own = {name: before[name] for name in process.writes if name in before and name not in now}
        now = now.updated(**{**own, **evolution.advance(before, now, state.time)})
    return {name: now[name] for name in made}


def check_path(problem: Problem, start: State) -> None:
    """Raise ValueError for parts whose fields depend on the steps taken, by name."""
    from ..stability.path_dependence import refuse_memory, refuse_motion

    refuse_motion(problem.scene)
    refuse_memory(problem, start)
