"""Parameters at the limits of their parts, measures with kinks, several pial surfaces, standard errors."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from skfem import MeshTri2
from small import elastic_scene, folding_scene

from turingfold import (
    ActiveStress,
    AxonalTension,
    BoundaryLoads,
    Elastic,
    GrowthMap,
    Imperfection,
    NeoHookean,
    PatternMap,
    Scene,
    Stepping,
    TangentialGrowth,
    adjoint_sensitivity,
    fit,
    half,
    outline,
    semicircle,
    sensitivity,
    simulate,
)
from turingfold.extend import Evolution, Process
from turingfold.geometry.body import by_node
from turingfold.parts import TimeStep
from turingfold.sensitivity.change import BOTH, ONE
from turingfold.sensitivity.landmarks import landmarks_of
from turingfold.sensitivity.measures import measures_of
from turingfold.sensitivity.parameters import CENTRAL, FORWARD, numbers_of
from turingfold.sensitivity.standard_errors import told
from turingfold.sensitivity.validity import is_kinked
from turingfold.solve.newton import Minimiser
from turingfold.solve.problem import Problem


def imperfect(amplitude):
    made = folding_scene()
    processes = (*made.processes, Imperfection(amplitude=amplitude))
    return replace(made, processes=processes, until=0.5, stepping=replace(made.stepping, tolerance=1e-11))


@pytest.fixture(scope="module")
def at_limit():
    return simulate(imperfect(0.3))  # the largest that there is


def test_the_rules_for_differences_are_of_fourth_order():
    for places, rule, orders in ((CENTRAL, BOTH, (5, 3)), (FORWARD, ONE, (5, 4))):
        for weights, order in zip(rule, orders, strict=False):
            powers = [float(np.array(weights) @ np.array(places) ** k) for k in range(order)]
            np.testing.assert_allclose(powers, np.eye(order)[1], atol=1e-13)
    kink = np.array(BOTH[2])
    np.testing.assert_allclose([kink @ np.array(CENTRAL) ** k for k in range(4)], 0.0, atol=1e-13)
    assert kink @ np.maximum(CENTRAL, 0.0) == pytest.approx(0.5)  # half the jump of the slope


def test_at_a_limit_of_its_part_the_derivative_is_that_of_the_side_that_is_left(at_limit):
    name = "Imperfection.amplitude"
    assert name in numbers_of(at_limit.scene)
    found = sensitivity(at_limit, to=(name,))
    h, problem, old = 1e-4, Problem(at_limit.scene), at_limit.last
    x = []
    for k in range(4):
        changed = Problem(imperfect(0.3 - k * h))
        state = changed.processed(changed.start(), old.time)
        kept = {key: old[key] for key in ("displacement", "contact_chords")}
        step = TimeStep(old.time, over=True)
        minimiser = Minimiser(problem.n_dofs, problem.held, 1e-12, 60)
        potentials = changed.potentials(state.updated(**kept), step)
        x.append(minimiser.minimise(potentials, by_node(old["displacement"])).x)
    expected = (11 * x[0] - 18 * x[1] + 9 * x[2] - 2 * x[3]) / (6 * h)
    scale = np.abs(expected).max()
    assert scale > 1e-4 * at_limit.scene.body.thickness
    assert np.abs(by_node(found.displacement[0]) - expected).max() < 1e-5 * scale
    assert found.errors[0] < 1e-5
    assert 0 < found.ranges[0] <= 1
    adjoint = adjoint_sensitivity(at_limit, to=(name,))
    np.testing.assert_allclose(adjoint.derivatives, found.derivatives, rtol=1e-5, atol=1e-9)


def test_a_fit_goes_to_a_limit_and_starts_at_one():
    made = elastic_scene(TangentialGrowth(cortex=1.3), Imperfection(amplitude=0.3))
    hidden = simulate(made).pial()
    for begun in (0.2, 0.3):
        scene = elastic_scene(TangentialGrowth(cortex=1.25), Imperfection(amplitude=begun))
        names = ("Imperfection.amplitude", "TangentialGrowth.cortex")
        found = fit(scene, {1.0: hidden}, names, bounds={names[0]: (0.0, 0.3)})
        np.testing.assert_allclose(found.values, (0.3, 1.3), atol=2e-3)


@dataclass(frozen=True)
class Narrow(Process):
    """A process with a parameter that may hardly change."""

    width: float = 1.0
    reads, writes, keeps = (), ("width",), ("width",)

    def __post_init__(self):
        if abs(self.width - 1.0) > 1e-9:
            raise ValueError(f"width={self.width} must be 1.")

    def on(self, body):
        return OnBody()


class OnBody(Evolution):
    def start(self, state, seed):
        return {"width": np.ones(1)}

    def advance(self, before, now, dt):
        return {"width": np.ones(1)}


def test_a_parameter_between_two_near_limits_is_refused_by_name():
    result = simulate(elastic_scene(Narrow(), TangentialGrowth(cortex=1.2)))
    assert "Narrow.width" not in numbers_of(result.scene)
    with pytest.raises(
        ValueError, match=r"Narrow\.width is 1\.0, and a derivative needs values up to 0\.002"
    ):
        sensitivity(result, to=("Narrow.width",))


def test_a_kink_in_a_parameter_is_told():
    """A load that is there in full when the scene ends: later it is less, sooner no more."""
    found = sensitivity_to_the_ramp(1.0)
    assert found.errors[0] == pytest.approx(1.0, abs=0.01)
    assert found.ranges[0] == 0.0
    assert "BoundaryLoads.ramp: forces do not change smoothly" in found.text()


def sensitivity_to_the_ramp(ramp):
    load = BoundaryLoads(places=(0.3,), forces=((0.0, -0.02),), width=0.25, ramp=ramp)
    made = elastic_scene()
    result = simulate(replace(made, terms=(*made.terms, load)))
    if ramp < 1:
        return sensitivity(result, to=("BoundaryLoads.ramp",))
    with pytest.warns(UserWarning, match="BoundaryLoads.ramp: forces do not change smoothly"):
        adjoint_sensitivity(result, to=("BoundaryLoads.ramp",))
    with pytest.warns(UserWarning, match="BoundaryLoads.ramp: forces do not change smoothly"):
        return sensitivity(result, to=("BoundaryLoads.ramp",))


@pytest.mark.parametrize(("ramp", "reach"), [(0.8, 0.25), (0.4, np.inf)])
def test_what_changes_nothing_nearby_does_so_until_it_begins_to_act(ramp, reach):
    """The load is there in full from the time `ramp` on, which begins to matter where that is the end."""
    found = sensitivity_to_the_ramp(ramp)
    assert np.abs(found.derivatives).max() < 1e-15  # the energy is 1e-2
    assert found.ranges[0] == pytest.approx(reach, abs=1e-4)


def test_what_changes_round_off_only_has_no_kink():
    load = BoundaryLoads(places=(0.3,), forces=((0.0, -1e-13),), width=0.25, ramp=1.0)
    made = elastic_scene()
    result = simulate(replace(made, terms=(*made.terms, load)))
    adjoint = adjoint_sensitivity(result, to=("BoundaryLoads.ramp",))  # a warning is an error
    assert np.abs(adjoint.derivatives).max() < 1e-12
    found = sensitivity(result, to=("BoundaryLoads.ramp",))
    assert found.errors[0] == pytest.approx(1.0, abs=0.01)
    assert np.abs(found.derivatives).max() < 1e-12
    assert found.ranges[0] == np.inf
    assert "smoothly" not in found.text()


@pytest.mark.parametrize(
    ("lost", "derivative", "value", "kinked"),
    [(0.2, 1.0, 3.0, True), (0.05, 1.0, 3.0, False), (1e-12, 1e-13, 3.0, False), (1e-3, 0.0, 0.0, True)],
)
def test_a_kink_counts_where_it_leaves_a_tenth_open_that_is_no_round_off(lost, derivative, value, kinked):
    assert is_kinked(np.array([lost]), np.array([derivative]), value, np.array([1.0])).tolist() == [kinked]


def ends(make, value):
    summary = simulate(make(value)).summary()
    return np.array([summary["perimeter"], summary["energy"]])


def active(depth):
    made = elastic_scene()
    return replace(made, terms=(*made.terms, ActiveStress(stress=0.3, depth=(0.5, depth))))


def test_a_parameter_that_acts_in_steps_is_refused_by_name():
    """Integration points come into the layer one after the other, and nothing changes between."""
    points = np.unique(active(1.5).body.relative_depth)
    value = 0.5 * (points[points < 1.5][-1] + points[points > 1.5][0])  # between two of them
    result = simulate(active(value))
    at, near, far = (ends(active, value * share) for share in (1.0, 1.0 + 1e-3, 1.1))
    np.testing.assert_array_equal(at, near)
    assert abs(far[1] / at[1] - 1) > 1e-3
    for ask in (sensitivity, adjoint_sensitivity):
        with pytest.raises(ValueError, match=r"ActiveStress\.depth\.1 acts in steps: .*, where they jump"):
            ask(result, to=("ActiveStress.depth.1",))
    assert sensitivity(result, to=("ActiveStress.stress",)).ranges[0] > 0.1


def node_near_the_middle():
    """Return the share of the pial surface at which a node of the cortex lies, next to a half."""
    shares = PatternMap(values=(0.0, 1.0), places=(0.0, 1.0)).on(elastic_scene().body).pattern
    return float(shares[np.abs(shares - 0.4999).argmin()])


def pulled(place):
    pattern = PatternMap(values=(0.0, 1.0, 0.3, 0.9, 0.1), places=(0.0, 0.2, place, 0.75, 1.0))
    pull, processes = AxonalTension(strength=0.1), (pattern, TangentialGrowth(cortex=1.25))
    made = elastic_scene()
    return replace(made, terms=(*made.terms, pull), processes=processes)


def test_where_both_sides_differ_the_linear_answer_is_good_for_nothing():
    """A pattern's kink lies at a node of the cortex: slopes to either side are of scenes run again."""
    value, h = node_near_the_middle(), 5e-4
    below, at, above = (ends(pulled, value + move) for move in (-h, 0.0, h))
    slopes = np.array([at - below, above - at]) / h
    mean = slopes.mean(0)
    assert (np.abs(slopes - mean) > 0.1 * np.abs(mean)).all()
    result = simulate(pulled(value))
    for ask in (adjoint_sensitivity, sensitivity):
        with pytest.warns(UserWarning, match=r"PatternMap\.places\.2: forces do not change smoothly"):
            found = ask(result, to=("PatternMap.places.2",), of=("perimeter", "energy"))
        assert found.derivatives[:, 0] == pytest.approx(mean, rel=0.05)
    assert found.ranges[0] == 0.0
    assert found.jumps[:, 0] == pytest.approx(np.abs(np.diff(slopes, axis=0)[0]) / 2, rel=0.05)


