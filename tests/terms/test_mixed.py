"""The mixed element: derivatives, bubbles, exact states, the incompressible limit, Newton iterations."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from skfem import MeshTri1

from turingfold.geometry.body import Body
from turingfold.geometry.shapes import semicircle
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import Load, Operator, TimeStep
from turingfold.scene import Scene
from turingfold.solve.march import begin, march
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.mixed_points import integration_on
from turingfold.terms.elastic.term import Elastic
from turingfold.terms.line import DeadLoad
from turingfold.testing import advanced, check_derivatives, check_semidefinite, check_term

STEP = TimeStep(0.1)

Mixed = partial(Elastic, element="mixed")
Quadratic = partial(Elastic, element="quadratic")


def material(poisson, mu=1.0):
    return NeoHookean(mu=mu, kappa=2 * mu * (1 + poisson) / (3 * (1 - 2 * poisson)))


def steps(scene):
    return [step for step, _ in march(scene, begin(scene))]


def square(n=3, distort=0.25, base="clamped"):
    """Return the unit square, inner nodes moved; its top is the pial surface, its upper half the cortex."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    p = mesh.p.copy()
    inside = (p > 0).all(0) & (p < 1).all(0)
    p[:, inside] += distort / n * np.random.default_rng(1).uniform(-1, 1, (2, inside.sum()))
    sides = {"pial": lambda x: x[1] == 1, "base": lambda x: x[1] == 0}
    return Body(MeshTri1(p, mesh.t).with_boundaries(sides), 0.5, base)


def stretched(body, F):
    """Return the displacement of the affine deformation F."""
    return ((np.asarray(F) - np.eye(2)) @ body.nodes).T.ravel()


def grown(body, **options):
    state = State(0.0, {"displacement": np.zeros_like(body.nodes)})
    return state.updated(time=1.0, **advanced(TangentialGrowth(**options), body, state, 1.0))


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=0.0404, thickness=0.012, size=0.012, base="free")


def consistent(term, body, state, x):
    """Return the state with the pressures that belong to the displacement x: the tangent is exact there."""
    return state.updated(element_pressure=term.on(body).during(state, STEP).evaluate(x).own_pressure)


def shaken(body, potential, share, seed=0):
    """Return a random displacement, as large as `share` of what would turn an element inside out."""
    d = np.random.default_rng(seed).standard_normal(2 * body.nodes.shape[1]) * body.length
    return share * potential.evaluate(np.zeros_like(d)).largest_step(d) * d


# derivatives


@pytest.mark.parametrize(("poisson", "share", "step"), [(0.4583, 0.3, 2e-5), (0.4999, 0.05, 2e-6)])
def test_it_passes_the_examination(body, poisson, share, step):
    term = Mixed(gray=NeoHookean.from_young(1389.0, poisson), white=NeoHookean.from_young(1895.0, poisson))
    state = grown(body, cortex=1.6, core=1.1, radial_core=1.2, out_of_plane="tangential")
    x = shaken(body, term.on(body).during(state, STEP), share)
    softer = replace(term, gray=NeoHookean(mu=0.7 * term.gray.mu, kappa=term.gray.kappa))
    check_term(term, body, consistent(term, body, state, x), [x], step=step, other=softer)


def test_full_convexity_makes_an_indefinite_tangent_semidefinite(body):
    term, state = Mixed(gray=material(0.4583)), grown(body, cortex=1.6)
    x = shaken(body, term.on(body).during(state, STEP), 0.3)
    potential = term.on(body).during(consistent(term, body, state, x), STEP)
    assert check_semidefinite(potential, x)[0] < -1e-3


def test_the_tangent_is_built_with_the_pressure_that_is_given(body):
    term, state = Mixed(gray=material(0.4999)), grown(body, cortex=1.1)
    x = np.zeros(2 * body.nodes.shape[1])
    none = term.on(body).during(state, STEP).evaluate(x)
    own = term.on(body).during(consistent(term, body, state, x), STEP).evaluate(x)
    assert own.energy == none.energy
    assert np.array_equal(own.gradient()[0], none.gradient()[0])
    assert not np.allclose(own.hessian(0.0).values, none.hessian(0.0).values)


