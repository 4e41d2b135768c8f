"""Examinations that every term and every process passes, and small parts that tests share."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_matrix, tril

from turingfold.geometry.body import Body
from turingfold.parts import Process
from turingfold.state import State

STEPS = 2.0 ** -np.arange(0.0, 15.0, 2.0)


def dense(hessian, n_dofs: int) -> np.ndarray:
    """Return a Hessian's lower-triangle entries as the full symmetric matrix."""
    places = hessian.rows.ravel(), hessian.columns.ravel()
    assert (places[0] >= places[1]).all(), "an entry lies above the diagonal"
    lower = csc_matrix((hessian.values.ravel(), places), shape=(n_dofs, n_dofs))
    return (lower + tril(lower, -1).T).toarray()


def taylor_order(remainder: Callable[[float], float], size: float, step: float) -> float:
    """Return the order at which a Taylor remainder falls with the step; inf where it is round-off.

    It is taken over the smallest steps above round-off: there, an error in a derivative shows as order 1.
    """
    lengths = step * STEPS
    found = np.array([abs(remainder(h)) for h in lengths])
    if found.max() <= 1e-12 * size:
        return np.inf
    seen = found > 1e-11 * size
    assert seen.sum() >= 3, f"too few remainders above round-off: {found} of {size:g}"
    return float(np.polyfit(np.log(lengths[seen][-3:]), np.log(found[seen][-3:]), 1)[0])


def check_derivatives(potential, x: np.ndarray, step: float, *, directions: int = 2, seed: int = 0) -> None:
    """Check gradient against energy and Hessian against gradient: remainders fall with order 2.

    step: largest displacement tried, m, small enough to stay admissible and to see the next order.
    """
    rng = np.random.default_rng(seed)
    here = potential.evaluate(x)
    slope = here.gradient()[0]
    H = dense(here.hessian(0.0), len(x)) if here.curved else np.zeros((1, 1))
    for _ in range(directions):
        d = rng.standard_normal(len(x))
        bend = H @ d if here.curved else np.zeros_like(d)

        def of_energy(h: float, d: np.ndarray = d) -> float:
            return potential.evaluate(x + h * d).energy - here.energy - h * float(slope @ d)

        def of_slope(h: float, d: np.ndarray = d, bend: np.ndarray = bend) -> float:
            return float(np.linalg.norm(potential.evaluate(x + h * d).gradient()[0] - slope - h * bend))

        size = abs(here.energy) + step * float(np.linalg.norm(slope) * np.linalg.norm(d))
        assert taylor_order(of_energy, size, step) > 1.9
        size = float(np.linalg.norm(slope)) + step * float(np.linalg.norm(bend))
        assert taylor_order(of_slope, size, step) > 1.9


def check_balanced(body: Body, x: np.ndarray, gradient: np.ndarray, *, moment: bool = True) -> None:
    """Check that nodal forces have no resultant, and no moment about the deformed body's centre."""
    forces = gradient.reshape(-1, 2)
    assert np.abs(forces).max() > 0, "no force to examine"
    size = np.abs(forces).sum()
    assert np.abs(forces.sum(0)).max() < 1e-13 * size
    if moment:
        at = body.nodes.T + x.reshape(-1, 2)
        at = at - at.mean(0)
        turning = at[:, 0] * forces[:, 1] - at[:, 1] * forces[:, 0]
        assert abs(turning.sum()) < 1e-13 * np.abs(turning).sum()


def check_objective(body: Body, potential, x: np.ndarray) -> None:
    """Check that turning and moving the deformed body keeps the energy and turns the forces with it."""
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    at = body.nodes.T + x.reshape(-1, 2)
    turned = (at @ turn.T + np.array([0.3, -0.2]) * body.length - body.nodes.T).ravel()
    here, there = potential.evaluate(x), potential.evaluate(turned)
    assert abs(there.energy - here.energy) < 1e-12 * abs(here.energy)
    forces = here.gradient()[0].reshape(-1, 2) @ turn.T
    difference = there.gradient()[0].reshape(-1, 2) - forces
    assert np.abs(difference).max() < 1e-11 * np.abs(forces).max()


def check_semidefinite(potential, x: np.ndarray) -> tuple[float, float]:
    """Check that full convexity leaves no negative eigenvalue; return the lowest one without and with it."""
    here = potential.evaluate(x)
    true, convex = (np.linalg.eigvalsh(dense(here.hessian(c), len(x))) for c in (0.0, 1.0))
    assert convex[0] > -1e-11 * convex[-1]
    return float(true[0]), float(convex[0])


def check_term(
    term, body: Body, state: State, samples: list[np.ndarray], *, step: float, dt: float = 0.1,
    balanced: bool = True, moment: bool = True, objective: bool = True, other=None
) -> None:
    """Examine a term at several admissible displacements, each (2 n_nodes,).

    Derivatives of order 2; forces without resultant (balanced) and moment; the same energy after a rigid
    motion (objective); a step bound in (0, 1] that is admissible; the same bytes when asked twice;
    and another energy, gradient and Hessian for `other`, the term with another parameter.
    """
    assert isinstance(term.reads, tuple)
    potential = term.on(body).during(state, dt)
    for x in samples:
        check_derivatives(potential, x, step)
        here = potential.evaluate(x)
        slope = here.gradient()[0]
        assert slope.shape == x.shape
        if balanced:
            check_balanced(body, x, slope, moment=moment)
        if objective:
            check_objective(body, potential, x)
        again = term.on(body).during(state, dt).evaluate(x)
        assert again.energy == here.energy
        assert np.array_equal(again.gradient()[0], slope)
        far = np.random.default_rng(5).standard_normal(len(x)) * body.length
        bound = potential.largest_step(x, far)
        assert 0 < bound <= 1
        assert potential.evaluate(x + bound * far) is not None
        if other is not None:
            changed = other.on(body).during(state, dt).evaluate(x)
            assert changed.energy != here.energy
            assert not np.allclose(changed.gradient()[0], slope, rtol=1e-6, atol=0.0)
            if here.curved:
                one, two = (dense(e.hessian(0.0), len(x)) for e in (here, changed))
                assert not np.allclose(two, one, rtol=1e-6, atol=0.0)


def check_process(process: Process, body: Body, before: State, dt: float, *, seed: int = 0) -> State:
    """Examine a process: it writes what it declares, the same twice, and touches nothing; return the end."""
    assert isinstance(process, Process)
    kept = {name: values.copy() for name, values in before.fields.items()}
    assert set(process.reads) <= set(kept) | {"displacement"}
    first = process.start(body, before, seed)
    assert set(first) == set(process.writes)
    state = before.updated(**first)
    held = {name: values.copy() for name, values in first.items()}
    found = process.advance(body, state, dt)
    assert set(found) <= set(process.writes)
    repeated = process.advance(body, state, dt)
    for name, values in found.items():
        assert np.isfinite(values).all()
        assert values.shape == first[name].shape
        assert np.array_equal(values, repeated[name])
    for name, values in held.items():
        assert np.array_equal(first[name], values), f"{name} was changed in place"
    for name, values in kept.items():
        assert np.array_equal(before[name], values), f"{name} was changed in place"
    return state.updated(before.time + dt, **found)


def message_names(error: BaseException, *words: str) -> None:
    """Check that an error's text is one paragraph that holds all the words."""
    text = str(error)
    assert "\n" not in text
    for word in words:
        assert word in text, f"{word!r} is not in: {text}"
