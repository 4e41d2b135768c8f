"""What comes of a scene: states, history, and the numbers that sum them up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..checks import finite, one_of, whole
from ..geometry.body import by_node
from ..growth.ages import ages_of
from ..growth.measure import largest_growth
from ..parts import TimeStep
from ..scene import Scene
from ..solve.march import observed
from ..solve.problem import Problem, configuration
from ..state import State
from .measures import area_numbers, fold_numbers, pial_pattern, shape_numbers
from .surface import along_pial as along_pial
from .surface import pial_closed as pial_closed

if TYPE_CHECKING:
    import meshio
    from matplotlib.figure import Figure

Row = dict[str, float]

NAN = float("nan")
STATUSES = ("converged", "stopped", "interrupted", "running", "invalid")


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """What a scene became.

    states: every accepted state, the start first; of a result read from disk, those that were kept.
    history: a row per accepted step, by column name; NaN where something does not exist.
    status: "converged": the end of the scene was reached; "stopped": no further step was possible;
    "interrupted": by Ctrl-C or a kill; "running": still, in another process; "invalid": the end was reached,
    but through at least one state that is none of a body: with `inverted_elements`, or `self_intersections`
    of its boundary, in the history.
    message: what to know about it.
    seconds, seconds_by_part: time spent.
    errors: how far the mesh leaves numbers of the last state off, by their names in the summary; see
    `estimate`; quadrature_errors: the part of its integration points, see `quadrature_error`.  step_errors:
    how far the steps do, see `step_error`; 0 for an equilibrium, which depends on none. Empty where they were
    not asked for, or there are none: no_errors and no_step_errors then say why.
    softness: what share of its stiffness the softest displacement of the last state keeps, see `softness`;
    None where errors were not asked for, and of motions.
    Raises ValueError for another status.
    """

    scene: Scene
    states: tuple[State, ...]
    history: tuple[Row, ...]
    status: str = "converged"
    message: str = ""
    seconds: float = NAN
    seconds_by_part: Mapping[str, float] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    no_errors: str = ""
    step_errors: Mapping[str, float] = field(default_factory=dict)
    no_step_errors: str = ""
    quadrature_errors: Mapping[str, float] = field(default_factory=dict)
    softness: float | None = None

    def __post_init__(self) -> None:
        one_of("status", self.status, STATUSES)

    def __repr__(self) -> str:
        """Return it in a line; the arrays would fill pages."""
        end = self.unfinished or f"reached the end at t = {self.last.time:.4g}"
        return f"Result({end}, growth {largest_growth(self.last):.3g}, {len(self.history)} steps)"

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the folded body, and the numbers that sum it up."""
        from .html import as_html

        end = self.unfinished or f"reached the end, t = {self.last.time:.4g}"
        return as_html(self.scene.body, self.last, self.summary(), end, self.error)

    def plot(self, step: int = -1, *, field: str = "von_mises") -> Figure:
        """Return a figure of a state, coloured by a field; `figures` has functions that draw on given axes.

        field: "von_mises", "pressure" or "jacobian".
        """
        from matplotlib.figure import Figure

        from turingfold import figures  # a picture is no part of a result: as a caller would draw it

        state = self._state(step)
        figure = Figure(figsize=(8, 5), layout="constrained")
        figures.section(axes := figure.add_subplot(), self, step, field=field)
        on_the_way = f"t = {state.time:.4g}, growth {largest_growth(state):.2f}"
        axes.set_title(figures.measures(self) if state is self.last else on_the_way, fontsize=10)
        return figure

    def to_meshio(self, step: int | State = -1) -> meshio.Mesh:
        """Return a state as a meshio mesh of quadratic triangles, undeformed, with all its fields."""
        from .vtu import mesh_of

        return mesh_of(self.scene.body, self._state(step), self.observe(step))

    def to_pyvista(self, step: int | State = -1) -> Any:
        """Return a state as a PyVista grid; `.warp_by_vector("displacement")` deforms it."""
        from .exports import as_pyvista

        return as_pyvista(self.scene.body, self._state(step), self.observe(step))

    def to_xarray(self) -> Any:
        """Return states and history as an xarray Dataset."""
        from .exports import as_xarray

        return as_xarray(self.scene.body, self.states, self.history)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled or copied: not what was only computed from it."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def converged(self) -> bool:
        """Whether the end of the scene was reached, with a valid state."""
        return self.status == "converged"

    @property
    def unfinished(self) -> str:
        """What to say in a title of a result that is not converged; nothing of one that is."""
        if self.converged:
            return ""
        return f"{self.status} at t = {self.last.time:.6g} of {self.scene.until:.6g}"

    def error(self, name: str) -> float | None:
        """Return how far mesh and steps leave a number of the last state off; None where nothing tells it."""
        return self.errors[name] + self.step_errors.get(name, 0.0) if name in self.errors else None

    @property
    def last(self) -> State:
        """The last accepted state."""
        return self.states[-1]

    def pial(self, step: int | State = -1) -> Array:
        """Return a state's deformed pial surface, (2, n), the body on its left; a half body's is completed.

        That is counter-clockwise round a body. Where the body lies outside, as round a ventricle, it is
        clockwise and an `InnerWall`, of which curvature, folds and registration have the right sign.
        Raises ValueError for a step that is none of the states', and for a surface in several parts: for
        those there is `pial_parts`.
        """
        body = self.scene.body
        return along_pial(body, (body.nodes + self._state(step)["displacement"])[:, body.pial])

    def pial_parts(self, step: int = -1) -> list[Array]:
        """Return the parts of a state's deformed pial surface, (2, n) each, in the order of `pial_paths`."""
        body = self.scene.body
        moved = body.nodes + self._state(step)["displacement"]
        return [moved[:, path.nodes] for path in body.pial_paths]

    def at(
        self, time: float | None = None, *, week: float | None = None, day: float | None = None,
        exact: bool | None = None,
    ) -> State:  # fmt: skip
        """Return the state nearest to a time; `pial`, `pattern` and `observe` take it in place of a step.

        time: of the scene; or, of a scene whose history has ages, a gestational week or a postnatal day.
        exact: whether it must be the state of that time itself; weeks and days must, unless it is False.
        Raises ValueError for a time beyond the first and last state's, for an exact one without a state, and
        for ages that the scene does not have.
        """
        given = {"time": time, "week": week, "day": day}
        named = [(unit, value) for unit, value in given.items() if value is not None]
        if len(named) != 1:
            raise ValueError(f"at() takes one of time, week and day, not {len(named)} of them.")
        ((unit, value),) = named
        if unit == "time":
            return self._nearest(value, bool(exact))
        ages = ages_of(self.scene.processes)
        if ages is None or ages.unit != unit:
            has = f"{ages.unit}s" if ages else "none"
            raise ValueError(
                f"{unit}={value}: no process of the scene has ages in {unit}s (it has: {has}); give growth "
                "a history=Weeks(...) or Days(...), or ask for a time."
            )
        time = ages.time(value)
        try:
            return self._nearest(time, exact is not False)
        except ValueError as error:
            raise ValueError(
                f"{unit}={value:g}: {error} A step ends there with Stepping(stops=history.times({value:g}))."
            ) from error

    def label(self, step: int | State = -1) -> str:
        """Return the age of a state in words, such as "week 32"; nothing where the scene has no ages."""
        ages = ages_of(self.scene.processes)
        return ages.label(self._state(step).time) if ages else ""

    def _nearest(self, time: float, exact: bool) -> State:
        times, time = np.array([state.time for state in self.states]), finite("time", time)
        step, tolerance = int(np.argmin(np.abs(times - time))), 1e-9 * self.scene.until
        if not times[0] - tolerance <= time <= times[-1] + tolerance:
            raise ValueError(f"time={time:g} must be from {times[0]:g} to {times[-1]:g}, the last state's.")
        if exact and abs(times[step] - time) > tolerance:
            raise ValueError(
                f"time={time:g} has no state, the nearest is {times[step]:g}. Take that with "
                "exact=False, or keep more states (frames=)."
            )
        return self.states[step]

    def _state(self, step: int | State) -> State:
        if isinstance(step, State):
            return step
        count = len(self.states)
        known = f"the result has {count} states, 0 to {count - 1} or, from the last one, -1 to -{count}"
        if whole("step", step, at_least=-count, remedy=known) >= count:
            raise ValueError(f"step={step} must be at most {count - 1}; {known}.")
        return self.states[step]

    def pattern(self, step: int | State = -1) -> Array | None:
        """Return the pattern û at the points of `pial`, (n,), or None without a pattern; raises as `pial`."""
        return pial_pattern(self.scene.body, self._state(step))

    def observe(self, step: int | State = -1) -> dict[str, Array]:
        """Return fields at the integration points, each (q, e).

        Of a solid: its Cauchy stress, stress_xx, stress_yy, stress_xy and stress_zz, von_mises and pressure
        of that, Pa, and jacobian, det F*.
        Raises ValueError for a step that is none of the states'.
        """
        scene, state = self.scene, self._state(step)
        times = [row["time"] for row in self.history]
        row = times.index(state.time) if state.time in times else 0
        return observe(self._problem, state, self.history[row]["step"] if self.history else scene.until)

    @cached_property
    def _problem(self) -> Problem:
        """The scene on its body: costly to make, the same at every step."""
        return Problem(self.scene)

    @property
    def _dofs(self) -> int:
        """The number of unknowns; inertia or drag may hold a body that has no support."""
        body = self.scene.body
        held = body.fixed if len(body.fixed) == len(body.supported) else self._problem.held
        return body.nodes.size - len(held)

    @cached_property
    def _shape(self) -> dict[str, float | None]:
        """Areas, folds and pial length of the last state."""
        body, length = self.scene.body, shape_numbers(self.scene.body, self.last["displacement"])["perimeter"]
        return {**area_numbers(body, self.last), **fold_numbers(body, self.last), "perimeter": length}

    def summary(self) -> dict[str, Any]:
        """Return the numbers at the last state: effort, growth, energy, folds; None where one does not exist.

        energy: that stored at the last state, of elasticity, loads and walls; J per m of depth. Of half a
        body it is that of the half, as works and energies of the history, dofs and triangles are.
        negative_pivots: directions in which the last state's energy falls; 0 at a minimum; with inertia, drag
        or damping, those of the step's incremental potential.  saddles: states of the whole run that have
        some.  snaps: steps whose equilibrium only the gradient flow found.
        min_jacobian, min_gap (m): smallest of the whole run, at integration points and between walls.
        holding_force: largest of the whole run at nodes that only hold free parts in place, N/m; None of a
        body that is supported.
        area_growth, cortex_growth, core_growth, centre_growth, inverted_elements, sulcal_depth,
        mirror_error: `measures`.
        perimeter: length of the pial surface, m.  errors, no_errors, step_errors, no_step_errors,
        quadrature_errors, softness: as in `Result`; of steps and quadrature None where there are none.
        seconds_by_part: s.
        """
        body, rows = self.scene.body, self.history
        last = rows[-1] if rows else {}
        return {
            "status": self.status,
            "message": self.message,
            "time": self.last.time,
            "dofs": self._dofs,
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
            "negative_pivots": int(last.get("negative_pivots", 0)),
            "saddles": sum(row["negative_pivots"] > 0 for row in rows),
            "snaps": sum(row.get("snapped", 0.0) > 0 for row in rows),
            "damped_steps": sum(row.get("damped", 0.0) > 0 for row in rows),
            "min_jacobian": _smallest(rows, "min_jacobian"),
            "min_gap": _smallest(rows, "min_gap"),
            "holding_force": _largest(rows, "holding_force"),
            **self._shape,
            "errors": dict(self.errors),
            "no_errors": self.no_errors,
            "step_errors": dict(self.step_errors) or None,
            "no_step_errors": self.no_step_errors,
            "quadrature_errors": dict(self.quadrature_errors) or None,
            "softness": self.softness,
            "converged": self.converged,
        }


def observe(problem: Problem, state: State, dt: float) -> dict[str, Array]:
    """Return the fields that terms show of a state, each (q, e); dt is the step that led to it."""
    at = configuration(problem.potentials(state, TimeStep(dt, over=True)), by_node(state["displacement"]))
    return {} if at is None else observed(at)


def _smallest(rows: Sequence[Row], name: str) -> float | None:
    return min(_finite(rows, name), default=None)


def _largest(rows: Sequence[Row], name: str) -> float | None:
    return max(_finite(rows, name), default=None)


def _finite(rows: Sequence[Row], name: str) -> list[float]:
    return [row[name] for row in rows if np.isfinite(row.get(name, NAN))]


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
