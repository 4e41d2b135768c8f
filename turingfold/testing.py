"""Examinations of parts: those that turingfold's own pass, for those of a user's own.

Each raises AssertionError that says what is wrong. Derivatives are held to their Taylor remainders, which
fall with order 2 where they are right and with order 1 where they are not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import csc_matrix, tril

from .arrays import Array
from .geometry.body import Body
from .parts import Evaluation, Hessian, Potential, Process, Term, TimeStep
from .scene import Scene
from .sensitivity.change import Change, change
from .sensitivity.parameters import number_of, numbers_of
from .solve.problem import Problem, configuration
from .state import State
from .turing.kinetics.base import Kinetics

STEPS = 2.0 ** -np.arange(0.0, 15.0, 2.0)
SHORTEST = 2.0 ** -np.arange(24.0, 27.0)  # steps over which a remainder is round-off, of a share ROUND_OFF
ROUND_OFF = 1e-9
ORDER = 1.9  # of a remainder that is meant to have order 2
SMOOTH = 1e-4  # relative error of a derivative by differences (contact: 2e-5, its barrier is C²)


def dense(hessian: Hessian, n_dofs: int) -> Array:
    """Return a Hessian, given by its lower triangle, as the full symmetric matrix."""
    rows, columns = hessian.entries.rows.ravel(), hessian.entries.columns.ravel()
    _hold(bool((rows >= columns).all()), "an entry lies above the diagonal")
    lower = csc_matrix((hessian.values.ravel(), (rows, columns)), shape=(n_dofs, n_dofs))
    return np.asarray((lower + tril(lower, -1).T).toarray())


def taylor_order(remainder: Callable[[float], float], size: float, step: float) -> float:
    """Return the order at which a Taylor remainder falls with the step; inf where it is round-off.

    It is taken over the smallest steps well above round-off: there an error in a derivative shows as order 1.
    Round-off is what remains over much shorter steps, and relative to size, that of the quantity itself.
    """
    lengths = step * STEPS
    found = np.array([abs(remainder(h)) for h in lengths])
    if found.max() <= 1e-12 * size:
        return np.inf
    noise = max(abs(remainder(h)) for h in step * SHORTEST)
    _hold(noise <= ROUND_OFF * size, f"it jumps by {noise:g} of {size:g}, or differs when it is asked twice")
    seen = found > max(1e-11 * size, 30.0 * noise)
    _hold(seen.sum() >= 3, f"too few remainders above round-off: {found} of {size:g}; use a larger step")
    return float(np.polyfit(np.log(lengths[seen][-3:]), np.log(found[seen][-3:]), 1)[0])


def check_derivatives(
    potential: Potential, x: Array, step: float, *, directions: int = 2, seed: int = 0
) -> None:
    """Check the gradient against the energy and the Hessian against the gradient.

    x: admissible displacement, (2 n_nodes,).  step: largest change tried, m, small enough to stay admissible.
    """
    random, here = np.random.default_rng(seed), _evaluated(potential, x)
    gradient = here.gradient()[0]
    H = dense(here.hessian(0.0), len(x)) if here.has_hessian else None
    for _ in range(directions):
        d = random.standard_normal(len(x))
        bend = np.zeros_like(d) if H is None else H @ d

        def of_energy(h: float, d: Array = d) -> float:
            return _evaluated(potential, x + h * d).energy - here.energy - h * float(gradient @ d)

        def of_gradient(h: float, d: Array = d, bend: Array = bend) -> float:
            there = _evaluated(potential, x + h * d).gradient()[0]
            return float(np.linalg.norm(there - gradient - h * bend))

        size = abs(here.energy) + step * float(np.linalg.norm(gradient) * np.linalg.norm(d))
        order = taylor_order(of_energy, size, step)
        _hold(order > ORDER, f"the gradient is not that of the energy: the remainder has order {order:.2f}")
        size = float(np.linalg.norm(gradient)) + step * float(np.linalg.norm(bend))
        order = taylor_order(of_gradient, size, step)
        _hold(order > ORDER, f"the Hessian is not that of the energy: the remainder has order {order:.2f}")


def check_balanced(body: Body, x: Array, gradient: Array, *, moment: bool = True) -> None:
    """Check that nodal forces have no resultant, and no moment about the deformed body's centre."""
    forces = gradient.reshape(-1, 2)
    size = np.abs(forces).sum()
    _hold(size > 0, "there is no force to examine")
    _hold(np.abs(forces.sum(0)).max() < 1e-13 * size, f"the forces have the resultant {forces.sum(0)}")
    if moment:
        at = body.nodes.T + x.reshape(-1, 2)
        at = at - at.mean(0)
        turning = at[:, 0] * forces[:, 1] - at[:, 1] * forces[:, 0]
        _hold(abs(turning.sum()) < 1e-13 * np.abs(turning).sum(), f"the moment is {turning.sum():g}")


