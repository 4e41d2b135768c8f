"""Axonal tension: balance, energy, where and which way it pulls, and its ramp."""

import numpy as np
import pytest
from checks import message_names
from skfem import MeshTri1

from turingfold.errors import MissingFieldError
from turingfold.geometry.body import Body
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle, semiellipse
from turingfold.parts import TimeStep
from turingfold.scene import Scene
from turingfold.state import State
from turingfold.terms.tension import AxonalTension
from turingfold.testing import check_balanced, check_term

STEP = TimeStep(0.1)
RADIUS, T = 1.0, 0.3


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=RADIUS, thickness=T, size=0.15, base="free")


def angle(points):
    return np.arctan2(points[1], points[0])


def patterned(body, function, time=1.0):
    """Return a state whose pattern is a function of the cortex's node positions."""
    pattern = function(body.cortex.mesh.doflocs)
    return State(time, {"displacement": np.zeros_like(body.nodes), "pattern": pattern})


def waves(points):
    return 0.5 * (1.0 + np.cos(4 * angle(points)))


def small(body, seed=1, size=0.03):
    return size * np.random.default_rng(seed).standard_normal(2 * body.nodes.shape[1])


@pytest.mark.parametrize("follower", [False, True])
def test_line_tension_passes_the_examination(body, follower):
    term = AxonalTension(strength=0.5, follower=follower)
    other = AxonalTension(strength=0.7, follower=follower)
    samples = [small(body, 1), small(body, 2)]
    # a dead load keeps its direction, so it turns a body that has been turned
    check_term(
        term,
        body,
        patterned(body, waves),
        samples,
        step=1e-3,
        moment=follower,
        objective=follower,
        other=other,
    )


@pytest.mark.parametrize("direction", ["toward-peaks", "between-peaks"])
def test_pial_loads_pass_the_examination(body, direction):
    term = AxonalTension(strength=0.5, surface="pial", direction=direction)
    other = AxonalTension(strength=0.7, surface="pial", direction=direction)
    check_term(
        term,
        body,
        patterned(body, waves),
        [small(body)],
        step=1e-3,
        balanced=False,
        objective=False,
        other=other,
    )


@pytest.mark.parametrize("follower", [False, True])
@pytest.mark.parametrize("shape", ["disc", "ellipse", "any mesh"])
def test_line_tension_has_no_net_force_or_moment(shape, follower):
    if shape == "any mesh":
        mesh = MeshTri1.init_tensor(np.linspace(0, 1, 6), np.linspace(0, 1, 5))
        p = mesh.p.copy()
        inside = (p[0] > 0) & (p[0] < 1) & (p[1] > 0) & (p[1] < 1)
        p[:, inside] += 0.03 * np.random.default_rng(2).uniform(-1, 1, (2, inside.sum()))
        mesh = MeshTri1(p, mesh.t).with_boundaries({"pial": lambda x: x[1] == 1})
        made = Body(mesh, 0.45, "free")
    elif shape == "ellipse":
        made = semiellipse(width=2.0, height=0.7, thickness=0.15, size=0.15, base="free")
    else:
        made = semicircle(radius=RADIUS, thickness=T, size=0.15, base="free")
    state = patterned(made, lambda p: np.random.default_rng(0).uniform(0, 1, p.shape[1]))
    potential = AxonalTension(strength=2.0, follower=follower).on(made).during(state, STEP)
    at_rest = np.zeros(2 * made.nodes.shape[1])
    check_balanced(made, at_rest, potential.evaluate(at_rest).gradient()[0])


def test_constant_tension_is_the_pressure_of_a_bent_string(body):
    # a string of tension γ on a circle of radius r presses inward with γ/r: per angle with γ
    constant = patterned(body, lambda p: np.ones(p.shape[1]))
    force = -AxonalTension(strength=3.0).on(body).during(constant, STEP).evaluate(small(body)).gradient()[0]
    interface = body.interface[1:-1]  # the two ends carry the end forces γ T
    load = force.reshape(-1, 2)[interface]
    along = body.nodes[:, interface] / np.hypot(*body.nodes[:, interface])
    inward = -np.einsum("ik,ki->k", along, load)
    assert inward.sum() == pytest.approx(3.0 * np.ptp(angle(body.nodes[:, body.interface])), rel=0.06)
    sideways = along[0] * load[:, 1] - along[1] * load[:, 0]
    assert np.abs(sideways).max() < 1e-3 * inward.max()
    ends = force.reshape(-1, 2)[body.interface[[0, -1]]]
    # both ends are pulled along the line into the body, up from the base
    assert (ends[:, 1] > 2.5).all()


