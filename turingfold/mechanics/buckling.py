"""Buckling: the growth at which the tangent of the smooth solution stops being positive definite, and the mode.

The base solution is followed by plain Newton steps on the true tangent, which go on through a bifurcation where a
minimiser would leave for the folded branch. Signs of the pivots count the negative eigenvalues (Sylvester's law of
inertia); between the last state without and the first one with any, the time at which the lowest eigenvalue λ of
K v = λ M v vanishes is found by a bracketed secant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import ArpackError, LinearOperator, SuperLU, eigsh, splu

from ..body import Body
from ..checks import finite, positive
from ..scene import Evaluation, Hessian, NotConvergedError, Potential, Scene, SolveError, State
from .linear import Gatherer, Pattern
from .march import Progress, begin
from .mixed_ray import evaluations, rays

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

VISIBLE = 0.02  # lobes of the mode below this share of the highest one do not count as half waves
STRAY = 1.0  # a correction larger than this share of the step itself has left the base path


@dataclass(frozen=True, kw_only=True)
class Buckling:
    """The first loss of stability of a scene's smooth solution.

    growth: the largest tangential growth factor there (1 where nothing grows).  time: in the scene's units.
    mode: half waves along the pial surface, n of cos(nθ) on a half disc (of the whole body, for half of one).
    shape: the eigenvector, (2, n_nodes), its largest nodal displacement 1.
    state: the base state.  eigenvalue: the lowest one there, of stiffness over area mass, Pa/m².
    path: times and lowest eigenvalues examined around the crossing, (2, k).
    """

    growth: float
    mode: int
    shape: Array
    time: float
    state: State
    eigenvalue: float
    path: Array

    def switched(self, amplitude: float, dt: float) -> Progress:
        """Return the progress from which `march` leaves along the buckled branch.

        The base displacement plus amplitude (m; its sign chooses between the two sides) times the mode; dt: the
        next step in time, long enough that the branch lies further from the base path than `amplitude`.
        """
        if finite("amplitude", amplitude) == 0:
            raise ValueError("amplitude=0 stays on the base path; give about a tenth of the cortical thickness in m.")
        moved = self.state["displacement"] + amplitude * self.shape
        return Progress(self.state.updated(displacement=moved), positive("dt", dt))


def buckling(scene: Scene) -> Buckling:
    """Return the first loss of stability along the scene's smooth solution.

    It is followed in steps of `scene.stepping`. Terms that resist motion (inertia, drag) would stiffen the tangent
    by their share of it: leave them out.
    Raises NotConvergedError if the solution stays stable until the scene's end, or cannot be followed.
    """
    path = BasePath(scene)
    stable, unstable = _bracket(path)
    found = _crossing(path, stable, unstable)
    value, vector = path.lowest(found)
    shape = np.zeros(len(found.x))
    shape[path.gatherer.free] = vector
    shape = shape.reshape(-1, 2).T
    shape = shape / np.hypot(*shape).max()
    body, time = scene.body, found.state.time
    return Buckling(
        growth=largest_growth(found.state), mode=half_waves(body, shape), shape=shape, time=time,
        state=found.state, eigenvalue=value, path=path.examined(),
    )


def largest_growth(state: State) -> float:
    """Return the largest tangential growth factor, or 1 where nothing grows."""
    return float(state["growth"][0].max()) if "growth" in state else 1.0


def half_waves(body: Body, shape: Array) -> int:
    """Return the half waves of a displacement (2, n_nodes) normal to the pial surface, n of cos(nθ) on a half disc.

    Each change of sign between lobes of at least 2 % of the highest one ends a half wave; an end of the surface
    that is held ends one too. Half a body counts twice.
    """
    tangent = body.pial_curve.nearest(body.nodes[:, body.pial])[1]
    normal = tangent[0] * shape[1, body.pial] - tangent[1] * shape[0, body.pial]
    lobes = np.sign(normal[np.abs(normal) > VISIBLE * np.abs(normal).max()])
    changes = int(np.sum(lobes[1:] != lobes[:-1]))
    if body.pial_curve.closed:
        return changes + int(lobes[0] != lobes[-1])
    fixed = set(body.fixed.tolist())
    held = sum({2 * node, 2 * node + 1} <= fixed for node in (int(body.pial[0]), int(body.pial[-1])))
    return 2 * changes + held if body.mirror else changes + held // 2


def negative_pivots(pattern: Pattern, values: Array) -> int:
    """Return the number of negative eigenvalues of a symmetric matrix (see `linear.Pattern`)."""
    return Indefinite(pattern).factorize(values).negative


@dataclass(frozen=True)
class Factors:
    """A factorisation P A Pᵀ = L D Lᵀ: `negative` is the number of negative entries of D, and eigenvalues of A."""

    lu: SuperLU
    order: Integers
    negative: int

    def solve(self, b: Array) -> Array:
        """Return A⁻¹ b, for b of shape (n,)."""
        x = np.empty_like(b)
        x[self.order] = self.lu.solve(b[self.order])
        return x


class Indefinite:
    """Factorises symmetric matrices of one pattern by SuperLU without row exchanges; they may be indefinite."""

    def __init__(self, pattern: Pattern) -> None:
        self._n = pattern.n
        marks = np.arange(1.0, len(pattern.keys) + 1)  # of the entries, to find them again after reordering
        unit = _symmetric(pattern, np.where(pattern.rows == pattern.columns, 1.0 + pattern.n, 1e-3))
        options = {"SymmetricMode": True}
        ordering = splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        self._order: Integers = np.argsort(ordering.perm_c)
        self._places = _symmetric(pattern, marks)[self._order][:, self._order].tocsc()
        self._take = self._places.data.astype(np.int64) - 1

    def factorize(self, values: Array) -> Factors:
        """Return the factors; raises NotConvergedError for an exactly singular matrix."""
        places = self._places
        matrix = csc_matrix((values[self._take], places.indices, places.indptr), shape=(self._n, self._n))
        try:
            lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise NotConvergedError("the tangent is exactly singular") from error
        if not np.array_equal(lu.perm_r, lu.perm_c):
            raise NotConvergedError("the tangent has a zero pivot")
        return Factors(lu, self._order, int(np.sum(lu.U.diagonal() < 0)))


def _symmetric(pattern: Pattern, values: Array) -> csc_matrix:
    below = pattern.rows != pattern.columns
    rows = np.concatenate([pattern.rows, pattern.columns[below]])
    columns = np.concatenate([pattern.columns, pattern.rows[below]])
    return csc_matrix((np.concatenate([values, values[below]]), (rows, columns)), shape=(pattern.n, pattern.n))


@dataclass(frozen=True)
class BaseState:
    """An equilibrium on the base path, stable or not: `tangent` on `pattern`, and its number of negative pivots."""

    state: State
    x: Array
    pattern: Pattern
    tangent: Array
    negative: int


class BasePath:
    """The smooth solution of a scene, followed by plain Newton steps."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.operators = [term.on(scene.body) for term in scene.terms]
        self.gatherer = Gatherer(2 * scene.body.nodes.shape[1], scene.body.fixed)
        self.mass = _mass(scene.body)
        self.gatherer.gather([self.mass])
        self._values: dict[float, float] = {}
        self._solver: tuple[Pattern, Indefinite] | None = None

    @cached_property
    def first(self) -> State:
        """The state at the scene's start."""
        return begin(self.scene).state

    def solver(self, pattern: Pattern) -> Indefinite:
        """Return the factoriser of a pattern, kept until another pattern comes."""
        if self._solver is None or self._solver[0] is not pattern:
            self._solver = pattern, Indefinite(pattern)
        return self._solver[1]

    def step(self, start: State, dt: float, ahead: Array | None = None) -> BaseState:
        """Return the equilibrium dt after `start`; ahead: the expected change of displacement (2 n_nodes,).

        Raises NotConvergedError where Newton fails or ends up further from the expected place than that is away.
        """
        scene, fields = self.scene, dict[str, Array]()
        for process in scene.processes:
            fields |= process.advance(scene.body, State(start.time, {**start.fields, **fields}), dt)
        state = start.updated(start.time + dt, **fields)
        potentials = [p for p in (operator.during(state, dt) for operator in self.operators) if p is not None]
        old = start["displacement"].T.ravel()
        guess = old if ahead is None else old + ahead
        if ahead is not None and evaluations(potentials, guess) is None:
            guess = old
        x, tangent, pattern, negative = self._newton(potentials, guess)
        if ahead is not None and np.linalg.norm(x - old - ahead) > STRAY * np.linalg.norm(ahead):
            raise NotConvergedError(f"Newton left the base path at t = {state.time:.4g}", time=state.time)
        for potential in potentials:
            state = state.updated(**potential.finish(x))
        state = state.updated(displacement=x.reshape(-1, 2).T.copy())
        return BaseState(state, x, pattern, tangent, negative)

    def _newton(self, potentials: Sequence[Potential], x: Array) -> tuple[Array, Array, Pattern, int]:
        at = evaluations(potentials, x)
        if at is None:
            raise NotConvergedError("the start of the step is not admissible")
        best = np.inf
        for iteration in range(self.scene.stepping.iterations):
            slope, residual = self._residual(at)
            pattern, tangent = self.gatherer.gather([e.hessian(0.0) for e in at if e.curved])
            factors = self.solver(pattern).factorize(tangent)
            if residual <= self.scene.stepping.tolerance and iteration > 0:
                return x, tangent, pattern, factors.negative
            if residual > 1e3 * best:
                break
            best = min(best, residual)
            move = -factors.solve(slope)
            move -= factors.solve(pattern.times(tangent, move) + slope)
            direction = np.zeros(len(x))
            direction[self.gatherer.free] = move
            x, at = _moved(potentials, at, x, direction, float(slope @ move))
        raise NotConvergedError("Newton does not reach the base path", residual=residual)

    def _residual(self, at: list[Evaluation]) -> tuple[Array, float]:
        parts = [e.gradient() for e in at]
        slope = np.sum([g for g, _ in parts], axis=0)[self.gatherer.free]
        scale = float(np.sqrt(sum(s for _, s in parts)))
        return slope, float(np.linalg.norm(slope)) / (scale if scale > 0 else 1.0)

    def lowest(self, base: BaseState) -> tuple[float, Array]:
        """Return the lowest eigenpair of (tangent, mass); the vector over the free unknowns."""
        pattern, solver = base.pattern, self.solver(base.pattern)
        _, mass = self.gatherer.gather([self.mass])
        sigma, below = 0.0, solver.factorize(base.tangent)
        step = abs(self._values[min(self._values)]) if self._values else _scale(pattern, base.tangent, mass)
        while below.negative:  # a shift below the whole spectrum makes the nearest eigenvalue the lowest one
            sigma -= step
            step *= 2
            below = solver.factorize(base.tangent - sigma * mass)
        shape = (pattern.n, pattern.n)
        inverse = LinearOperator(shape, matvec=below.solve, dtype=float)
        start = np.random.default_rng(self.scene.seed).standard_normal(pattern.n)
        try:
            values, vectors = eigsh(
                _symmetric(pattern, base.tangent), k=1, M=_symmetric(pattern, mass), sigma=sigma, OPinv=inverse,
                v0=start, tol=1e-8,
            )
        except ArpackError as error:
            raise NotConvergedError(f"the lowest eigenpair at t = {base.state.time:.4g} is not found") from error
        self._values[base.state.time] = float(values[0])
        return float(values[0]), vectors[:, 0]

    def examined(self) -> Array:
        """Return the times and lowest eigenvalues found so far, (2, k)."""
        return np.array(sorted(self._values.items())).T


