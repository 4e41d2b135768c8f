"""The barrier against triangles that turn over: what it measures, its derivatives, and its steps."""

import numpy as np
import pytest
from test_creases import STEP, block, moved, state_of

from turingfold.geometry.triangles import folded_over
from turingfold.terms.boundary import boundary_edges
from turingfold.terms.contact import SelfContact
from turingfold.terms.inversion import FLOOR, bounding
from turingfold.terms.pair_barrier import cross
from turingfold.testing import check_term


def barrier(body):
    return SelfContact().on(body).barriers[1]


def dipped(body, by):
    """Return the displacement that lowers the middle of the surface's first edge by a share of its length."""
    u = np.zeros_like(body.nodes)
    u[1, body.pial[1]] = -0.5 * by
    return u.T.ravel()


def test_it_measures_det_f_on_the_boundary():
    """Of x = X + a Y², y = Y + b X Y + c X²: det F = (b Y + 2 c X) (-2 a Y) + (1 + b X) in closed form."""
    body, (a, b, c) = block(), (0.2, -0.3, 0.25)
    x, y = body.nodes
    u = np.stack([a * y**2, b * x * y + c * x**2])
    start, end = body.nodes[:, bounding(body, boundary_edges(body))[:2]].swapaxes(0, 1)
    base = (start[1] == 0.0) & (end[1] == 0.0)  # straight, where Y = 0
    at = start[0] + np.arange(17)[:, None] / 16 * (end[0] - start[0])
    found = barrier(body)
    det = cross(found.directions(moved(body, u.T.ravel()))) / (found.floor / FLOOR)
    assert base.sum() == 4
    np.testing.assert_allclose(det[:, base], (1 + b * at)[:, base], rtol=1e-9)


def test_it_passes_the_examination():
    body, term = block(), SelfContact()
    noise = 1e-3 * np.random.default_rng(0).standard_normal(2 * body.nodes.shape[1])
    x = dipped(body, 0.22) + noise
    assert not folded_over(body.mesh, body.nodes + x.reshape(-1, 2).T).size
    assert term.on(body).during(state_of(body), STEP).evaluate(x).pairs[0].barrier.nodes.shape[0] == 6
    check_term(term, body, state_of(body), [x], step=1e-4, other=SelfContact(stiffness=2.0))


@pytest.mark.parametrize("by", [0.6, 1.0, 3.0])
def test_a_step_ends_before_a_triangle_turns_over(by):
    body, start = block(), np.zeros(2 * block().nodes.shape[1])
    bound = SelfContact().on(body).during(state_of(body), STEP).evaluate(start).largest_step(dipped(body, by))
    assert not folded_over(body.mesh, body.nodes + bound * dipped(body, by).reshape(-1, 2).T).size
    assert folded_over(body.mesh, body.nodes + 1.15 * bound * dipped(body, by).reshape(-1, 2).T).size


def test_no_triangle_is_near_at_rest():
    body = block()
    assert barrier(body).at(moved(body, np.zeros(2 * body.nodes.shape[1]))).empty
