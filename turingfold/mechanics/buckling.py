"""Buckling: the growth at which the tangent of the smooth solution stops being positive definite, and the mode.

The base path is followed by plain Newton steps on the true tangent K, which go on through a bifurcation where a
minimiser would leave for the folded branch; the signs of the pivots count the negative eigenvalues. The lowest
eigenvalue of K v = λ K₀ v, with K₀ the tangent of the undeformed body, is the share of its stiffness that is left:
1 at the start, almost linear in growth, 0 where the body buckles. Between the last stable state and the first
unstable one the displacement is interpolated along the path, so that nothing is solved with a singular tangent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator
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
FINEST = 1e-4  # smallest step towards a limit point, as a share of the scene's time
WORN = 0.1  # share of the stiffness below which a path that cannot be followed has come to a limit point
ITERATIONS = 15  # of Newton's method on the base path; it needs four or five


@dataclass(frozen=True, kw_only=True)
class Buckling:
    """The first loss of stability of a scene's smooth solution.

    growth: the largest tangential growth factor there (1 where nothing grows).  time: in the scene's units.
    mode: half waves along the pial surface, n of cos(nθ) on a half disc (of the whole body, for half of one).
    shape: the eigenvector, (2, n_nodes), its largest nodal displacement 1.
    state: the base state.  stiffness: the share of stiffness left there, as good as 0.
    limit: whether the base path ends there and turns back, rather than going on unstable beyond a bifurcation.
    """

    growth: float
    time: float
    mode: int
    shape: Array
    state: State
    stiffness: float
    limit: bool

    def switched(self, amplitude: float, dt: float) -> Progress:
        """Return the progress from which `march` goes on along the buckled branch.

        The base displacement plus amplitude (m; its sign chooses between the two sides) times the mode.
        dt: length of the first step from there, in the scene's time.
        """
        if finite("amplitude", amplitude) == 0:
            raise ValueError("amplitude=0 stays on the base path; give about a tenth of the cortical thickness in m.")
        moved = self.state["displacement"] + amplitude * self.shape
        return Progress(self.state.updated(displacement=moved), positive("dt", dt))


def buckling(scene: Scene) -> Buckling:
    """Return the first loss of stability along the scene's smooth solution, followed in steps of `scene.stepping`.

    At a bifurcation the critical growth is interpolated; at a limit point it is found to 1e-4 of the scene's time.
    Terms that resist motion (inertia, drag) would stiffen the tangent: leave them out.
    Raises NotConvergedError if the solution stays stable until the scene's end, or cannot be followed.
    """
    path = BasePath(scene)
    nodes, limit = _bracket(path)
    base = nodes[-1] if limit else _crossing(path, nodes)
    stiffness, vector = path.lowest(base)
    if limit and stiffness > WORN:
        raise NotConvergedError(
            f"The base path cannot be followed beyond t = {base.state.time:.6g}, growth "
            f"{largest_growth(base.state):.4g}, though {stiffness:.0%} of the stiffness is left; use smaller steps "
            "(Stepping(largest=...)) or smaller elements.",
            time=base.state.time,
        )
    shape = np.zeros(len(base.x))
    shape[path.gatherer.free] = vector
    shape = shape.reshape(-1, 2).T / np.hypot(*shape.reshape(-1, 2).T).max()
    return Buckling(
        growth=largest_growth(base.state), time=base.state.time, mode=half_waves(scene.body, shape), shape=shape,
        state=base.state, stiffness=stiffness, limit=limit,
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
        unit = symmetric(pattern, np.where(pattern.rows == pattern.columns, 1.0 + pattern.n, 1e-3))
        options = {"SymmetricMode": True}
        ordering = splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        self._order: Integers = np.argsort(ordering.perm_c)
        self._places = symmetric(pattern, marks)[self._order][:, self._order].tocsc()
        self._places.sort_indices()  # splu would do so in place, and part the entries from their marks
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


def symmetric(pattern: Pattern, values: Array) -> csc_matrix:
    """Return the whole matrix whose lower triangle is given."""
    below = pattern.rows != pattern.columns
    rows = np.concatenate([pattern.rows, pattern.columns[below]])
    columns = np.concatenate([pattern.columns, pattern.rows[below]])
    return csc_matrix((np.concatenate([values, values[below]]), (rows, columns)), shape=(pattern.n, pattern.n))


@dataclass(frozen=True)
class BaseState:
    """A state on the base path, stable or not: `tangent` on `pattern`, and its number of negative pivots."""

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
        self.first = begin(scene).state
        self._kept: tuple[Pattern, Indefinite] | None = None
        at = evaluations(self._potentials(self.first, scene.stepping.first * scene.until), self.position(self.first))
        if at is None:
            raise NotConvergedError("the scene's start is not admissible", time=0.0)
        self.rest = [e.hessian(0.0) for e in at if e.curved]
        if self.solver(self.gatherer.gather(self.rest)[0]).factorize(self.gatherer.gather(self.rest)[1]).negative:
            raise NotConvergedError("the scene is unstable at its start, before anything has grown", time=0.0)

    @staticmethod
    def position(state: State) -> Array:
        """Return the displacement node by node, (2 n_nodes,)."""
        return state["displacement"].T.ravel()

    def _potentials(self, state: State, dt: float) -> list[Potential]:
        return [p for p in (operator.during(state, dt) for operator in self.operators) if p is not None]

    def solver(self, pattern: Pattern) -> Indefinite:
        """Return the factoriser of a pattern, kept until another pattern comes."""
        if self._kept is None or self._kept[0] is not pattern:
            self._kept = pattern, Indefinite(pattern)
        return self._kept[1]

    def processed(self, start: State, dt: float) -> State:
        """Return `start` with the fields that the processes have dt later."""
        fields: dict[str, Array] = {}
        for process in self.scene.processes:
            fields |= process.advance(self.scene.body, State(start.time, {**start.fields, **fields}), dt)
        return start.updated(start.time + dt, **fields)

    def step(self, start: State, dt: float, ahead: Array | None) -> BaseState:
        """Return the equilibrium dt after `start`; ahead: the expected change of displacement (2 n_nodes,).

        Raises NotConvergedError where Newton fails, or ends further from the expected place than that is away.
        """
        state, old = self.processed(start, dt), self.position(start)
        potentials = self._potentials(state, dt)
        guess = old if ahead is None else old + ahead
        if evaluations(potentials, guess) is None:
            guess = old
        x, tangent, pattern, negative = self._newton(potentials, guess)
        if ahead is not None and np.linalg.norm(x - old - ahead) > STRAY * np.linalg.norm(ahead):
            raise NotConvergedError("Newton leaves the base path", time=state.time)
        for potential in potentials:
            state = state.updated(**potential.finish(x))
        state = state.updated(displacement=x.reshape(-1, 2).T.copy())
        return BaseState(state, x, pattern, tangent, negative)

    def _newton(self, potentials: Sequence[Potential], x: Array) -> tuple[Array, Array, Pattern, int]:
        at = evaluations(potentials, x)
        if at is None:
            raise NotConvergedError("the start of the step is not admissible")
        for iteration in range(ITERATIONS):
            parts = [e.gradient() for e in at]
            slope = np.sum([g for g, _ in parts], axis=0)[self.gatherer.free]
            residual = float(np.linalg.norm(slope) / np.sqrt(sum(s for _, s in parts) or 1.0))
            pattern, tangent = self.gatherer.gather([e.hessian(0.0) for e in at if e.curved])
            factors = self.solver(pattern).factorize(tangent)
            if residual <= self.scene.stepping.tolerance and iteration > 0:
                return x, tangent, pattern, factors.negative
            move = -factors.solve(slope)
            move -= factors.solve(pattern.times(tangent, move) + slope)
            direction = np.zeros(len(x))
            direction[self.gatherer.free] = move
            x, at = _moved(potentials, at, x, direction, float(slope @ move))
        raise NotConvergedError("Newton does not find the base path", residual=residual)

    def between(self, nodes: Sequence[BaseState], time: float) -> BaseState:
        """Return the state at `time` with the displacement, and what the terms remember, interpolated."""
        start = nodes[-2].state
        state = self.processed(start, time - start.time)
        made = {name for process in self.scene.processes for name in process.writes}
        times = np.array([node.state.time for node in nodes])
        for name in start.fields:
            if name not in made and all(name in node.state for node in nodes):
                values = np.stack([node.state[name] for node in nodes])
                state = state.updated(**{name: BarycentricInterpolator(times, values)(time)})
        x = self.position(state)
        at = evaluations(self._potentials(state, nodes[-1].state.time - start.time), x)
        if at is None:
            raise NotConvergedError("the interpolated base state is not admissible; use smaller steps", time=time)
        pattern, tangent = self.gatherer.gather([e.hessian(0.0) for e in at if e.curved])
        return BaseState(state, x, pattern, tangent, self.solver(pattern).factorize(tangent).negative)

    def lowest(self, base: BaseState) -> tuple[float, Array]:
        """Return the lowest eigenvalue of (K, K₀), and its vector over the free unknowns."""
        pattern, rest = self.gatherer.gather(self.rest)
        solver, shift, below = self.solver(pattern), 0.0, 0.01
        factors = solver.factorize(base.tangent)
        while factors.negative:  # below the whole spectrum the nearest eigenvalue is the lowest one
            shift, below = shift - below, 2 * below
            factors = solver.factorize(base.tangent - shift * rest)
        inverse = LinearOperator((pattern.n, pattern.n), matvec=factors.solve, dtype=float)
        start = np.random.default_rng(self.scene.seed).standard_normal(pattern.n)
        try:
            values, vectors = eigsh(
                symmetric(pattern, base.tangent), k=1, M=symmetric(pattern, rest), sigma=shift, OPinv=inverse,
                v0=start, tol=1e-8,
            )
        except ArpackError as error:
            raise NotConvergedError(
                f"the lowest eigenpair at t = {base.state.time:.4g} is not found", time=base.state.time
            ) from error
        return float(values[0]), vectors[:, 0]


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


def _bracket(path: BasePath) -> tuple[list[BaseState], bool]:
    """Return up to three stable states and the first unstable one, or stable ones up to a limit point and True."""
    stepping, until = path.scene.stepping, path.scene.until
    nodes: list[BaseState] = []
    state, dt, longest, ahead = path.first, stepping.first * until, stepping.largest * until, None
    while state.time < until * (1 - 1e-12):
        dt = min(dt, until - state.time)
        now = _attempt(path, state, dt, ahead)
        if now is None:
            dt = longest = dt / 2
            if dt >= FINEST * until:
                continue
            if not nodes:
                raise NotConvergedError("the base path has no first step; use a smaller Stepping(first=...)", time=0.0)
            return nodes, True
        if now.negative:
            if not nodes:
                raise NotConvergedError("unstable after the first step; use a smaller Stepping(first=...)", time=dt)
            return [*nodes, now], False
        ahead = (now.x - path.position(state)) / (now.state.time - state.time)
        state, nodes, dt = now.state, [*nodes[-2:], now], min(1.3 * dt, longest)
    raise NotConvergedError(
        f"No loss of stability until t = {until:g}, growth {largest_growth(state):.4g}; let it grow more.", time=until
    )


def _attempt(path: BasePath, state: State, dt: float, ahead: Array | None) -> BaseState | None:
    """Return the base state dt ahead, or None; a step that ends too near a bifurcation is tried a little longer."""
    leap = dt > 0.1 * path.scene.stepping.largest * path.scene.until
    for length in (dt, 1.5 * dt) if leap else (dt,):
        try:
            found = path.step(state, length, None if ahead is None else ahead * length)
        except SolveError:
            continue
        return found if length == dt or found.negative else None
    return None


def _crossing(path: BasePath, nodes: list[BaseState]) -> BaseState:
    """Return the state between the last two nodes where the lowest eigenvalue vanishes."""
    start, end = nodes[-2].state.time, nodes[-1].state.time
    root = brentq(
        lambda time: path.lowest(path.between(nodes, time))[0], start, end, xtol=1e-3 * (end - start), rtol=1e-7
    )
    return path.between(nodes, float(root))
