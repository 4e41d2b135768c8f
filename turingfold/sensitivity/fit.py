"""Which parameters made this shape? Gauss-Newton on the distance between target outlines and pial surface.

At each age the points y_j of the target have the signed distances d_j from the pial surface along its normal
n_j, at their feet x_j: no correspondence of points is needed. Their derivatives are -n_j · dx_j/dp, and
dx/dp = -K⁻¹ ∂g/∂p is nearly free at an equilibrium. So the errors of the points count, one each, and not the
slopes that they give the target. Equilibria of new parameters start from the last ones, moved along dx/dp.
The sum of squares is minimised by scipy's trust region method with bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares

from ..arrays import Array
from ..checks import finite, instance, positive
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
from .change import change, check_path
from .fit_setup import best_so_far, check_fitted, checked_start, keep_best, limits, make_folder
from .landmarks import Landmarks, checked_landmarks
from .parameters import changed_in, values_in
from .remarks import remarks
from .smoothing import misfit, second_differences, smoothest
from .standard_errors import smoothed_away, told
from .tangent import Tangent
from .targets import checked_targets

STALLED = 1e-7  # relative decrease of the sum of squares that ends a fit: far less than noise moves it by
EVALUATIONS = 100  # of the residuals, at most
SHOWN = 8  # parameters that are named where a fit is printed


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


def fit(
    scene: Scene,
    targets: Mapping[float, Any],
    to: Sequence[str],
    *,
    bounds: tuple[float, float] | Mapping[str, tuple[float, float]] | None = None,
    landmarks: Mapping[float, Sequence[tuple[Any, Any]]] | None = None,
    smoothness: float | Literal["auto"] = 0.0,
    noise: float | None = None,
    tolerance: float = 1e-8,
    out: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[float], object] | None = None,
) -> Fit:
    """Return the parameters with which the scene's pial surface comes closest to target outlines.

    targets: by age (the scene's time), points (2, n) in m, in order; open ones reach as far as the pial
    surface; a body that nothing supports is laid on them first.  to: parameters, such as
    "GrowthMap.cortex.0", "TangentialGrowth.core", "Elastic.gray.mu".
    bounds: least and largest value of all, or by parameter or map ("GrowthMap.cortex") of those named.
    landmarks: by age, pairs of a place on the undeformed surface, a share of its length or a point in m, and
    the point, m, where it is at that age; each counts as much as a point of the outline.
    smoothness: weight of the second differences of values that are neighbours in one map, against distances
    in units of the cortical thickness; "auto": as much as the noise allows, or by the L-curve (see
    `smoothing.smoothest`).  noise: standard deviation of the targets, m, for the standard errors; else they
    follow from the misfit.
    out: a folder in which fit.json always holds the best so far, of one that runs, and at the end what was
    found; one of an earlier fit is replaced.  resume: begin with that, if it is there.
    progress: is called with each root mean square distance of the outlines, m.
    Raises ValueError for targets that cross themselves or are far off, ages outside the scene, and scenes
    whose state depends on the way to it; NotConvergedError where the scene itself does not reach the ages.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    check_fitted(to)
    if noise is not None:
        positive("noise", noise, remedy="it is the standard deviation of the targets' points, in m")
    if smoothness == "auto":
        if not len(second_differences(to)):
            raise ValueError('smoothness="auto" needs three neighbours of one map among the parameters.')
        return _smoothest(
            lambda begun, weight, again: fit(
                begun, targets, to, bounds=bounds, landmarks=landmarks, smoothness=weight, noise=noise,
                tolerance=tolerance, out=out, resume=resume and not again, progress=progress,
            ),
            scene, noise, None if out is None else Path(out),
            sum(points.shape[1] for points in checked_targets(scene, targets).values()),
        )  # fmt: skip
    if isinstance(smoothness, str) or finite("smoothness", smoothness) < 0:
        raise ValueError(f'smoothness={smoothness!r} must be 0 or more, or "auto".')
    positive("tolerance", tolerance)
    curves = checked_targets(scene, targets)
    marks = checked_landmarks(scene.body, curves, landmarks or {})
    values = values_in(scene, to)
    if resume:
        if out is None:
            raise ValueError("resume=True goes on from what `out` holds; give that folder.")
        values = best_so_far(Path(out), tuple(to), values)
    low, high = limits(bounds, to)
    values = checked_start(values, low, high, to)
    folder = None if out is None else Path(out)
    if folder is not None:
        make_folder(folder)
    problem = _Inverse(scene, tuple(to), curves, marks, smoothness, folder, progress)
    solved = least_squares(
        problem.residuals, values, jac=problem.jacobian, bounds=(low, high), x_scale="jac",
        xtol=tolerance, ftol=STALLED, gtol=None, max_nfev=EVALUATIONS,
    )  # fmt: skip
    found = problem.result(np.asarray(solved.x), str(solved.message), noise)
    said = remarks(to, found.values, low, high, found.misfits, scene.body.thickness, noise)
    return replace(found, remarks=tuple(said))


def _smoothest(
    fitted: Callable[[Scene, float, bool], Fit], scene: Scene, noise: float | None, out: Path | None,
    points: int,
) -> Fit:  # fmt: skip
    """Return the fit of the smoothest map; fitted: by the scene it begins with, the weight, whether again."""

    def with_weight(weight: float, last: Fit | None) -> Fit:
        return fitted(scene if last is None else last.scene, weight, last is not None)

    found, how = smoothest(with_weight, noise, points)
    if out is not None:
        keep_best(out, found.parameters, found.values, misfit(found), found.smoothness, found.solves)
    return replace(found, message=f"{found.message} {how}")


@dataclass(eq=False)
class _Inverse:
    """The least squares problem, with the equilibria it has found so far."""

    scene: Scene
    parameters: tuple[str, ...]
    targets: dict[float, Array]
    landmarks: dict[float, Landmarks]
    smoothness: float
    out: Path | None
    progress: Callable[[float], object] | None
    solves: int = 0
    best: float = float("inf")
    _best: tuple[Array, dict[float, Array]] | None = None  # parameters and displacements by age
    _at: Array | None = None  # the parameters of `_x`
    _x: dict[float, Array] = field(default_factory=dict)  # displacement by age
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
        self._at, self._x, self._moves = values.copy(), x, {}
        rows = [self._compared(age, x[age])[1] for age in self.targets]
        rows += [self._mark(age) * own.apart(x[age]).ravel() for age, own in self.landmarks.items()]
        found = np.concatenate([*rows, self._roughness() @ values])
        self._keep(values, x, found)
        return found

    def _go_to(self, values: Array) -> None:
        """Have the equilibria of some values at hand; raises NotConvergedError where they are not found."""
        if self._at is not None and np.array_equal(values, self._at):
            return
        if self._best is not None and np.array_equal(values, self._best[0]):  # the last step was not taken
            self._at, self._x, self._moves = *self._best, {}
            return
        self.residuals(values)
        if self._at is None or not np.array_equal(values, self._at):
            raise NotConvergedError("the equilibria of the fit are not found again", time=max(self.targets))

    def jacobian(self, values: Array) -> Array:
        """Return the derivatives of the residuals."""
        self._go_to(values)
        rows, scene = [], self._with(values)
        problem = Problem(scene)
        start = problem.start()
        for age in self.targets:
            state = problem.processed(start, age).updated(displacement=self._x[age].reshape(-1, 2).T)
            step = TimeStep(age)
            at = configuration(problem.potentials(state, step), self._x[age])
            if at is None:
                raise NotConvergedError("an equilibrium of the fit is not admissible", time=age)
            tangent = Tangent(problem, at)
            changes = (change(problem, state, self._x[age], name, step).gradient for name in self.parameters)
            self._moves[age] = np.stack([-tangent.solve(gradient) for gradient in changes])
            found, _, rigid = self._compared(age, self._x[age])
            ways = np.stack([found.of(self._pial(move, moved=False)) for move in self._moves[age]])
            moved = np.einsum("in,pin->np", found.normals, ways) * self._weights(age)[:, None]
            rows.append(without_rigid(-moved, rigid))
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
        if noise is None:
            told_apart = max(len(each) - len(values), 1)
            noise = float(np.linalg.norm(data) / np.linalg.norm(each) * np.sqrt(len(each) / told_apart))
        found = told(jacobian[: len(each)], noise * each)
        taken = smoothed_away(jacobian, self._roughness(), values)
        return Fit(
            scene=self._with(values), parameters=self.parameters, values=values,
            deviations=np.hypot(found.deviations, taken),
            misfits=dict(zip(self.targets, (T * np.sqrt(outlines)).tolist(), strict=True)),
            distinct=found.distinct, singular_values=found.singular_values, flat=found.flat,
            solves=self.solves, message=message, smoothness=self.smoothness,
            outlines={age: self._nodes(self._x[age]) for age in self.targets},
        )  # fmt: skip

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
            state = problem.processed(start, age).updated(displacement=old.reshape(-1, 2).T)
            stepping = scene.stepping
            minimiser = Minimiser(
                problem.n_dofs, problem.held, stepping.tolerance, stepping.iterations, None, stepping.solver
            )
            equilibrium = minimiser.minimise(problem.potentials(state, TimeStep(age)), old, ahead)
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
        return found

    def _compared(self, age: float, x: Array) -> tuple[Feet, Array, Array]:
        """Return a target's points' feet on the pial surface, their weighted distances, and what is rigid.

        The target of a body that nothing supports is first laid on it; of another one, nothing is, (n, 0).
        """
        points, weights = self.targets[age], self._weights(age)
        surface = Polygon(self._pial(x), pial_closed(self.scene.body))
        rigid = np.zeros((points.shape[1], 0))
        if self.scene.body.supported.size == 0:
            points, _, rigid = posed(points, weights, surface.distances)
        found = surface.feet(points)
        return found, found.distances * weights, rigid

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

    def _keep(self, values: Array, x: dict[float, Array], residual: Array) -> None:
        """Store the best so far, and tell the misfit of the outlines."""
        outlines = residual[: self._points]
        misfit = float(np.linalg.norm(outlines)) * self.scene.body.thickness / np.sqrt(len(self.targets))
        size = float(np.linalg.norm(residual))
        if size < self.best:
            self.best, self._best = size, (values.copy(), x)
            if self.out is not None:
                keep_best(self.out, self.parameters, values, misfit, self.smoothness, self.solves)
        if self.progress is not None:
            self.progress(misfit)