# exact states


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
def test_an_affine_deformation_is_exact_on_a_distorted_mesh(poisson):
    body, m = square(), material(poisson)
    F = np.array([[1.2, 0.3], [-0.1, 0.9]])
    at = Mixed(gray=m).on(body).during(State(0.0, {}), STEP).evaluate(stretched(body, F))
    J, I1 = np.linalg.det(F), (F**2).sum() + 1
    energy = m.mu / 2 * (I1 * J ** (-2 / 3) - 3) + m.kappa / 2 * (J - 1) ** 2
    assert at.energy == pytest.approx(energy, rel=1e-12)
    assert np.abs(at.own_pressure - m.kappa * (J - 1)).max() < 1e-11 * m.kappa
    assert np.abs(at.bubble).max() < 1e-13


def test_what_is_shown_is_what_the_quadratic_element_shows_where_both_are_exact():
    body, F = square(), [[1.2, 0.3], [-0.1, 0.9]]
    state, x = grown(body, cortex=1.3, core=1.3, out_of_plane="tangential"), stretched(body, F)
    mixed, quadratic = (
        kind(gray=material(0.4)).on(body).during(state, STEP).evaluate(x).observe()
        for kind in (Mixed, Quadratic)
    )
    assert set(mixed) == set(quadratic)
    for name, values in quadratic.items():
        assert np.abs(mixed[name] - values).max() < 1e-11 * np.abs(values).max()


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
def test_the_cauchy_stress_is_that_of_the_deformation(poisson):
    """F* = F G⁻¹ of a uniform growth along a flat surface, σ = μ J^{-5/3} dev(F*F*ᵀ) + κ (J - 1) 1."""
    body, m, F = square(), material(poisson), np.array([[1.35, 0.3, 0], [-0.1, 0.95, 0], [0, 0, 1.0]])
    state = grown(body, cortex=1.3, core=1.3, out_of_plane="tangential")
    E = F @ np.diag([1 / 1.3, 1.0, 1 / 1.3])
    b, J = E @ E.T, np.linalg.det(E)
    sigma = m.mu * J ** (-5 / 3) * (b - np.trace(b) / 3 * np.eye(3)) + m.kappa * (J - 1) * np.eye(3)
    for kind in (Mixed, Quadratic):
        at = kind(gray=m).on(body).during(state, STEP).evaluate(stretched(body, F[:2, :2]))
        found = at.finish(frozenset({"cauchy_stress"}))["cauchy_stress"]
        expected = sigma[[0, 1, 0, 2], [0, 1, 1, 2]][:, None, None]
        assert found.shape == (4, *body.quadrature.weights.shape)
        assert np.abs(found - expected).max() < 1e-11 * m.kappa


def test_growth_that_fits_is_free_of_stress():
    body = square(base="free")
    state = grown(body, cortex=1.4, core=1.4)  # along the flat pial surface: x → 1.4 x
    potential = Mixed(gray=material(0.4999)).on(body).during(state, STEP)
    at = potential.evaluate(stretched(body, np.diag([1.4, 1.0])))
    assert abs(at.energy) < 1e-12
    assert np.abs(at.gradient()[0]).max() < 1e-11


# the bubbles


def test_the_bubbles_find_the_same_minimum_from_anywhere(body):
    term, state = Mixed(gray=material(0.4999)), grown(body, cortex=1.3)
    start = term.on(body).during(state, STEP)
    x = shaken(body, start, 0.1)
    here = start.evaluate(x)
    size = np.abs(here.bubble).max()
    assert size > 0
    for seed in (0, 1):
        moved = here.bubble + 0.3 * size * np.random.default_rng(seed).standard_normal(here.bubble.shape)
        there = term.on(body).during(state.updated(bubble=moved), STEP).evaluate(x)
        assert np.abs(there.bubble - here.bubble).max() < 1e-10 * size
        assert there.energy == pytest.approx(here.energy, rel=1e-12)


def test_the_bubbles_lower_the_energy(body):
    state = grown(body, cortex=1.3)
    potential = Mixed(gray=material(0.4999)).on(body).during(state, STEP)
    settled = potential.evaluate(shaken(body, potential, 0.1))
    for seed in (0, 1, 2):
        push = np.random.default_rng(seed).standard_normal(settled.bubble.shape)
        push *= 1e-3 * body.length / np.abs(push).max()
        assert (settled.displaced(push).energies > settled.energies).all()


def test_an_inner_state_that_is_inadmissible_is_not_used(body):
    term, state = Mixed(gray=material(0.4)), grown(body, cortex=1.1)
    x = np.zeros(2 * body.nodes.shape[1])
    fresh = term.on(body).during(state, STEP).evaluate(x)
    far = state.updated(bubble=np.full_like(fresh.bubble, 10 * body.length))
    assert term.on(body).during(far, STEP).evaluate(x).energy == fresh.energy


