"""The least squares problem of a fit: its residuals, their derivatives, and what they say in the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..errors import NotConvergedError, SolveError
from ..geometry.body import by_node
from ..morphometry.distance import Feet, Polygon, sampled
from ..morphometry.pose import posed, without_rigid
from ..parts import TimeStep
from ..results.surface import along_pial, pial_closed
from ..scene import Scene
from ..solve.march import begin, march
from ..solve.newton import Minimiser
from ..solve.problem import Problem, configuration
from ..state import State
from .change import Still, change, check_path
from .fit_setup import keep_best
from .landmarks import Landmarks
from .parameters import changed_in
from .smoothing import second_differences
from .standard_errors import smoothed_away, told
from .tangent import Tangent

SHOWN = 8  # parameters that are named where a fit is printed
KEPT = ("contact_chords",)  # fields of a march in which equilibria are continued


@dataclass(frozen=True, eq=False)
class Fit:
    """Fitted parameters.

    scene: with the values put in.  values, deviations: of the parameters and their standard errors, (p,);
    a deviation is infinite where the outlines do not tell the parameter.
    misfits: root mean square distance per age; m.  distinct: how many combinations of the parameters the
    outlines tell apart.  singular_values: of the scaled Jacobian, (p,).  flat: changes of the parameters of
    unit length that the outlines do not tell, (p - distinct, p).  solves: equilibria that were found.
    smoothness: the weight of second differences.  outlines: the fitted pial surface by age, (2, n); m. The
    scene run from its start may end in another branch than they are of: compare.
    targets: what they were compared with, (2, n); m, of a body that nothing supports laid on it.
    strays: root mean square distance of the surface from each target; m: larger than the misfit where the
    surface has folds that the target lacks.
    count, rms: of all residuals, coordinates of landmarks among them: how many, and their size; m.
    remarks: values at bounds, outlines that are missed by much.
    """

    scene: Scene
    parameters: tuple[str, ...]
    values: Array
    deviations: Array
    misfits: dict[float, float]
    distinct: int
    singular_values: Array
    flat: Array
    solves: int
    message: str
    smoothness: float
    outlines: dict[float, Array]
    targets: dict[float, Array]
    strays: dict[float, float]
    count: int
    rms: float
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return it in lines, a line for each parameter; the arrays would fill pages."""
        names = [f"  {text}" for text in self.lines()[:SHOWN]]
        more = len(self.parameters) - len(names)
        misfit = max(self.misfits.values())
        told = f"{self.distinct} of {len(self.parameters)} combinations told, misfit up to {misfit:.3g} m"
        return "\n".join([f"Fit({told})", *names, *([f"  ... and {more} more"] if more > 0 else [])])

    def lines(self) -> list[str]:
        """Return a line for each parameter: its value and its standard error."""
        width = max(len(name) for name in self.parameters)
        rows = zip(self.parameters, self.values, self.deviations, strict=True)
        return [
            f"{name:<{width}} {value:>12.6g} ± "
            f"{f'{error:.2g}' if np.isfinite(error) else '? (the outlines do not tell it)'}"
            for name, value, error in rows
        ]


@dataclass(frozen=True, eq=False)
class Compared:
    """A target beside the pial surface.

    points: of the target, (2, n).  feet: on the surface.  residuals: weighted distances, (n,).
    rigid: what of them another move or turn would take back, orthonormal columns (n, 3), or none (n, 0).
    """

    points: Array
    feet: Feet
    residuals: Array
    rigid: Array