def check_objective(body: Body, potential: Potential, x: Array) -> None:
    """Check that turning and moving the deformed body keeps the energy and turns the forces with it."""
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    at = body.nodes.T + x.reshape(-1, 2)
    turned = (at @ turn.T + np.array([0.3, -0.2]) * body.length - body.nodes.T).ravel()
    here, there = _evaluated(potential, x), _evaluated(potential, turned)
    _hold(abs(there.energy - here.energy) < 1e-12 * abs(here.energy), "a rigid motion changes the energy")
    forces = here.gradient()[0].reshape(-1, 2) @ turn.T
    difference = np.abs(there.gradient()[0].reshape(-1, 2) - forces).max()
    _hold(difference < 1e-11 * np.abs(forces).max(), "the forces do not turn with the body")


def check_semidefinite(potential: Potential, x: Array) -> tuple[float, float]:
    """Check that full convexity leaves no negative eigenvalue; return the lowest one without and with it."""
    here = _evaluated(potential, x)
    true, convex = (np.linalg.eigvalsh(dense(here.hessian(c), len(x))) for c in (0.0, 1.0))
    _hold(convex[0] > -1e-11 * convex[-1], f"an eigenvalue is {convex[0]:g} though convexity is 1")
    return float(true[0]), float(convex[0])


def check_term(
    term: Term, body: Body, state: State, samples: Sequence[Array], *, step: float, dt: float = 0.1,
    balanced: bool = True, moment: bool = True, objective: bool = True, other: Term | None = None,
) -> None:  # fmt: skip
    """Examine a term at several admissible displacements, each (2 n_nodes,).

    Derivatives of order 2; forces without resultant (`balanced`) and `moment`; the same energy after a rigid
    motion (`objective`); a step bound in (0, 1] that is admissible; fields left behind that are declared; the
    same numbers when asked twice; and another energy, gradient and Hessian for `other`, the term with another
    parameter.
    """
    for x in samples:
        potential = _potential(term, body, state, dt)
        check_derivatives(potential, x, step)
        here = _evaluated(potential, x)
        gradient = here.gradient()[0]
        _hold(gradient.shape == x.shape, f"the gradient has shape {gradient.shape}, not {x.shape}")
        if balanced:
            check_balanced(body, x, gradient, moment=moment)
        if objective:
            check_objective(body, potential, x)
        again = _evaluated(_potential(term, body, state, dt), x)
        same = again.energy == here.energy and np.array_equal(again.gradient()[0], gradient)
        _hold(same, "asked twice, it gives other numbers")
        far = np.random.default_rng(5).standard_normal(len(x)) * body.length
        bound = here.largest_step(far)
        _hold(0 < bound <= 1, f"largest_step returned {bound}, which is not in (0, 1]")
        _hold(potential.evaluate(x + bound * far) is not None, "the largest step is not admissible")
        left = set(here.finish(frozenset(term.writes)))
        _hold(left <= set(term.writes), f"it leaves {left}, and declares {set(term.writes)}")
        if other is not None:
            _check_other(here, _evaluated(_potential(other, body, state, dt), x), len(x))


def check_parameters(
    scene: Scene, x: Array, *, step: float, names: Sequence[str] = (), time: float | None = None
) -> tuple[str, ...]:
    """Examine how energy and forces of a scene change with parameters of its parts; return their names.

    What sensitivities rest on: E(x, p) changes smoothly with p, and ∂/∂x (∂E/∂p) = ∂g/∂p, g = ∂E/∂x.
    x: an admissible displacement in which all parts act, (2 n_nodes,).  step: largest change of it tried, m.
    names: of the parameters, such as "Springs.stiffness"; else all numbers of the parts that change a force.
    time: of the scene, else its end.
    """
    problem, end = Problem(scene), scene.until if time is None else time
    state = problem.processed(problem.start(), end).updated(displacement=x.reshape(-1, 2).T)
    random, over = np.random.default_rng(0), TimeStep(end, over=True)
    known, at = tuple(names) or numbers_of(scene), configuration(problem.potentials(state, over), x)
    if at is None:
        raise AssertionError("the energy is infinite at the displacement to be examined; use a smaller one")
    found = []
    for name in known:
        here = change(problem, state, x, name, over)
        if not here.gradient.any() and not names:  # such as how fast a load comes that is there
            continue
        _hold(bool(here.gradient.any()), f"{name} changes no force; choose x so that its part acts")
        _hold(here.error < SMOOTH, f"{name} does not act smoothly: ∂g/∂p is known to {here.error:.1g} only")
        d = random.standard_normal(len(x))

        def remainder(h: float, name: str = name, here: Change = here, d: Array = d) -> float:
            there = change(problem, state, x + h * d, name, over)
            return there.energy - here.energy - h * float(here.gradient @ d)

        size = abs(here.energy) + step * float(np.linalg.norm(here.gradient) * np.linalg.norm(d))
        # differences of the energy are rounded to it
        size += abs(at.energy / (number_of(scene, name) or 1.0))
        order = taylor_order(remainder, size, step)
        _hold(order > ORDER, f"{name} changes forces otherwise than the energy: the order is {order:.1f}")
        found.append(name)
    _hold(bool(found), "no part has a number that changes a force; give one a parameter with a decimal point")
    return tuple(found)


