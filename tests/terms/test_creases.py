"""Creases: derivatives, the angle that they see, and steps that neither cross walls nor stop too early."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import MeshTri1

from turingfold.geometry.body import Body
from turingfold.geometry.shapes import semicircle
from turingfold.morphometry.walls import self_intersections
from turingfold.parts import TimeStep
from turingfold.state import State
from turingfold.terms.contact import SelfContact
from turingfold.testing import check_semidefinite, check_term

STEP = TimeStep(0.1)


def block(base="free"):
    """Return a block of 4 by 2 squares of side 0.5, whose pial surface is its upper side y = 1."""
    mesh = MeshTri1.init_tensor(np.linspace(-1, 1, 5), np.linspace(0, 1, 3))
    return Body(mesh.with_boundaries({"pial": lambda p: p[1] == 1, "base": lambda p: p[1] == 0}), 0.2, base)


def state_of(body):
    return State(1.0, {"displacement": np.zeros_like(body.nodes), "stress_scale": np.array(1.0)})


def folded(body, opening, shear=0.0):
    """Return the displacement that folds the pial surface about x = 0 until its walls are this angle apart.

    shear: by which the right wall is longer than the left.
    """
    moved = body.nodes.copy()
    for side in (-1, 1):
        on = (body.nodes[0] * side > 0) & (body.nodes[1] == 1)
        along = np.abs(body.nodes[0, on]) * (1 + shear * (side > 0))
        moved[:, on] = [side * along * np.sin(opening / 2), 1 + along * np.cos(opening / 2)]
    return (moved - body.nodes).T.ravel()


def creases_of(body, **how):
    return SelfContact(**how).on(body).barriers[0]


def moved(body, x):
    return SelfContact().on(body).moved(x)


def pial(body, x):
    return body.nodes[:, body.pial] + x.reshape(-1, 2).T[:, body.pial]


def test_creases_pass_the_examination():
    body, term = block(), SelfContact()
    noise = 2e-3 * np.random.default_rng(0).standard_normal((2, 2 * body.nodes.shape[1]))
    samples = [folded(body, 0.25) + noise[0], folded(body, 0.2, shear=0.3) + noise[1]]
    assert all(term.on(body).during(state_of(body), STEP).evaluate(x).pairs[0].energy > 0 for x in samples)
    check_term(term, body, state_of(body), samples, step=1e-4, other=SelfContact(stiffness=2.0))


def test_the_projected_hessian_has_no_negative_eigenvalue():
    body = block()
    potential = SelfContact().on(body).during(state_of(body), STEP)
    true, _ = check_semidefinite(potential, folded(body, 0.2, shear=0.2))
    assert true < 0


@pytest.mark.parametrize("opening", [3.0, 1.0, 0.5, 0.31])
def test_open_creases_have_no_energy(opening):
    body = block()
    assert creases_of(body).at(moved(body, folded(body, opening))).empty


def test_walls_repel_the_more_the_narrower_and_in_balance():
    body = block()
    potential = SelfContact().on(body).during(state_of(body), STEP)
    angles = (0.29, 0.2, 0.1, 0.01, 1e-4)
    energies = [creases_of(body).at(moved(body, folded(body, angle))).energy for angle in angles]
    assert (np.diff(energies) > 0).all()
    force = potential.evaluate(folded(body, 0.1)).gradient()[0].reshape(-1, 2)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * np.abs(force).max())
    x = body.nodes + folded(body, 0.1).reshape(-1, 2).T
    assert abs(np.sum(x[0] * force[:, 1] - x[1] * force[:, 0])) < 1e-12 * np.abs(force).max()


@pytest.mark.parametrize("opening", [1.2, 0.5, 0.1])
def test_a_step_ends_before_the_walls_meet(opening):
    """Straight walls that turn by a linear step: they are parallel half way."""
    body = block()
    start = folded(body, opening)
    way = folded(body, -opening) - start  # at one half of it, the walls coincide
    share = creases_of(body).largest_step(moved(body, start), moved(body, start + way))
    assert share == pytest.approx(0.45, rel=1e-9)


@pytest.fixture(scope="module")
def walls():
    """A block and its contact, at rest."""
    body = block()
    return body, SelfContact().on(body).during(state_of(body), STEP)


@settings(derandomize=True, max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), opening=st.floats(0.05, 0.6), size=st.floats(0.01, 1.0))
def test_no_step_within_the_bound_makes_neighbouring_edges_cross(walls, seed, opening, size):
    body, contact = walls
    start = folded(body, opening)
    noise = 0.05 * np.random.default_rng(seed).standard_normal(start.size)
    d = size * (folded(body, -opening) - start + noise)
    d[~np.isin(np.arange(start.size) // 2, body.pial)] = 0.0
    bound = contact.evaluate(start).largest_step(d)
    assert 0 < bound <= 1
    for share in (0.3, 0.6, 1.0):
        assert self_intersections(pial(body, start + share * bound * d), closed=False, quadratic=True) == 0


def test_a_gyrus_may_be_sharp():
    """Its outer angle is above three quarters of a turn: no crease, although sin θ is small."""
    body = block()
    start = moved(body, np.zeros(2 * body.nodes.shape[1]))
    sharp = body.nodes.copy()
    on = body.nodes[1] == 1
    sharp[1, on] = 1 - 3 * np.abs(body.nodes[0, on])
    end = moved(body, (sharp - body.nodes).T.ravel())
    assert creases_of(body).largest_step(start, end) == 1.0
    assert creases_of(body).at(end).empty


def test_a_wall_that_folds_onto_the_base_line_stays_above_it():
    body = semicircle(radius=1.0, thickness=0.3, size=0.15, base="roller")
    d = np.zeros_like(body.nodes)
    first = body.pial[1:3] if body.nodes[0, body.pial[0]] > 0 else body.pial[-2:-4:-1]
    d[:, first] = [[0.4, 0.8], [0.0, 0.0]]  # outward, and below the line, which is met half way
    d[1, first] = -2 * body.nodes[1, first]
    share = creases_of(body).largest_step(moved(body, 0 * d.T.ravel()), moved(body, d.T.ravel()))
    assert share == pytest.approx(0.45, rel=1e-3)
    assert creases_of(body, base_line=False).nodes.shape[1] < creases_of(body).nodes.shape[1]