def test_the_linear_answer_is_good_up_to_a_kink_beside_it():
    beside = node_near_the_middle() + 4e-4
    found = sensitivity(simulate(pulled(beside)), to=("PatternMap.places.2",))
    assert found.errors[0] < 1e-4
    assert 3e-4 < found.ranges[0] * beside < 6e-4


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (lambda points: float("nan"), "it returned nan"),
        (lambda points: points[0], r"it returned ndarray of shape"),
        (lambda points: None, "it returned None"),
        (lambda points: 1j, "it returned 1j"),
        (lambda points: "long", "it returned 'long'"),
    ],
)
def test_what_is_no_measure_is_refused_by_name(grown, returned, words):
    returned.__name__ = "mine"
    for made in (sensitivity, adjoint_sensitivity):
        with pytest.raises(ValueError, match=f"of=mine: {words}"):
            made(grown, to=("GrowthMap.cortex.1",), of=[returned])


def test_what_is_asked_for_in_vain_is_said(grown):
    name = ("GrowthMap.cortex.1",)
    for made, to, options, words in (
        (sensitivity, (), {}, "to=.* names no parameter"),
        (sensitivity, name[0], {}, "give a list of names"),
        (sensitivity, (None,), {}, "give a list of names"),
        (adjoint_sensitivity, name, {"of": ()}, "give a list of one measure"),
        (sensitivity, name, {"of": "energy"}, "give a list of one measure"),
        (sensitivity, name, {"step": 99}, "the result has the states 0 to"),
        (sensitivity, name, {"step": -99}, "step=-99"),
        (sensitivity, name, {"step": 1.5}, r"step=1\.5"),
    ):
        with pytest.raises(ValueError, match=words):
            made(grown, to=to, **options)
    found = sensitivity(grown, to=name)
    for bad in ([1.0, 2.0], [-1.0]):
        with pytest.raises(ValueError, match="deviations"):
            found.deviations(bad)
    flat = sensitivity(grown, to=name, of=("sulcal_depth",))
    assert "nan" not in flat.text() or flat.numbers[0] > 0