@dataclass(eq=False)
class Inverse:
    """The least squares problem, with the equilibria it has found so far."""

    scene: Scene
    parameters: tuple[str, ...]
    targets: dict[float, Array]
    landmarks: dict[float, Landmarks]
    smoothness: float
    out: Path | None
    progress: Callable[[float], object] | None
    solves: int = 0
    best: float = float("inf")  # norm of the least residuals
    _at: Array | None = None  # their parameters
    _x: dict[float, Array] = field(default_factory=dict)  # their displacements by age
    _kept: dict[float, dict[str, Array]] = field(default_factory=dict)  # fields beside them, by age
    _moves: dict[float, Array] = field(default_factory=dict)  # dx/dp by age

    def __post_init__(self) -> None:
        problem = Problem(self.scene)
        check_path(problem, problem.start())

    def residuals(self, values: Array) -> Array:
        """Return distances in cortical thicknesses, of all ages, and the differences that are to be small."""
        try:
            x = self._equilibria(self._with(values), values)
        except (SolveError, ValueError):  # no equilibrium, or a value that its part refuses
            if self._at is None:
                raise
            return np.full(self._count(), 1e3)  # scipy goes back to shorter steps
        rows = [self._compared(age, x[age]).residuals for age in self.targets]
        rows += [self._mark(age) * own.apart(x[age]).ravel() for age, own in self.landmarks.items()]
        found = np.concatenate([*rows, self._roughness() @ values])
        size = float(np.linalg.norm(found))
        better = size < self.best
        if better or (self._at is not None and np.array_equal(values, self._at)):
            # later equilibria start here: those of steps that are not taken may be of other branches
            self.best, self._at, self._x = size, values.copy(), x
        self._tell(values, found, better=better)
        return found

    def jacobian(self, values: Array) -> Array:
        """Return the derivatives of the residuals; raises NotConvergedError where there is no equilibrium."""
        if self._at is None or not np.array_equal(values, self._at):
            self.residuals(values)
        if self._at is None or not np.array_equal(values, self._at):
            raise NotConvergedError("the equilibria of the fit are not found again", time=max(self.targets))
        self._moves = {}
        rows, scene = [], self._with(values)
        problem = Problem(scene)
        start = problem.start()
        for age in self.targets:
            state = self._state(problem.processed(start, age), age)
            step, still = TimeStep(age, over=True), Still()
            at = configuration(problem.potentials(state, step), self._x[age])
            if at is None:
                raise NotConvergedError("an equilibrium of the fit is not admissible", time=age)
            tangent = Tangent(problem, at)
            changes = (
                change(problem, state, self._x[age], name, step, still).gradient for name in self.parameters
            )
            self._moves[age] = np.stack([-tangent.solve(gradient) for gradient in changes])
            found = self._compared(age, self._x[age])
            ways = np.stack([found.feet.of(self._pial(move, moved=False)) for move in self._moves[age]])
            moved = np.einsum("in,pin->np", found.feet.normals, ways) * self._weights(age)[:, None]
            rows.append(without_rigid(-moved, found.rigid))
        for age, own in self.landmarks.items():
            moved = np.stack([own.moved(move).ravel() for move in self._moves[age]], axis=1)
            rows.append(self._mark(age) * moved)
        return np.concatenate([*rows, self._roughness()])

    def _mark(self, age: float) -> float:
        """Return the weight of a landmark: that of a point of its outline; 1/m."""
        return float(1.0 / (np.sqrt(self.targets[age].shape[1]) * self.scene.body.thickness))

    def result(self, values: Array, message: str, noise: float | None) -> Fit:
        """Return what was found, with standard errors."""
        jacobian, residual, T = self.jacobian(values), self.residuals(values), self.scene.body.thickness
        weights = [self._weights(age) for age in self.targets]
        marks = [np.full(own.targets.size, self._mark(age)) for age, own in self.landmarks.items()]
        each = np.concatenate([*weights, *marks])  # the weight of each error
        data, ages = residual[: len(each)], np.repeat(np.arange(len(weights)), [len(w) for w in weights])
        outlines = np.bincount(ages, data[: len(ages)] ** 2)
        rms = float(np.linalg.norm(data) / np.linalg.norm(each))
        compared = {age: self._compared(age, self._x[age]) for age in self.targets}
        rigid = sum(one.rigid.shape[1] for one in compared.values())
        known = told(jacobian[: len(each)], each)  # of errors of 1 m
        if noise is None:  # from the misfit, over the degrees of freedom
            noise = rms * np.sqrt(len(each) / max(len(each) - known.distinct - rigid, 1))
        errors = known.deviations.copy()
        errors[np.isfinite(errors)] *= noise
        bias = smoothed_away(jacobian[: len(each)], self._roughness(), values)
        return Fit(
            scene=self._with(values), parameters=self.parameters, values=values,
            deviations=np.hypot(errors, bias),
            misfits=dict(zip(self.targets, (T * np.sqrt(outlines)).tolist(), strict=True)),
            distinct=known.distinct, singular_values=known.singular_values, flat=known.flat,
            solves=self.solves, message=message, smoothness=self.smoothness,
            outlines={age: self._nodes(self._x[age]) for age in self.targets},
            targets={age: one.points for age, one in compared.items()},
            strays={age: self._strays(age, one.points) for age, one in compared.items()},
            count=len(each), rms=rms,
        )  # fmt: skip

    def _strays(self, age: float, target: Array) -> float:
        """Return the root mean square distance of the pial surface from a target, m."""
        curve = self._pial(self._x[age])
        steps = np.hypot(*np.diff(curve, axis=1, append=curve[:, -1:]))
        distances, _ = Polygon(target, pial_closed(self.scene.body)).distances(curve)
        return float(np.sqrt(np.sum(distances**2 * steps) / steps.sum()))

    def _with(self, values: Array) -> Scene:
        scene = self.scene
        for name, value in zip(self.parameters, values.tolist(), strict=True):
            scene = changed_in(scene, name, value)
        return scene

    def _equilibria(self, scene: Scene, values: Array) -> dict[float, Array]:
        """Return the displacements at all ages: from the last ones, or by a march from the start."""
        if self._at is None:
            return self._marched(scene)
        problem = Problem(scene)
        start, found = problem.start(), {}
        for age in self.targets:
            old = self._x[age]
            ahead = None
            if age in self._moves:
                ahead = old + np.tensordot(values - self._at, self._moves[age], 1)
            state = self._state(problem.processed(start, age), age)
            stepping = scene.stepping
            minimiser = Minimiser(
                problem.n_dofs, problem.held, stepping.tolerance, stepping.iterations, None, stepping.solver
            )
            equilibrium = minimiser.minimise(problem.potentials(state, TimeStep(age, over=True)), old, ahead)
            if not equilibrium.stable:
                raise NotConvergedError("the fit came to a saddle", time=age)
            found[age] = equilibrium.x
            self.solves += 1
        return found

    def _marched(self, scene: Scene) -> dict[float, Array]:
        found, position = {}, begin(scene)
        for age in self.targets:
            position = replace(position, dt=scene.stepping.first * scene.until)
            stops = tuple(stop for stop in scene.stepping.stops if stop <= age)
            part = replace(scene, until=age, stepping=replace(scene.stepping, stops=stops))
            for _, reached in march(part, position):
                position = reached
                self.solves += 1
            found[age] = by_node(position.state["displacement"])
            self._kept[age] = {name: position.state[name] for name in KEPT if name in position.state}
        return found

    def _state(self, state: State, age: float) -> State:
        """Return the state of an age at the last equilibrium, with the fields that a march left there."""
        return state.updated(displacement=self._x[age].reshape(-1, 2).T, **self._kept[age])

    def _compared(self, age: float, x: Array) -> Compared:
        """Return how a target lies beside the pial surface.

        The target of a body that nothing supports is first laid on it.
        """
        points, weights = self.targets[age], self._weights(age)
        surface = Polygon(self._pial(x), pial_closed(self.scene.body))
        rigid = np.zeros((points.shape[1], 0))
        if self.scene.body.supported.size == 0:
            points, _, rigid = posed(points, weights, surface)
        feet = surface.feet(points)
        return Compared(points, feet, feet.distances * weights, rigid)

    def _weights(self, age: float) -> Array:
        """Return √(share of the target's length) of each of its points over the thickness, (n,); 1/m."""
        points, closed = self.targets[age], pial_closed(self.scene.body)
        steps = np.hypot(*np.diff(points, axis=1, append=points[:, :1] if closed else points[:, -1:]))
        shares = 0.5 * (steps + np.roll(steps, 1))
        return np.asarray(np.sqrt(shares / shares.sum()) / self.scene.body.thickness)

    def _pial(self, x: Array, *, moved: bool = True) -> Array:
        """Return samples of the deformed pial surface, or of a displacement of it, (2, n)."""
        there = self._nodes(x) if moved else self._nodes(x) - self._nodes(np.zeros_like(x))
        return sampled(there, closed=pial_closed(self.scene.body))

    def _nodes(self, x: Array) -> Array:
        """Return the nodes of the deformed pial surface, (2, n)."""
        body = self.scene.body
        return along_pial(body, (body.nodes + x.reshape(-1, 2).T)[:, body.pial])

    def _roughness(self) -> Array:
        """Return weighted second differences of neighbours in one map, (rows, p)."""
        rows = second_differences(self.parameters)
        return self.smoothness * rows if self.smoothness > 0 else rows[:0]

    def _count(self) -> int:
        marked = sum(own.targets.size for own in self.landmarks.values())
        return self._points + marked + len(self._roughness())

    @property
    def _points(self) -> int:
        """The number of points of all targets."""
        return sum(points.shape[1] for points in self.targets.values())

    def _tell(self, values: Array, residual: Array, *, better: bool) -> None:
        """Store what is better than all before, and tell the misfit of the outlines."""
        outlines = residual[: self._points]
        misfit = float(np.linalg.norm(outlines)) * self.scene.body.thickness / np.sqrt(len(self.targets))
        if better and self.out is not None:
            keep_best(self.out, self.parameters, values, misfit, self.smoothness, self.solves)
        if self.progress is not None:
            self.progress(misfit)
