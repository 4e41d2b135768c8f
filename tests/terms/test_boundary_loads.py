"""Forces at places of the pial surface: resultant, moment, weak form, tables, pairs, and what is refused."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from turingfold import BoundaryLoads, Drag, Elastic, NeoHookean, PeakLoads, Scene, human, semicircle
from turingfold.errors import InadmissibleStateError
from turingfold.geometry.mirror import half
from turingfold.parts import TimeStep
from turingfold.solve.problem import Problem
from turingfold.state import State
from turingfold.testing import check_balanced, check_term

STEP = TimeStep(0.1)


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=1.0, thickness=0.3, size=0.1, base="clamped")


def still(body, **fields):
    return State(1.0, {"displacement": np.zeros_like(body.nodes), **fields})


def nodal(term, body, time=1.0, **fields):
    state = still(body, **fields).updated(time)
    at = term.on(body).during(state, STEP).evaluate(np.zeros(body.nodes.size))
    return -at.gradient()[0].reshape(-1, 2)


def moved(body, seed):
    return 0.03 * np.random.default_rng(seed).standard_normal(body.nodes.size)


def waves(body):
    x, y = body.cortex.mesh.doflocs
    return 0.5 * (1 - np.cos(6 * np.arctan2(y, x)))


@pytest.mark.parametrize("spread", ["gaussian", "hat"])
def test_loads_pass_the_examination(body, spread):
    term, other = (
        BoundaryLoads(places=(0.1, 0.6), forces=((1.0, -2.0), (f, 0.5)), width=0.1, spread=spread)
        for f in (0.3, 0.4)
    )
    check_term(term, body, still(body), [moved(body, 1)], step=1e-3, balanced=False, objective=False,
               other=other)  # fmt: skip
    pairs, other = (PeakLoads(strength=f, distance=0.2, width=0.1, spread=spread) for f in (1.0, 1.1))
    check_term(pairs, body, still(body, pattern=waves(body)), [moved(body, 2)], step=1e-3, moment=False,
               objective=False, other=other)  # fmt: skip


@pytest.mark.parametrize("spread", ["gaussian", "hat"])
def test_the_resultant_is_as_given_also_at_the_ends(body, spread):
    given = ((1.0, -2.0), (0.3, 0.5), (-3.0, 0.1))
    for places in ((0.0, 0.4, 1.0), ((0.0, 1.0), (0.98, 0.1), (np.cos(1), np.sin(1)))):
        term = BoundaryLoads(places=places, forces=given, width=0.12, spread=spread)
        assert nodal(term, body).sum(0) == pytest.approx(np.sum(given, axis=0), rel=1e-13)
        assert term.resultant == pytest.approx(np.sum(given, axis=0))


@pytest.mark.parametrize("spread", ["gaussian", "hat"])
def test_moment_and_virtual_work_are_the_integrals_on_the_circle(spread):
    body = semicircle(radius=1.0, thickness=0.3, size=0.04, base="clamped")
    width, place, force = 0.15, 0.35, np.array([0.7, -0.4])
    forces = nodal(BoundaryLoads(places=(place,), forces=(tuple(force),), width=width, spread=spread), body)
    x, y = body.nodes
    top = place * np.pi

    def density(angle):
        s = abs(angle - top) / width
        if spread == "hat":
            return max(0.0, 1 - s) / width
        return np.exp(-0.5 * s * s) / (width * np.sqrt(2 * np.pi))

    def integral(function):
        ends = [top - min(6 * width, top), top, top + 6 * width]
        if spread == "hat":
            ends = [top - width, top, top + width]
        return sum(quad(lambda a: density(a) * function(np.cos(a), np.sin(a)), *pair)[0]
                   for pair in pairwise(ends))  # fmt: skip

    moment = integral(lambda x, y: x * force[1] - y * force[0])
    assert (x * forces[:, 1] - y * forces[:, 0]).sum() == pytest.approx(moment, rel=2e-3)
    work = (forces[:, 0] * x * y + forces[:, 1] * (x**2 - y)).sum()
    expected = integral(lambda x, y: force[0] * x * y + force[1] * (x**2 - y))
    assert work == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("spread", ["gaussian", "hat"])
@pytest.mark.parametrize("waves_on_half", [4, 6])  # a peak at the apex, and a trough between two near peaks
def test_half_a_body_bears_the_loads_of_the_whole_one(body, spread, waves_on_half):
    right = half(body)

    def pattern(of):
        x, y = of.cortex.mesh.doflocs
        return 0.5 * (1 + np.cos(4 * waves_on_half / 2 * np.arctan2(y, x)))

    places, forces = (0.2, 0.47), ((0.3, -0.2), (1.0, 0.5))
    given, of_half = (
        BoundaryLoads(places=p, forces=f, width=0.12, spread=spread)
        for p, f in (
            ((*places, *(1 - s for s in places)), (*forces, *((-x, y) for x, y in forces))),
            (places, forces),
        )
    )
    # distances within and beyond that of the last peak from the mirror
    pairs = [PeakLoads(strength=2.0, distance=d, width=0.1, spread=spread) for d in (0.2, 0.35)]
    nearest = np.array([np.hypot(*(body.nodes.T - at).T).argmin() for at in right.nodes.T])
    inside = right.nodes[0] > 0
    for load, other in ((given, of_half), *((pair, pair) for pair in pairs)):
        full = nodal(load, body, pattern=pattern(body))[nearest]
        part = nodal(other, right, pattern=pattern(right))
        assert part[inside] == pytest.approx(full[inside], abs=1e-12)
        assert 2 * part[~inside, 1] == pytest.approx(full[~inside, 1], abs=1e-12)


@pytest.mark.parametrize("half_waves", [6, 8])  # three pairs, of which one is across the mirror, and four
def test_half_a_body_bears_the_evenly_spaced_pairs_of_the_whole_one(body, half_waves):
    right = half(body)
    nearest = np.array([np.hypot(*(body.nodes.T - at).T).argmin() for at in right.nodes.T])
    full, part = (
        nodal(human.pattern_and_pull(body=b, loads="figure1", pattern=False, half_waves=half_waves)[1][0], b)
        for b in (body, right)
    )
    inside = right.nodes[0] > 0
    assert np.abs(full).max() > 0
    assert part[inside] == pytest.approx(full[nearest][inside], abs=1e-12)


def test_loads_rise_over_the_ramp(body):
    term = BoundaryLoads(places=(0.5,), forces=((0.0, -1.0),), width=0.1, ramp=0.4)
    assert nodal(term, body, 0.1).sum(0) == pytest.approx([0, -0.25], abs=1e-14)
    assert term.on(body).during(still(body).updated(0.0), STEP) is None


def test_pairs_pull_together_beside_the_peaks(body):
    # peaks of 0.5 (1 - cos 6φ) are at 30°, 90° and 150°
    pairs = PeakLoads(strength=2.0, distance=0.2, width=0.06, spread="hat")
    forces = nodal(pairs, body, pattern=waves(body))
    check_balanced(body, np.zeros(body.nodes.size), -forces.ravel())
    angle = np.arctan2(*body.nodes[::-1])
    along = forces[:, 1] * np.cos(angle) - forces[:, 0] * np.sin(angle)  # counter-clockwise
    for peak in np.pi * np.array([1, 3, 5]) / 6:
        before = (angle > peak - 0.5) & (angle < peak)
        after = (angle > peak) & (angle < peak + 0.5)
        # each is parallel to the chord: turned by the distance 0.2 from its tangent
        assert along[before].sum() == pytest.approx(2 * np.cos(0.2), rel=0.02)
        assert along[after].sum() == pytest.approx(-2 * np.cos(0.2), rel=0.02)
    only = nodal(PeakLoads(strength=2.0, distance=0.6, width=0.1), body, pattern=waves(body))
    assert np.abs(only).sum() < 0.5 * np.abs(forces).sum()  # pairs that would leave the surface are left out
    with pytest.raises(
        InadmissibleStateError, match=r"less than distance=1\.6 m from an end .* nothing pulls"
    ):
        nodal(PeakLoads(strength=2.0, distance=1.6, width=0.1), body, pattern=waves(body))
    one = 0.5 * (1 + body.cortex.mesh.doflocs[0])  # with its peak at the end
    with pytest.raises(InadmissibleStateError, match="nothing pulls"):
        nodal(PeakLoads(strength=2.0, distance=0.2, width=0.1), body, pattern=one)
    fading = PeakLoads(strength=2.0, distance=0.2, width=0.1).on(body)
    assert fading.during(still(body, pattern=0.4 * waves(body)), STEP) is None


def test_tables_are_read_with_their_units(tmp_path, body):
    file = tmp_path / "loads.csv"
    file.write_text("x [mm], y [mm], fx [mN/m], fy (N/m)\n0, 1000, 20, -1\n1000, 0, 0, 2\n", encoding="utf-8")
    found = BoundaryLoads.read(file, width=0.1)
    assert found == BoundaryLoads(places=((0, 1), (1, 0)), forces=((0.02, -1), (0, 2)), width=0.1)
    file.write_text("s,fx [N/m],fy [N/m]\n0.25,1,2\n", encoding="utf-8")
    assert BoundaryLoads.read(file, width=0.1).places == (0.25,)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,fx [N/m],fy [N/m]\n", "must name the columns"),
        ("s,gx [N/m],fy [N/m]\n0.1,1,1", "they must be fx, fy"),
        ("", "must name the columns"),
        ("s,fx [N/m],fy [lbf]\n0.1,1,1", "column fy has the unit 'lbf'"),
        ("s [mm],fx [N/m],fy [N/m]\n0.1,1,1", "column s has the unit 'mm'.*no unit"),
        ("x,y [mm],fx [N/m],fy [N/m]\n0.1,1,1,1", "column x has the unit None"),
        ("s,fx [N/m],fy [N/m]\n0.1,1\n", "line 2: '0.1,1' is not 3 numbers"),
        ("s,fx [N/m],fy [N/m]\n0.1,1,nan\n", "line 2.*not finite"),
        ("s,fx [N/m],fy [N/m]\n", "holds no places"),
    ],
)
def test_wrong_tables_are_refused_by_name(tmp_path, text, message):
    file = tmp_path / "loads.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        BoundaryLoads.read(file, width=0.1)
    file.write_bytes(b"\x89PNG\xff\xfe" + text.encode())
    with pytest.raises(ValueError, match=r"loads.csv: .* must name the columns"):
        BoundaryLoads.read(file, width=0.1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"places": (1.2,)}, "places holds 1.2"),
        ({"places": (0.1, 0.2)}, "places has 2 and forces 1"),
        ({"forces": ((1.0, np.nan),)}, "forces is nan"),
        ({"width": -1.0}, "width=-1"),
        ({"spread": "box"}, "spread='box'"),
        ({"ramp": -0.1}, "ramp=-0.1"),
    ],
)
def test_wrong_loads_are_refused_by_name(change, message):
    with pytest.raises(ValueError, match=message):
        BoundaryLoads(**{"places": (0.1,), "forces": ((1.0, 0.0),), "width": 0.1} | change)


def test_places_off_the_surface_and_widths_below_the_mesh_are_refused(body):
    with pytest.raises(ValueError, match=r"place 0, \(0, 0.5\) m, lies 0.5 m off"):
        BoundaryLoads(places=((0.0, 0.5),), forces=((1.0, 0.0),), width=0.1).on(body)
    with pytest.raises(ValueError, match=r"width=0\.01 m must be at least"):
        BoundaryLoads(places=(0.5,), forces=((1.0, 0.0),), width=0.01).on(body)
    with pytest.raises(ValueError, match=r"width=4 m is more than .* 3\.14 m; it is in m: 4 mm are 0\.004"):
        BoundaryLoads(places=(0.5,), forces=((1.0, 0.0),), width=4.0).on(body)
    with pytest.raises(ValueError, match="half a body"):
        BoundaryLoads(places=(0.7,), forces=((1.0, 0.0),), width=0.1).on(half(body))


def test_loads_that_nothing_bears_are_refused_with_their_numbers():
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    pushed = BoundaryLoads(places=(0.5,), forces=((0.25, 0.0),), width=0.1)
    turned = BoundaryLoads(places=(0.2, 0.8), forces=((0.0, 0.1), (0.0, -0.1)), width=0.1)
    for base, load, refused in (
        ("clamped", pushed, False), ("roller", pushed, True), ("free", pushed, True),
        ("roller", turned, False), ("free", turned, True),
    ):  # fmt: skip
        body = semicircle(radius=1.0, thickness=0.3, size=0.2, base=base)
        scene = Scene(body=body, terms=(solid, load))
        if refused:
            with pytest.raises(ValueError, match="does not bear"):
                Problem(scene)
        else:
            Problem(scene)
        Problem(Scene(body=body, terms=(solid, load, Drag(coefficient=1.0))))