def test_the_range_of_what_acts_linearly_is_the_parameter_itself():
    load = BoundaryLoads(places=(0.3,), forces=((1e-9, -1e-9),), width=0.25)
    made = elastic_scene()
    result = simulate(replace(made, terms=(*made.terms, load)))
    assert sensitivity(result, to=("BoundaryLoads.forces.0.0",)).ranges[0] == 1.0


@pytest.fixture(scope="module", params=["whole", "half", "closed"])
def grown(request):
    body = semicircle(radius=1.0, thickness=0.25, elements=2)
    if request.param == "closed":
        turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
        body = outline(np.stack([1.2 * np.cos(turn), np.sin(turn)], axis=1), thickness=0.25, elements=2)
    growth = GrowthMap(cortex=(1.1, 2.2, 1.1, 2.2), places=(0.05, 0.2, 0.35, 0.5))
    scene = Scene(
        body=half(body) if request.param == "half" else body, processes=(growth,),
        terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),), stepping=Stepping(first=0.25, largest=0.25),
    )  # fmt: skip
    return simulate(scene)


def test_the_known_derivatives_of_lengths_are_those_by_differences(grown):
    names, measures = ("GrowthMap.cortex.1", "GrowthMap.cortex.2"), ("perimeter", "gyrification_index")
    own = sensitivity(grown, to=names, of=measures)
    assert own.numbers[1] > 1.0002, "the surface is to have a hollow"
    assert not own.jumps.any()

    def wrapped(k):
        def measure(points):
            return measures_of(grown, measures)[measures[k]](points)

        measure.__name__ = f"by differences {k}"
        return measure

    by_differences = [
        made(grown, to=names, of=[wrapped(0), wrapped(1)]) for made in (sensitivity, adjoint_sensitivity)
    ]
    scale = np.abs(own.derivatives).max(1, keepdims=True)
    for other in by_differences:
        np.testing.assert_allclose(other.derivatives / scale, own.derivatives / scale, atol=1e-6)
    assert by_differences[0].jumps.max() < 1e-5 * scale.max()
    assert by_differences[1].jumps.max() < 1e-5
    known = adjoint_sensitivity(grown, to=names, of=measures)
    np.testing.assert_allclose(known.derivatives / scale, own.derivatives / scale, atol=1e-6)