def _moved(
    potentials: Sequence[Potential], at: list[Evaluation], x: Array, direction: Array, decrease: float
) -> tuple[Array, list[Evaluation]]:
    """Return the configuration a full Newton step ahead, or the admissible part of one."""
    along = rays(potentials, at, x, direction, decrease)
    step = min(ray.longest for ray in along)
    while step > 1e-3:
        there = [ray.at(step) for ray in along]
        found = [pair[1] for pair in there if pair is not None]
        if len(found) == len(there):
            return x + step * direction, found
        step *= 0.5
    raise NotConvergedError("the Newton direction leaves the admissible states at once")


def _bracket(path: BasePath) -> tuple[BaseState, BaseState]:
    """Return neighbouring states of the base path, the first stable and the second not."""
    scene, state = path.scene, path.first
    stepping, until = scene.stepping, scene.until
    dt, ahead, previous = stepping.first * until, None, None
    while state.time < until * (1 - 1e-12):
        dt = min(dt, until - state.time)
        try:
            now = path.step(state, dt, None if ahead is None else ahead * dt)
        except SolveError as error:
            dt /= 2
            if dt < stepping.smallest * until:
                raise NotConvergedError(
                    f"The base path stops at t = {state.time:.6g}, growth {largest_growth(state):.4g}: {error}. "
                    "It has probably reached a limit point; look at smaller steps or another base.",
                    time=state.time, residual=error.residual,
                ) from error
            continue
        if now.negative:
            if previous is None:
                raise NotConvergedError(f"already unstable at t = {now.state.time:.4g}; start with smaller steps.")
            return previous, now
        ahead = (now.x - state["displacement"].T.ravel()) / dt
        state, previous, dt = now.state, now, min(1.3 * dt, stepping.largest * until)
    raise NotConvergedError(
        f"No loss of stability until t = {until:g}, growth {largest_growth(state):.4g}; let it grow more.",
        time=until,
    )