def test_an_inverted_element_is_not_admissible(body):
    potential = Mixed(gray=material(0.4)).on(body).during(grown(body, cortex=1.1), STEP)
    flipped = stretched(body, np.diag([-1.0, 1.0]))
    for x in (flipped, np.full_like(flipped, np.nan)):
        with np.errstate(invalid="ignore"):
            assert potential.evaluate(x) is None


def test_integration_is_exact_to_order_six_with_positive_weights():
    quadrature = integration_on(square(n=1, distort=0.0)).quadrature
    (x, y), weights = quadrature.points, quadrature.weights
    assert weights.min() > 0
    for i, j in [(i, order - i) for order in range(7) for i in range(order + 1)]:
        assert (weights * x**i * y**j).sum() == pytest.approx(1 / ((i + 1) * (j + 1)), rel=1e-13)


def test_fields_at_the_sides_are_those_of_linear_functions_and_no_others_beyond_their_range():
    body = square(n=1, distort=0.0)
    integration, places = integration_on(body), body.quadrature.points
    linear = np.exp(0.3 * places[0] - 0.2 * places[1])
    there = integration.quadrature.points
    exact = np.exp(0.3 * there[0] - 0.2 * there[1])
    np.testing.assert_allclose(integration.spread_out(linear), exact, rtol=1e-13)
    jumping = np.where(places[0] > 0.4, 1.8, 1.0)  # inside both triangles
    spread, widest = integration.spread_out(jumping), 1.8**0.35
    assert 1 / widest * (1 - 1e-12) <= spread.min() < 1.0
    assert 1.8 < spread.max() <= 1.8 * widest * (1 + 1e-12)


# against the quadratic element, and the incompressible limit


def pushed(kind, n):
    """Return the middle of the top of a unit square that grows, at 0.3 of Poisson's ratio."""
    body = square(n, distort=0.0)
    grow = TangentialGrowth(cortex=1.2)
    stepping = Stepping(first=0.5, largest=0.5)
    scene = Scene(body=body, terms=(kind(gray=material(0.3)),), processes=(grow,), stepping=stepping)
    last = steps(scene)[-1]
    middle = np.flatnonzero((np.abs(body.nodes[0] - 0.5) < 1e-12) & (body.nodes[1] == 1))
    return last.state["displacement"][1, middle[0]]


def test_a_compressible_solid_is_that_of_the_quadratic_element():
    coarse, fine = (abs(pushed(Mixed, n) - pushed(Quadratic, n)) for n in (4, 8))
    assert fine < 2e-4
    assert fine < coarse / 2


@pytest.mark.parametrize(
    ("growth", "outer", "stress"), [(1.1, 1.009455, 0.041747), (1.2, 1.018823, 0.087368)]
)
def test_a_ring_on_a_core_tends_to_the_incompressible_closed_form(growth, outer, stress):
    """Reference: r² = a² + g (R² - A²) with a = A, and the core under T_rr of the ring's inside."""
    body = semicircle(radius=1.0, thickness=0.1, size=0.1 / 3, base="roller")
    grow = TangentialGrowth(cortex=growth)
    scene = Scene(
        body=body,
        terms=(Mixed(gray=material(0.499999)),),
        processes=(grow,),
        stepping=Stepping(first=0.5, largest=0.5),
    )
    last = steps(scene)[-1]
    at = body.nodes + last.state["displacement"]
    assert np.abs(np.hypot(*at[:, body.pial]) - outer).max() < 2e-5
    deep = np.hypot(*body.quadrature.points) < 0.6
    assert np.abs(last.observe()["pressure"][deep] + stress).max() < 2e-2 * stress


@dataclass(frozen=True)
class Shear(Load):
    """A dead vertical traction on the pial side, growing with time; Pa."""

    traction: float

    def on(self, body):
        nodes, forces = body.pial, np.zeros(2 * body.nodes.shape[1])
        length = np.hypot(*(body.nodes[:, nodes[2::2]] - body.nodes[:, nodes[:-2:2]]))
        for share, at in zip((1 / 6, 4 / 6, 1 / 6), (nodes[:-2:2], nodes[1::2], nodes[2::2]), strict=True):
            np.add.at(forces, 2 * at + 1, share * self.traction * length)
        return Loaded(forces)


