"""Elasticity of the grown body: derivatives, objectivity, stress-free growth, projection, stresses."""

import numpy as np
import pytest
from checks import message_names
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import MeshTri1

from turingfold.geometry.body import Body
from turingfold.geometry.shapes import semicircle
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import TimeStep
from turingfold.state import State
from turingfold.terms.elastic.kinematics import first_loss
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import advanced, check_derivatives, check_semidefinite, check_term

STEP = TimeStep(0.1)
GRAY, WHITE = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
TWO_LAYERS = Elastic(gray=GRAY, white=WHITE)


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=0.0404, thickness=0.012, size=0.012, base="free")


def square(**options):
    """Return the unit square with the top as pial surface and the upper half as cortex, skewed inside."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, 4), np.linspace(0, 1, 5))
    p = mesh.p.copy()
    inside = (p[0] > 0) & (p[0] < 1) & (p[1] > 0) & (p[1] < 1)
    p[:, inside] += 0.25 / 4 * np.random.default_rng(1).uniform(-1, 1, (2, inside.sum()))
    mesh = MeshTri1(p, mesh.t).with_boundaries({"pial": lambda x: x[1] == 1, "base": lambda x: x[1] == 0})
    return Body(mesh, 0.5, **options)


def grown(body, t, **options):
    """Return the state at time t of linear tangential growth."""
    state = State(0.0, {"displacement": np.zeros_like(body.nodes)})
    process = TangentialGrowth(**options)
    return state.updated(time=t, **advanced(process, body, state, t))


def admissible(body, potential, share, seeds=(0, 1, 2)):
    """Return random displacements, as large as `share` of what would turn an element inside out."""
    found = []
    for seed in seeds:
        d = np.random.default_rng(seed).standard_normal(2 * body.nodes.shape[1]) * body.length
        found.append(share * potential.evaluate(np.zeros_like(d)).largest_step(d) * d)
    return found


def test_elastic_passes_the_examination(body):
    state = grown(body, 1.0, cortex=1.6, core=1.1, radial_core=1.2, out_of_plane="tangential")
    potential = TWO_LAYERS.on(body).during(state, STEP)
    samples = admissible(body, potential, 0.5, (0, 1))
    softer = Elastic(gray=NeoHookean(mu=0.7 * GRAY.mu, kappa=GRAY.kappa), white=WHITE)
    check_term(TWO_LAYERS, body, state, samples, step=2e-5, other=softer)


@pytest.mark.parametrize("name", ["mu", "kappa"])
@pytest.mark.parametrize("layer", ["gray", "white"])
def test_each_modulus_of_each_layer_matters(body, layer, name):
    state = grown(body, 1.0, cortex=1.3)
    materials = {"gray": GRAY, "white": WHITE}
    old = materials[layer]
    materials[layer] = NeoHookean(**{"mu": old.mu, "kappa": old.kappa, name: 1.5 * getattr(old, name)})
    x = admissible(body, TWO_LAYERS.on(body).during(state, STEP), 0.3, (0,))[0]
    terms = TWO_LAYERS, Elastic(**materials)
    here, there = (term.on(body).during(state, STEP).evaluate(x) for term in terms)
    assert there.energy > 1.001 * here.energy
    forces, others = here.gradient()[0], there.gradient()[0]
    assert np.linalg.norm(others - forces) > 1e-3 * np.linalg.norm(forces)
    assert np.abs(there.hessian(0.0).values - here.hessian(0.0).values).max() > 1e-3 * GRAY.mu


@pytest.mark.parametrize(
    "growth",
    [
        {"cortex": 1.5},
        {"core": 1.2},
        {"radial_core": 1.2},
        {"swelling_core": 1.1},
        {"cortex": 1.5, "out_of_plane": "tangential"},
    ],
)
def test_derivatives_with_each_kind_of_growth(body, growth):
    none = State(0.0, {"displacement": np.zeros_like(body.nodes)})
    options = {"cortex": 1.0, **growth}
    state = grown(body, 1.0, **options)
    operator = TWO_LAYERS.on(body)
    potential = operator.during(state, STEP)
    x = admissible(body, potential, 0.4, (0,))[0]
    check_derivatives(potential, x, 2e-5, directions=1)
    assert potential.evaluate(x).energy != operator.during(none, STEP).evaluate(x).energy


def test_energy_is_the_integral_of_the_law(body):
    # recomputed point by point with 3x3 matrices: G from t⊗t and n⊗n, J_G ψ(F G⁻¹)
    state = grown(body, 1.0, cortex=1.6, core=1.1, radial_core=1.2, out_of_plane="tangential")
    potential = TWO_LAYERS.on(body).during(state, STEP)
    x = admissible(body, potential, 0.5, (3,))[0]
    q, u = body.quadrature, x.reshape(-1, 2).T
    mu, kappa = TWO_LAYERS.moduli(body)
    at_nodes = (body.nodes + u)[:, body.triangles]
    H = np.einsum("iae,amq->imqe", at_nodes, q.derivatives)
    inplane = np.einsum("imqe,mkqe->qeik", H, q.inverse)
    F = np.zeros((*q.weights.shape, 3, 3))
    F[..., :2, :2], F[..., 2, 2] = inplane, 1.0
    tx, ty = body.tangent
    zero, one = np.zeros_like(tx), np.ones_like(tx)
    t, n, z = (np.stack(v, axis=-1) for v in ((tx, ty, zero), (-ty, tx, zero), (zero, zero, one)))
    G = sum(
        g[..., None, None] * v[..., :, None] * v[..., None, :]
        for g, v in zip(state["growth"], (t, n, z), strict=True)
    )
    E = F @ np.linalg.inv(G)
    J, I1 = np.linalg.det(E), (E**2).sum((-1, -2))
    psi = 0.5 * mu * (I1 * J ** (-2 / 3) - 3) + 0.5 * kappa * (J - 1) ** 2
    expected = (np.linalg.det(G) * psi * q.weights).sum()
    assert potential.evaluate(x).energy == pytest.approx(expected, rel=1e-12)
    observed = potential.evaluate(x).observe()
    np.testing.assert_allclose(observed["jacobian"], J, rtol=1e-12)
    # Cauchy stress of the compressible law, and its invariants
    b = E @ np.swapaxes(E, -1, -2)
    deviator = b - I1[..., None, None] / 3 * np.eye(3)
    shear = (mu * J ** (-5 / 3))[..., None, None] * deviator
    sigma = shear + (kappa * (J - 1))[..., None, None] * np.eye(3)
    given = potential.evaluate(x).finish(frozenset({"cauchy_stress"}))["cauchy_stress"]
    for component, (i, j) in zip(given, ((0, 0), (1, 1), (0, 1), (2, 2)), strict=True):
        np.testing.assert_allclose(component, sigma[..., i, j], atol=1e-11 * np.abs(sigma).max())
    shown = [observed[f"stress_{name}"] for name in ("xx", "yy", "xy", "zz")]
    np.testing.assert_array_equal(shown, given)
    assert potential.evaluate(x).finish(frozenset()) == {}
    pressure = -np.trace(sigma, axis1=-2, axis2=-1) / 3
    np.testing.assert_allclose(observed["pressure"], pressure, atol=1e-9 * GRAY.kappa)
    np.testing.assert_allclose(observed["von_mises"], np.sqrt(1.5 * (shear**2).sum((-1, -2))), rtol=1e-9)


def test_without_growth_and_displacement_nothing_is_stressed(body):
    state = State(0.0, {"displacement": np.zeros_like(body.nodes)})
    potential = TWO_LAYERS.on(body).during(state, STEP)
    here = potential.evaluate(np.zeros(2 * body.nodes.shape[1]))
    forces, scale = here.gradient()
    assert abs(here.energy) < 1e-13 * GRAY.mu * 0.0404**2
    assert np.linalg.norm(forces) < 1e-13 * np.sqrt(scale)
    assert here.observe()["von_mises"].max() < 1e-12 * GRAY.mu


def test_growth_that_fits_is_free_of_stress():
    # under a flat surface t is everywhere the same, so x = G X is compatible
    body = square()
    growth = np.ones((3, *body.quadrature.weights.shape)) * np.array([1.5, 0.8, 1.0])[:, None, None]
    state = State(0.0, {"displacement": np.zeros_like(body.nodes), "growth": growth})
    x = (np.array([[0.5], [-0.2]]) * body.nodes).T.ravel()
    here = TWO_LAYERS.on(body).during(state, STEP).evaluate(x)
    forces, scale = here.gradient()
    assert abs(here.energy) < 1e-13 * GRAY.mu
    assert np.linalg.norm(forces) < 1e-13 * np.sqrt(scale)


def test_swelling_in_all_directions_presses_against_the_fixed_depth(body):
    # x = 1.4 X leaves F* = diag(1, 1, 1/1.4): J* = 1/1.4 and pressure κ (1 - J*)
    growth = np.full((3, *body.quadrature.weights.shape), 1.4)
    state = State(0.0, {"displacement": np.zeros_like(body.nodes), "growth": growth})
    found = Elastic(gray=GRAY).on(body).during(state, STEP)
    found = found.evaluate((0.4 * body.nodes).T.ravel()).observe()
    np.testing.assert_allclose(found["jacobian"], 1 / 1.4, rtol=1e-12)
    np.testing.assert_allclose(found["pressure"], GRAY.kappa * (1 - 1 / 1.4), rtol=1e-11)


def test_projection_makes_an_indefinite_tangent_semidefinite():
    body = semicircle(radius=1.0, thickness=0.4, size=0.4, base="free")
    state = grown(body, 1.0, cortex=2.5)
    potential = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)).on(body).during(state, STEP)
    for x in admissible(body, potential, 0.9):
        true, convex = check_semidefinite(potential, x)
        assert true < -1e-3  # there was something to take away
        assert convex > true


def test_partial_convexity_takes_away_that_share():
    body = square()
    state = grown(body, 1.0, cortex=2.5)
    potential = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)).on(body).during(state, STEP)
    here = potential.evaluate(admissible(body, potential, 0.8, (0,))[0])
    none, some, full = (here.hessian(c).values for c in (0.0, 0.3, 1.0))
    assert np.abs(full - none).max() > 1e-3
    np.testing.assert_allclose(some, none + 0.3 * (full - none), atol=1e-12 * np.abs(none).max())


def test_a_field_multiplies_the_moduli(body):
    state = grown(body, 1.0, cortex=1.4)
    factor = np.linspace(0.5, 2.0, body.quadrature.weights.size).reshape(body.quadrature.weights.shape)
    operator = TWO_LAYERS.on(body)
    stiff = operator.during(state.updated(modulus_factor=factor), STEP)
    x = admissible(body, stiff, 0.4, (0,))[0]
    check_derivatives(stiff, x, 2e-5, directions=1)
    twice = operator.during(state.updated(modulus_factor=np.full_like(factor, 2.0)), STEP).evaluate(x)
    once = operator.during(state, STEP).evaluate(x)
    assert twice.energy == pytest.approx(2 * once.energy, rel=1e-13)
    np.testing.assert_allclose(twice.gradient()[0], 2 * once.gradient()[0], atol=1e-12 * GRAY.mu)
    assert stiff.evaluate(x).energy != once.energy


@pytest.mark.parametrize("element", ["quadratic", "mixed"])
@pytest.mark.parametrize(
    ("name", "shape"),
    [("growth", (3,)), ("growth", (3, 1, 1)), ("modulus_factor", ()), ("modulus_factor", (1, 1))],
)
def test_fields_of_another_shape_are_refused(body, element, name, shape):
    operator = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0), element=element).on(body)
    points = ", ".join(map(str, body.quadrature.weights.shape))
    wanted = f"(3, {points})" if name == "growth" else f"({points})"
    with pytest.raises(ValueError, match=f"the field '{name}' has shape") as caught:
        operator.during(State(0.0, {name: np.ones(shape)}), STEP)
    message_names(caught.value, str(shape), wanted)


def test_sigmoid_layers_blend_the_moduli():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1, layers="sigmoid")
    gray, white = NeoHookean(mu=1.0, kappa=5.0), NeoHookean(mu=3.0, kappa=7.0)
    mu, kappa = Elastic(gray=gray, white=white).moduli(body)
    share = 1 / (1 + np.exp(10 * (body.depth / 0.2 - 1)))
    np.testing.assert_allclose(mu, 3 - 2 * share, rtol=1e-13)
    np.testing.assert_allclose(kappa, 7 - 2 * share, rtol=1e-13)


def test_an_inverted_element_is_not_admissible():
    body = square()
    potential = Elastic(gray=GRAY).on(body).during(State(0.0), STEP)
    mirrored = (np.array([[-2.0], [0.0]]) * body.nodes).T.ravel()
    assert potential.evaluate(mirrored) is None
    assert potential.evaluate(np.full(mirrored.shape, np.nan)) is None


@pytest.mark.parametrize("element", ["quadratic", "mixed"])
def test_a_triangle_that_turns_over_at_a_corner_only_is_no_body(element):
    # where the middle of a side lies at less than a quarter of it, x' = 4 x_m - 3 x_0 - x_1 turns round
    body = square()
    potential = Elastic(gray=GRAY, element=element).on(body).during(State(0.0), STEP)
    side = body.pial[:3]
    start, middle, end = body.nodes[:, side].T
    ends = {}
    for share in (0.26, 0.24):
        shift = np.zeros_like(body.nodes)
        shift[:, side[1]] = start + share * (end - start) - middle
        ends[share] = potential.evaluate(shift.T.ravel())
    assert ends[0.26].is_valid()
    if element == "mixed":  # its energy sees the corners
        assert ends[0.24] is None
    else:
        assert not ends[0.24].is_valid()


@settings(derandomize=True, max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), size=st.floats(0.01, 100.0))
def test_the_step_bound_is_admissible_and_not_timid(seed, size):
    body = square()
    potential = Elastic(gray=GRAY).on(body).during(State(0.0), STEP)
    d = size * np.random.default_rng(seed).standard_normal(2 * body.nodes.shape[1])
    bound = potential.evaluate(np.zeros_like(d)).largest_step(d)
    assert potential.evaluate(bound * d).J.min() > 0.0999
    if bound < 1:  # at the bound one point has lost nine tenths
        assert potential.evaluate(bound * d).J.min() == pytest.approx(0.1, rel=1e-6)


@settings(derandomize=True, max_examples=60, deadline=None)
@given(c=st.floats(0.01, 10.0), l=st.floats(-50.0, 50.0), q=st.floats(-50.0, 50.0))
def test_first_loss_is_the_first_root(c, l, q):
    found = first_loss(np.array([c]), np.array([l]), np.array([q]))
    s = np.linspace(0.0, 1.0, 2001)
    values = c + l * s + q * s**2
    sure = 1e-9 * (c + abs(l) + abs(q))
    below = s[values < -sure]
    if below.size:
        assert found <= below[0]
    assert (values[s < found * (1 - 1e-9)] > -sure).all()
    if found < 1:
        assert abs(c + l * found + q * found**2) <= sure


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="gray") as failure:
        Elastic(gray=1389.0)
    message_names(failure.value, "NeoHookean")
    with pytest.raises(ValueError, match="white"):
        Elastic(gray=GRAY, white="stiff")
    with pytest.raises(TypeError):
        Elastic(grey=GRAY)