def _crossing(path: BasePath, stable: BaseState, unstable: BaseState) -> BaseState:
    """Return the state between the two where the lowest eigenvalue vanishes."""
    start, span = stable.state, unstable.state.time - stable.state.time
    ahead = (unstable.x - stable.x) / span
    seen = {0.0: stable, span: unstable}

    def value(dt: float) -> float:
        if dt not in seen:
            seen[dt] = path.step(start, dt, ahead * dt)
        return path.lowest(seen[dt])[0]

    root = float(brentq(value, 0.0, span, xtol=1e-5 * path.scene.until, rtol=1e-8))
    if root not in seen:
        value(root)
    return seen[root]


def _scale(pattern: Pattern, tangent: Array, mass: Array) -> float:
    """Return a small share of the tangent's size relative to the mass."""
    diagonal = pattern.rows == pattern.columns
    return 1e-6 * float(np.abs(tangent[diagonal]).max() / mass[diagonal].max())


def _mass(body: Body) -> Hessian:
    """Return the mass matrix ∫ v·w dA of unit area density."""
    quadrature = body.quadrature
    low, high = np.tril_indices(6)[::-1]
    values = (quadrature.shapes[low] * quadrature.shapes[high]) @ quadrature.weights
    one, other = 2 * body.triangles[low], 2 * body.triangles[high]
    rows, columns = np.maximum(one, other), np.minimum(one, other)
    return Hessian(np.concatenate([rows, rows + 1]), np.concatenate([columns, columns + 1]),
                   np.concatenate([values, values]), lasting=True)