def test_dead_line_tension_is_the_follower_at_rest(body):
    state, x = patterned(body, waves), np.zeros(2 * body.nodes.shape[1])
    dead, follower = (
        AxonalTension(strength=1.3, follower=f).on(body).during(state, STEP).evaluate(x).gradient()[0]
        for f in (False, True)
    )
    np.testing.assert_allclose(dead, follower, atol=1e-15)


def test_follower_energy_is_tension_times_length(body):
    # the deformed interface, turned and stretched by 1.2: γ times its length
    state = patterned(body, lambda p: np.ones(p.shape[1]))
    potential = AxonalTension(strength=2.0, follower=True).on(body).during(state, STEP)
    x = (0.2 * body.nodes).T.ravel()
    assert potential.evaluate(x).energy == pytest.approx(2.0 * 1.2 * np.pi * (RADIUS - T), rel=1e-6)


@pytest.mark.parametrize(("direction", "sign"), [("toward-peaks", 1.0), ("between-peaks", -1.0)])
def test_pial_loads_converge_where_they_say(body, direction, sign):
    # û has its peak at the apex: left of it, "toward" is to the right
    term = AxonalTension(strength=2.0, surface="pial", direction=direction)
    state = patterned(body, lambda p: 0.5 * (1 - np.cos(2 * angle(p))))
    force = -term.on(body).during(state, STEP).evaluate(small(body)).gradient()[0].reshape(-1, 2)
    x, y = body.nodes
    left = (x < -0.3) & (x > -0.9)
    assert (sign * force[left & np.isin(np.arange(len(x)), body.pial), 0] > 0).all()
    moment = (x * force[:, 1] - y * force[:, 0])[body.pial]
    # the traction is tangential with |t| = strength |sin 2φ|: ∫ over the left quarter of R² t dφ = strength
    quarter = moment[x[body.pial] < -1e-9].sum()
    assert quarter == pytest.approx(-sign * 2.0 * RADIUS**2, rel=0.02)
    assert abs(moment.sum()) < 1e-12


def test_the_largest_pial_traction_is_the_strength():
    made = semicircle(radius=RADIUS, thickness=T, size=0.05, base="free")
    operator = AxonalTension(strength=2.0, surface="pial").on(made)
    state = patterned(made, lambda p: 0.5 * (1 - np.cos(2 * angle(p))))
    force = operator.during(state, STEP).evaluate(np.zeros(2 * made.nodes.shape[1])).gradient()[0]
    # consistent nodal forces of a smooth traction t: at a vertex t h/3 with h the edge, at a middle 2 t h/3
    load = np.hypot(*force.reshape(-1, 2)[made.pial[1:-1:2]].T)
    edge = np.diff(made.pial_arc[::2])
    assert (load / (2 / 3 * edge)).max() == pytest.approx(2.0, rel=0.01)


def test_tension_rises_along_its_ramp(body):
    term = AxonalTension(strength=1.0, ramp=0.5)
    x = small(body)
    full = term.on(body).during(patterned(body, waves, time=0.5), STEP).evaluate(x).gradient()[0]
    part = term.on(body).during(patterned(body, waves, time=0.1), STEP).evaluate(x).gradient()[0]
    later = term.on(body).during(patterned(body, waves, time=0.9), STEP).evaluate(x).gradient()[0]
    np.testing.assert_allclose(part, 0.2 * full, rtol=1e-13, atol=1e-16)
    assert np.array_equal(later, full)
    assert term.on(body).during(patterned(body, waves, time=0.0), STEP) is None
    assert AxonalTension(strength=0.0).on(body).during(patterned(body, waves), STEP) is None
    at_once = AxonalTension(strength=1.0, ramp=0.0).on(body).during(patterned(body, waves, time=1e-9), STEP)
    assert np.array_equal(at_once.evaluate(x).gradient()[0], full)


