"""What comes of a scene: states, history, and the numbers that sum them up."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..checks import whole
from ..growth.measure import largest_growth
from ..solve.march import acting, discretised
from ..scene import Scene, stress_scale
from ..parts import Operator
from ..state import State
from ..geometry.triangles import folded_over

Row = dict[str, float]
FilePath = str | os.PathLike[str]

NAN = float("nan")
BRAIN = 0.5  # m; a body longer than this is no brain in metres, but one in units of its own
TISSUE = 10.0  # Pa; no tissue is softer, so smaller moduli are not in Pa, but in units of their own


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """What a scene became.

    states: every accepted state, the start first; of a result read from disk, those that were kept.
    history: a row per accepted step, by column name; NaN where something does not exist.
    converged: whether the end of the scene was reached.  seconds, seconds_by_part: time spent.
    """

    scene: Scene
    states: tuple[State, ...]
    history: tuple[Row, ...]
    converged: bool
    seconds: float = NAN
    seconds_by_part: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return it in a line; the arrays would fill pages."""
        growth, end = largest_growth(self.last), "reached the end" if self.converged else "stopped early"
        return f"Result({end} at t = {self.last.time:.4g}, growth {growth:.3g}, {len(self.history)} steps)"

    @property
    def last(self) -> State:
        """The last accepted state."""
        return self.states[-1]

    def pial(self, step: int = -1) -> Array:
        """Return a state's deformed pial surface, (2, n), counter-clockwise; a half body's is completed.

        Raises ValueError for a step that is none of the states'.
        """
        body = self.scene.body
        return along_pial(body, (body.nodes + self._state(step)["displacement"])[:, body.pial])

    def _state(self, step: int) -> State:
        count = len(self.states)
        known = f"the result has {count} states, 0 to {count - 1} or, from the last one, -1 to -{count}"
        if whole("step", step, at_least=-count, remedy=known) >= count:
            raise ValueError(f"step={step} must be at most {count - 1}; {known}.")
        return self.states[step]

    def pattern(self, step: int = -1) -> Array | None:
        """Return the pattern û at the points of `pial`, (n,), or None without a pattern; raises as `pial`."""
        body, state = self.scene.body, self._state(step)
        if "pattern" not in state:
            return None
        everywhere = body.spread(body.cortex, state["pattern"], outside=0.0)
        return along_pial(body, everywhere[body.pial])

    def observe(self, step: int = -1) -> dict[str, Array]:
        """Return von_mises and pressure (Pa), jacobian and what else the terms show, each (q, e).

        Raises ValueError for a step that is none of the states'.
        """
        scene, state = self.scene, self._state(step)
        times = [row["time"] for row in self.history]
        row = times.index(state.time) if state.time in times else 0
        return observe(self._operators, state, self.history[row]["step"] if self.history else scene.until)

    @cached_property
    def _operators(self) -> list[Operator]:
        """The terms on the body: costly to make, the same at every step."""
        return discretised(self.scene)[0]

    def summary(self) -> dict[str, Any]:
        """Return the numbers at the last state: effort, growth, energy, folds; None where one does not exist.

        min_jacobian, min_gap (m): smallest of the whole run, at integration points and between the straight
        edges that join neighbouring nodes.  inverted_elements: triangles turned over at a corner or an edge
        middle, which only the forces around them prevent.  sulcal_depth, mirror_error: m, the latter None
        for a body that is not its own mirror image.  seconds_by_part: s.
        """
        body, rows = self.scene.body, self.history
        last = rows[-1] if rows else {}
        return {
            "dofs": body.nodes.size - len(body.fixed),
            "triangles": body.mesh.nelements,
            "elements_through_cortex": round(body.elements_through_cortex, 2),
            "steps": len(rows),
            "newton_iterations": int(sum(row["newton_iterations"] for row in rows)),
            "factorizations": int(sum(row["factorizations"] for row in rows)),
            "seconds": self.seconds,
            "seconds_by_part": dict(self.seconds_by_part),
            "growth": largest_growth(self.last),
            "energy": _number(last.get("energy", NAN)),
            "residual": _number(last.get("residual", NAN)),
            "min_jacobian": _smallest(rows, "min_jacobian"),
            "min_gap": _smallest(rows, "min_gap"),
            "inverted_elements": len(folded_over(body.mesh, body.nodes + self.last["displacement"])),
            **self._shape(),
            "converged": self.converged,
        }

    def _shape(self) -> dict[str, float | None]:
        from ..morphometry.folds import fold_count, sulcal_depth
        from ..morphometry.registration import registration
        from ..morphometry.shape import gyrification_index
        from ..morphometry.walls import mirror_error, self_intersections

        body, pial, pattern = self.scene.body, self.pial(), self.pattern()
        rest = along_pial(body, body.nodes[:, body.pial])
        closed = pial_closed(body)
        symmetric = mirror_error(rest) <= 1e-9 * body.length
        return {
            "self_intersections": self_intersections(pial, closed=closed),
            "gyrification_index": gyrification_index(pial, closed=closed),
            "folds": fold_count(pial, closed=closed),
            "sulcal_depth": sulcal_depth(pial, closed=closed),
            "mirror_error": mirror_error(pial) if symmetric else None,
            "registration": None if pattern is None else registration(pattern, pial, rest, closed=closed),
        }