def test_a_function_of_ones_own_is_not_taken_for_the_measure_of_its_name(grown):
    def perimeter(points):
        return 2.0 * float(points[1].max())

    def other(points):
        return 2.0 * float(points[1].max())

    name = ("GrowthMap.cortex.1",)
    one, two = (sensitivity(grown, to=name, of=[measure]).derivatives for measure in (perimeter, other))
    np.testing.assert_array_equal(one, two)


def test_a_kink_in_a_measure_is_told(grown):
    pial = grown.pial()
    k = int(np.argmax(pial[1]))

    def away(points):
        return abs(float(points[1, k] - pial[1, k]))

    def height(points):
        return float(points[1, k])

    name = ("GrowthMap.cortex.2",)
    found = sensitivity(grown, to=name, of=[away, height])
    assert found.derivatives[0, 0] == pytest.approx(0.0, abs=1e-6)
    assert found.jumps[0, 0] == pytest.approx(abs(found.derivatives[1, 0]), rel=1e-4)
    assert found.jumps[1, 0] < 1e-6 * abs(found.derivatives[1, 0])
    assert "away jumps or has a kink here" in found.text()
    assert "height jumps" not in found.text()
    adjoint = adjoint_sensitivity(grown, to=name, of=[away, height])
    assert adjoint.jumps[0] > 1
    assert adjoint.jumps[1] < 1e-6