def test_patches_are_the_cosine_of_the_arc():
    # 4 patches on the half circle: ½(1 + cos(2π 4 s/L)) = ½(1 + cos 8φ), also below it on the interface;
    # feet differ by the angle of the normal where two quadratic edges meet, δ³/4 for an edge of angle 2δ
    term = AxonalTension(strength=1.0, patches=4)
    assert term.reads == ()
    errors = []
    for size in (0.15, 0.075):
        made = semicircle(radius=RADIUS, thickness=T, size=size, base="free")
        x = np.zeros(2 * made.nodes.shape[1])
        empty = State(1.0, {"displacement": np.zeros_like(made.nodes)})
        cosine = patterned(made, lambda p: 0.5 * (1 + np.cos(8 * angle(p))))
        found = term.on(made).during(empty, STEP).evaluate(x).gradient()[0]
        expected = AxonalTension(strength=1.0).on(made).during(cosine, STEP).evaluate(x).gradient()[0]
        errors.append(np.abs(found - expected).max() / np.abs(expected).max())
    assert errors[1] < 8 * T * (0.075 / 2) ** 3  # slope of the cosine, depth, δ³ < (size/2)³
    assert np.log2(errors[0] / errors[1]) > 2.8


def test_tension_on_half_the_body_is_half_the_tension():
    whole = semicircle(radius=RADIUS, thickness=T, size=0.15, base="free")
    part = half(whole)
    place = {tuple(p): k for k, p in enumerate(whole.nodes.T.tolist())}
    partner = np.array([place[tuple(p)] for p in part.nodes.T.tolist() if tuple(p) in place and p[0] > 0])
    own = np.array([k for k, p in enumerate(part.nodes.T.tolist()) if tuple(p) in place and p[0] > 0])
    assert len(own) > 50
    forces = []
    for made in (whole, part):
        potential = AxonalTension(strength=1.0).on(made).during(patterned(made, waves), STEP)
        forces.append(potential.evaluate(np.zeros(2 * made.nodes.shape[1])).gradient()[0].reshape(-1, 2))
    np.testing.assert_allclose(forces[1][own], forces[0][partner], atol=1e-12)


def test_a_scene_without_a_pattern_is_refused(body):
    with pytest.raises(MissingFieldError, match="pattern") as failure:
        Scene(body=body, terms=(AxonalTension(strength=1.0),))
    message_names(failure.value, "AxonalTension", "displacement")
    Scene(body=body, terms=(AxonalTension(strength=1.0, patches=6),))


@pytest.mark.parametrize(
    ("name", "bad", "words"),
    [
        ("strength", float("nan"), ("finite",)),
        ("strength", "strong", ("N/m",)),
        ("surface", "core", ("interface", "pial")),
        ("direction", "up", ("toward-peaks", "between-peaks")),
        ("patches", -1, ("at least 0",)),
        ("patches", 2.5, ("whole",)),
        ("ramp", -0.1, ("negative",)),
        ("ramp", float("inf"), ("finite",)),
    ],
)
def test_bad_input_is_refused(name, bad, words):
    with pytest.raises(ValueError, match=name) as failure:
        AxonalTension(**{"strength": 1.0, name: bad})
    message_names(failure.value, *words)


def test_pial_loads_cannot_follow():
    with pytest.raises(ValueError, match="follower") as failure:
        AxonalTension(strength=1.0, surface="pial", follower=True)
    message_names(failure.value, "interface", "energy")


def test_between_peaks_on_the_interface_pulls_where_the_pattern_is_low():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    pattern = np.linspace(0.0, 1.0, len(body.cortex.nodes))
    forces = {}
    for direction in ("toward-peaks", "between-peaks", None):
        term = AxonalTension(strength=2.0, direction=direction, ramp=0.0)
        potential = term.on(body).during(State(1.0, {"pattern": pattern}), TimeStep(1.0))
        forces[direction] = potential.forces
    state = State(1.0, {"pattern": np.ones_like(pattern)})
    uniform = AxonalTension(strength=2.0, ramp=0.0).on(body).during(state, TimeStep(1.0))
    assert np.array_equal(forces[None], forces["toward-peaks"])
    total = forces["toward-peaks"] + forces["between-peaks"]
    np.testing.assert_allclose(total, uniform.forces, atol=1e-14)


def test_pattern_uniform_but_for_round_off_makes_no_traction():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    pattern = 1.0 + 1e-15 * np.arange(len(body.cortex.nodes)) / len(body.cortex.nodes)
    term = AxonalTension(strength=2.0, surface="pial", ramp=0.0)
    assert not term.on(body).during(State(1.0, {"pattern": pattern}), TimeStep(1.0)).forces.any()
