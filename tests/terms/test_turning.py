"""No triangle turns over, also away from the boundary: what the barrier measures, and where steps end."""

import numpy as np
import pytest
from test_creases import block, moved, state_of

from turingfold import (
    Drag,
    Elastic,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    semicircle,
    simulate,
)
from turingfold.geometry.triangles import bernstein, folded_over
from turingfold.terms.turning import FLOOR, LEAST, Turning
from turingfold.testing import check_term


def dragged(body, share):
    """Return the displacement that brings the middle of an inner edge to a share of its length.

    On the straight edge ∂x/∂ξ at the start is 4 share - 1 of that at rest, and so is det F there.
    """
    facet = np.setdiff1d(np.arange(body.mesh.nfacets), body.mesh.boundary_facets())[0]
    start, end = body.nodes[:, body.mesh.facets[:, facet]].T
    u = np.zeros_like(body.nodes)
    u[:, body.mesh.nvertices + facet] = (share - 0.5) * (end - start)
    return u.T.ravel()


def barrier(body):
    return next(own for own in SelfContact().on(body).barriers if isinstance(own, Turning))


def at(body, share):
    return barrier(body).at(moved(body, dragged(body, share)))


def test_bernstein_coefficients_give_the_jacobian():
    """Against det ∂x/∂ξ of the shape functions written out, at places of random triangles."""
    random = np.random.default_rng(0)
    triangles = random.standard_normal((2, 6, 5))
    x, y = random.dirichlet(np.ones(3), 7).T[:2]
    z, nil = 1 - x - y, np.zeros_like(x)
    along_x = np.stack([1 - 4 * z, 4 * x - 1, nil, 4 * (z - x), 4 * y, -4 * y])
    along_y = np.stack([1 - 4 * z, nil, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)])
    u, v = (np.einsum("iae,ap->ipe", triangles, slope) for slope in (along_x, along_y))
    basis = np.stack([z * z, x * x, y * y, 2 * z * x, 2 * x * y, 2 * y * z])
    np.testing.assert_allclose(basis.T @ bernstein(triangles), u[0] * v[1] - u[1] * v[0], atol=1e-12)


def test_it_measures_det_f_in_closed_form():
    lowest = at(block(), 0.25 + 0.25 * 0.015).z.min() * (LEAST - FLOOR) + FLOOR
    assert lowest == pytest.approx(0.015, rel=1e-9)


def test_no_triangle_is_near_where_det_f_is_larger():
    assert at(block(), 0.5).empty
    assert at(block(), 0.25 + 0.25 * 1.01 * LEAST).empty


def test_a_way_that_ends_well_is_gone_to_its_end():
    body = block()
    d = np.einsum("ij,jn->in", [[-2.0, 0.0], [0.0, -2.0]], body.nodes).T.ravel()  # half a turn
    assert barrier(body).largest_step(moved(body, 0 * d), moved(body, d)) == 1.0


def test_it_passes_the_examination():
    body, term = block(), SelfContact()
    noise = 2e-5 * np.random.default_rng(0).standard_normal(2 * body.nodes.shape[1])
    x = dragged(body, 0.25 + 0.25 * 0.014) + noise
    assert not barrier(body).at(moved(body, x)).empty
    check_term(term, body, state_of(body), [x], step=1e-5, other=SelfContact(stiffness=2.0))


@pytest.mark.parametrize("share", [0.24, 0.1, -3.0])
def test_a_step_ends_before_a_triangle_turns_over(share):
    body = block()
    d = dragged(body, share)
    bound = barrier(body).largest_step(moved(body, 0 * d), moved(body, d))
    assert not folded_over(body.mesh, body.nodes + bound * d.reshape(-1, 2).T).size
    assert folded_over(body.mesh, body.nodes + 1.03 * bound * d.reshape(-1, 2).T).size


def test_a_stiff_cortex_on_few_elements_turns_no_triangle_over():
    """As cell 64 of the atlas's mechanics: those at both ends of the base turned over inside."""
    body = semicircle(radius=1.0, thickness=0.17, elements=1.5)
    gray, white = NeoHookean.from_young(175.0, 0.48), NeoHookean.from_young(3.0, 0.48)
    terms = (Elastic(gray=gray, white=white), SelfContact(), Drag(coefficient=1.0))
    growth = TangentialGrowth(cortex=2.8244, out_of_plane="tangential")
    result = simulate(Scene(body=body, terms=terms, processes=(growth,), stepping=Stepping()))
    turned = [folded_over(body.mesh, body.nodes + state["displacement"]).size for state in result.states]
    assert result.converged
    assert not any(turned)