def test_the_energy_of_several_pial_parts_has_derivatives_and_lengths_of_them_are_refused():
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rings = [0.02 * np.stack([np.cos(turn) + side, np.sin(turn)], axis=1) for side in (-1.25, 1.25)]
    body = outline(rings, thickness=4e-3, elements=2)

    def scene(cortex):
        term = Elastic(gray=NeoHookean(mu=400.0, kappa=2000.0))
        steps = Stepping(first=0.5, largest=0.5, tolerance=1e-11)
        return Scene(body=body, terms=(term,), processes=(TangentialGrowth(cortex=cortex),), stepping=steps)

    result, name = simulate(scene(1.1)), ("TangentialGrowth.cortex",)
    up, down = (simulate(scene(1.1 + h)).summary()["energy"] for h in (1e-4, -1e-4))
    for found in (made(result, to=name, of=("energy",)) for made in (sensitivity, adjoint_sensitivity)):
        assert found.derivatives[0, 0] == pytest.approx((up - down) / 2e-4, rel=1e-5)
    with pytest.raises(ValueError, match=r"2 parts, and measures are of one; of=\('energy',\)"):
        sensitivity(result, to=name)
    with pytest.raises(ValueError, match="2 parts; a fit compares one outline with one"):
        fit(scene(1.1), {1.0: rings[0].T}, name)


def test_landmarks_of_half_a_body_whose_pial_surface_starts_on_the_mirror():
    upright = semicircle(radius=1.0, thickness=0.25, elements=2)
    mesh = upright.mesh
    turned = MeshTri2(-mesh.doflocs, mesh.t, _boundaries=mesh.boundaries, _subdomains=mesh.subdomains)
    body = half(replace(upright, mesh=turned))
    start = body.nodes[:, body.pial[0]]
    np.testing.assert_allclose(start, (0.0, -1.0), atol=1e-12)
    marks = landmarks_of(body, 1.0, [(0.0, (0, 0)), (0.25, (0, 0)), (0.75, (0, 0))])
    places = marks.apart(np.zeros(body.nodes.size))
    corner = np.sqrt(0.5)
    np.testing.assert_allclose(places, [[0, corner, -corner], [-1, -corner, -corner]], atol=1e-3)


def test_standard_errors_are_those_of_repeated_fits():
    random = np.random.default_rng(0)
    jacobian = random.standard_normal((60, 3)) * (1.0, 10.0, 0.1)
    spread = np.where(np.arange(60) < 20, 3.0, 0.5)
    errors = random.standard_normal((60, 20000)) * spread[:, None]
    repeated = np.linalg.lstsq(jacobian, errors, rcond=None)[0].std(axis=1)
    found = told(jacobian, spread)
    np.testing.assert_allclose(found.deviations, repeated, rtol=0.02)
    assert found.distinct == 3
    same = told(np.column_stack([jacobian, jacobian[:, 0]]), spread)
    assert same.distinct == 3
    assert np.isinf(same.deviations).tolist() == [True, False, False, True]
    np.testing.assert_allclose(np.abs(same.flat[0]), (np.sqrt(0.5), 0, 0, np.sqrt(0.5)), atol=1e-10)