def check_process(process: Process, body: Body, state: State, dt: float, *, seed: int = 0) -> State:
    """Examine a process: it writes what it declares, the same twice, and touches nothing; return the end.

    state: the fields that it reads and those of its `optional` ones to be used.
    """
    kept = {name: values.copy() for name, values in state.fields.items()}
    missing = set(process.reads) - set(kept)
    _hold(not missing, f"state lacks {missing}, which the process reads")
    first = process.on(body).start(state, seed)
    _hold(set(first) == set(process.writes), f"start made {set(first)}, and declares {set(process.writes)}")
    before = state.updated(**first)
    held = {name: values.copy() for name, values in first.items()}
    now = state.updated(before.time + dt)
    found, repeated = (process.on(body).advance(before, now, dt) for _ in range(2))
    _hold(set(found) <= set(process.writes), f"advance made {set(found)}, not all of it declared")
    for name, values in found.items():
        _hold(bool(np.isfinite(values).all()), f"{name} is not finite")
        _hold(values.shape == first[name].shape, f"{name} changes its shape to {values.shape}")
        _hold(np.array_equal(values, repeated[name]), f"{name} differs when it is made twice")
    for given, copies in ((first, held), (state.fields, kept)):
        for name, values in copies.items():
            _hold(np.array_equal(given[name], values), f"{name} was changed in place")
    return before.updated(now.time, **found)


def check_kinetics(kinetics: Kinetics, u: Array, v: Array, *, tolerance: float = 1e-7) -> None:
    """Check the derivatives of kinetics against differences, and that their steady states are steady.

    u, v: concentrations to examine, of one shape.  tolerance: relative, of the central differences.
    """
    given = kinetics.derivatives(u, v)
    h, k = 6e-6 * (1 + np.abs(u)), 6e-6 * (1 + np.abs(v))
    rates = kinetics.rates
    by_u = [(a - b) / (2 * h) for a, b in zip(rates(u + h, v), rates(u - h, v), strict=True)]
    by_v = [(a - b) / (2 * k) for a, b in zip(rates(u, v + k), rates(u, v - k), strict=True)]
    expected = (by_u[0], by_v[0], by_u[1], by_v[1])
    scale = max(float(np.abs(value).max()) for value in expected)
    for name, mine, theirs in zip(("∂p/∂u", "∂p/∂v", "∂q/∂u", "∂q/∂v"), given, expected, strict=True):
        error = float(np.abs(mine - theirs).max())
        _hold(error <= tolerance * scale, f"{name} is off by {error:g}, where derivatives reach {scale:g}")
    for state in kinetics.steady_states():
        p, q = kinetics.rates(np.array([state[0]]), np.array([state[1]]))
        at = 1e-9 * float(np.abs(kinetics.jacobian(state)).max()) * (1 + abs(state[0]) + abs(state[1]))
        _hold(abs(p[0]) <= at and abs(q[0]) <= at, f"at ({state[0]:g}, {state[1]:g}) the rates do not vanish")


def advanced(process: Process, body: Body, before: State, dt: float) -> dict[str, Array]:
    """Return the fields that a process, alone in its scene, makes dt after a state."""
    fields = {name: values for name, values in before.fields.items() if name not in process.writes}
    return process.on(body).advance(before, State(before.time + dt, fields), dt)


def _check_other(here: Evaluation, changed: Evaluation, n_dofs: int) -> None:
    """Check that a term with another parameter is another one."""
    _hold(changed.energy != here.energy, "another parameter does not change the energy")
    alike = np.allclose(changed.gradient()[0], here.gradient()[0], rtol=1e-6, atol=0.0)
    _hold(not alike, "another parameter does not change the gradient")
    if here.has_hessian:
        one, two = (dense(e.hessian(0.0), n_dofs) for e in (here, changed))
        _hold(not np.allclose(two, one, rtol=1e-6, atol=0.0), "another parameter does not change the Hessian")


def _potential(term: Term, body: Body, state: State, dt: float) -> Potential:
    potential = term.on(body).during(state, TimeStep(dt))
    if potential is None:
        raise AssertionError(f"{type(term).__name__} does nothing in this state; give one in which it acts")
    return potential


def _evaluated(potential: Potential, x: Array) -> Evaluation:
    at = potential.evaluate(x)
    if at is None:
        raise AssertionError("the energy is infinite at a displacement to be examined; use smaller ones")
    return at


def _hold(right: bool | np.bool_, message: str) -> None:
    if not right:
        raise AssertionError(message)