def load(folder: FilePath, *, known: Iterable[Any] = ()) -> Result:
    """Return the result stored in a folder; its states are those that were kept.

    known: classes and functions from outside turingfold that the scene is made of.
    Raises ValueError if the folder holds no result or one whose scene cannot be rebuilt.
    """
    from .document import read_scene
    from .files import read_json
    from .folder import read_states
    from .history import read_history

    path = Path(folder)
    scene = read_scene(path, known)
    states, history = read_states(path), read_history(path)
    if not states:
        raise ValueError(f"{path} holds no state yet; run the scene first, or go on with resume=True.")
    file = path / "summary.json"
    summary = read_json(file) if file.exists() else {}
    seconds = summary.get("seconds", float(sum(row["seconds"] for row in history)))
    parts, converged = summary.get("seconds_by_part", {}), bool(summary.get("converged", False))
    return Result(scene, tuple(states), tuple(history), converged, seconds, parts)


def observe(operators: Sequence[Operator], state: State, dt: float) -> dict[str, Array]:
    """Return the fields that terms on a body show of a state, each (q, e); dt is the step that led to it."""
    x = state["displacement"].T.ravel()
    fields: dict[str, Array] = {}
    for potential in acting(operators, state, dt):
        fields |= potential.observe(x)
    return fields


def length_unit(body: Body) -> tuple[float, str]:
    """Return the unit that lengths of a body are shown in, and its name.

    That is 1e-3 m, "mm"; for a body in units of its own, longer than 0.5, the cortical thickness, "T".
    """
    return (body.thickness, "T") if body.length > BRAIN else (1e-3, "mm")


def stress_unit(scene: Scene) -> tuple[float, str]:
    """Return the unit that stresses of a scene are shown in, and its name.

    That is 1e3 Pa, "kPa"; for moduli that are no tissue's in Pa, the largest below 10, 1 without a name.
    """
    return (1e3, "kPa") if stress_scale(scene.terms) >= TISSUE else (1.0, "")


def along_pial(body: Body, values: Array) -> Array:
    """Return values (n,) or points (2, n) along the pial surface; a half body's with their mirror image."""
    if not body.mirror:
        return values
    line, first, last = _mirror(body)
    image = values[..., ::-1].copy()
    if values.ndim == 2:
        image[0] = 2 * line - image[0]
    # a point on the mirror is its own image
    if last:
        return np.concatenate([values, image[..., 1 : image.shape[-1] - first]], axis=-1)
    return np.concatenate([image[..., : image.shape[-1] - first], values], axis=-1)


def pial_closed(body: Body) -> bool:
    """Return whether the pial surface, completed by its image, is closed."""
    return all(_mirror(body)[1:]) if body.mirror else body.pial_curve.closed


def _mirror(body: Body) -> tuple[float, bool, bool]:
    """Return x of the mirror, and whether the pial surface starts and ends on it."""
    line = float(body.nodes[0, body.boundary_path("mirror")[0][0]])
    first, last = np.abs(body.nodes[0, body.pial[[0, -1]]] - line) <= 1e-9 * body.length
    return line, bool(first), bool(last)


def _smallest(rows: Sequence[Row], name: str) -> float | None:
    values = [row[name] for row in rows if np.isfinite(row.get(name, NAN))]
    return min(values) if values else None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