@dataclass(frozen=True)
class Loaded(Operator):
    forces: np.ndarray

    def during(self, state, step):
        return DeadLoad(state.time * self.forces)


def membrane(n, rounds):
    """Return Cook's membrane, n by n, refined towards its corners; the right side is the pial one."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    x, y = mesh.p
    mesh = MeshTri1(np.stack([48 * x, 44 * x + y * (44 * (1 - x) + 16 * x)]), mesh.t)
    for k in range(rounds):
        centre = mesh.p[:, mesh.t].mean(1)
        corners = ((0, 0), (0, 44), (48, 60), (48, 44))
        near = np.min([np.hypot(centre[0] - a, centre[1] - b) for a, b in corners], axis=0)
        mesh = mesh.refined(np.flatnonzero(near < 12 * 0.5**k))
    sides = {"base": lambda x: x[0] < 1e-9, "pial": lambda x: x[0] > 48 - 1e-9}
    return Body(mesh.with_boundaries(sides), 24.0)


def bent(body, m):
    """Return the rise of the membrane's upper right corner, mm, and the Newton iterations of four steps."""
    scene = Scene(body=body, terms=(Mixed(gray=m), Shear(6.25)), stepping=Stepping(first=0.25, largest=0.25))
    found = steps(scene)
    corner = np.argmin(np.hypot(body.nodes[0] - 48, body.nodes[1] - 60))
    assert len(found) == 4
    return found[-1].state["displacement"][1, corner], sum(s.numbers["newton_iterations"] for s in found)


def test_cooks_membrane_nearly_incompressible():
    rise, iterations = bent(membrane(8, 5), NeoHookean(mu=80.1938, kappa=400889.806))
    assert rise == pytest.approx(6.93, abs=0.01)
    assert iterations <= 20


@pytest.mark.parametrize("poisson", [0.3, 0.4583, 0.49, 0.4999, 0.499999])
def test_newton_takes_no_more_iterations_the_less_compressible_the_solid(poisson):
    assert bent(membrane(4, 0), material(poisson, 80.1938))[1] <= 20


def test_it_does_not_lock():
    """Reference: the compliance of a solid tends to its limit as 1/κ."""
    body = membrane(4, 0)
    rises = [bent(body, NeoHookean(mu=80.1938, kappa=80.1938 * ratio))[0] for ratio in (500.0, 5e3, 5e4)]
    assert rises[0] - rises[1] == pytest.approx(10 * (rises[1] - rises[2]), rel=0.02)


def test_a_march_goes_on_from_its_state_to_the_last_bit(body):
    scene = Scene(
        body=body,
        terms=(Mixed(gray=material(0.4999)),),
        processes=(TangentialGrowth(cortex=1.3),),
        stepping=Stepping(first=0.25, largest=0.25),
    )
    whole = list(march(scene, begin(scene)))
    again = list(march(scene, whole[1][1]))
    assert len(again) == len(whole) - 2
    for (step, _), (other, _) in zip(whole[2:], again, strict=True):
        for name, values in step.state.fields.items():
            assert np.array_equal(values, other.state[name]), name


def test_derivatives_hold_with_moduli_and_growth_of_every_kind(body):
    state = grown(body, cortex=1.4, core=0.9, swelling_core=1.1)
    factor = 1 + 0.3 * np.sin(300 * body.arc)
    term = Mixed(gray=material(0.45))
    plain, varied = term.on(body).during(state, STEP), state.updated(modulus_factor=factor)
    x = shaken(body, plain, 0.3, seed=3)
    potential = term.on(body).during(consistent(term, body, varied, x), STEP)
    check_derivatives(potential, x, 2e-5)
    assert potential.evaluate(x).energy != plain.evaluate(x).energy


CHOICES = [(0.4583, False), (0.4899, False), (0.49, True), (0.4999, True)]


@pytest.mark.parametrize(("poisson", "mixed"), CHOICES)
def test_the_element_is_chosen_by_poissons_ratio(poisson, mixed):
    stiff = material(poisson)
    assert Elastic(gray=stiff).mixed is mixed
    assert Elastic(gray=material(0.3), white=stiff).mixed is mixed
    assert Mixed(gray=stiff).mixed
    assert not Quadratic(gray=stiff).mixed


def test_an_unknown_element_is_refused():
    with pytest.raises(ValueError, match="element='linear' must be one of 'auto', 'quadratic', 'mixed'"):
        Elastic(gray=material(0.3), element="linear")
