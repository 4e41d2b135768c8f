"""Growing and deforming bands: exact dilution, mode doubling, the pattern on moving tissue; the report."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshTri
from turing_problems import ORACLE, initial_a, problem_a, semi_annulus

from turingfold.geometry.shapes import semicircle
from turingfold.growth.histories import Exponential, Logistic
from turingfold.state import State
from turingfold.testing import advanced
from turingfold.turing.evolving import EvolvingTuring, area_change, deformed
from turingfold.turing.growing_domain import march_on_growing_domain
from turingfold.turing.integrators.rosenbrock import march
from turingfold.turing.kinetics.chemical import GrayScott, Schnakenberg
from turingfold.turing.kinetics.user import UserKinetics
from turingfold.turing.modes import largest_isolating_ratio, sign_changes
from turingfold.turing.process import Turing
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.report import stability_report

THICKNESS = 2.5e-3


def strip(along):
    """Return a straight strip of length 1, one element across, and the nodes along it."""
    space = discretise(MeshTri.init_tensor(np.linspace(0, 1, along + 1), np.array([0, 1 / along])), 2)
    line = np.flatnonzero(space.nodes[1] == 0.0)
    return space, line[np.argsort(space.nodes[0, line])]


@pytest.mark.parametrize(
    "size",
    [lambda t: Exponential().factor(3.0, t), lambda t: Logistic().factor(3.0, t)],
    ids=["exp", "logistic"],
)
def test_decay_of_a_wave_on_a_growing_strip_is_exact(size):
    # without reaction: amplitude exp(−D π² ∫L⁻² dt) / Lⁿ, mean 1/Lⁿ
    nothing = UserKinetics(p=lambda u, v: 0 * u, q=lambda u, v: -v, guesses=((1.0, 1.0),))
    space, _ = strip(16)
    system = ReactionDiffusion(space, nothing, 0.1, 0.1)
    start = system.uniform(1.0, 1.0)
    start[0] += np.cos(np.pi * space.nodes[0])
    for n in (1, 2):
        for moment in march_on_growing_domain(
            system, start, size, until=1.0, dimensions=n, tolerance=1e-6, change=0.01
        ):
            end = moment
        t = np.linspace(0.0, 1.0, 2001)
        spread = np.trapezoid([size(x) ** -2 for x in t], t)
        exact = (1 + np.exp(-0.1 * np.pi**2 * spread) * np.cos(np.pi * space.nodes[0])) / size(1.0) ** n
        assert end.time == 1.0
        assert np.allclose(end.state[0], exact, atol=2e-5)
        assert space.mean(end.state)[1] == pytest.approx(np.exp(-1.0) / size(1.0) ** n, rel=1e-6)


@pytest.mark.slow
def test_mode_doubling_on_an_exponentially_growing_strip():
    rho = 0.01
    space, line = strip(192)
    system = ReactionDiffusion(space, Schnakenberg(), 0.01, 1.0)
    start = system.uniform(1.0, 0.9)
    start[0] += 0.001 * np.cos(np.pi * space.nodes[0])
    seen = {}
    for moment in march_on_growing_domain(
        system, start, lambda t: float(np.exp(rho * t)), until=285.0, dimensions=1, tolerance=1e-3
    ):
        along = moment.state[0, line]
        seen.setdefault(sign_changes(along - along.mean()), moment.time)
    assert list(seen) == [1, 2, 4, 8, 16]
    times = np.array(list(seen.values()))[1:]
    # each doubling repeats the one before on twice the length
    assert np.allclose(np.diff(times), np.log(2.0) / rho, atol=1.0)
    # the oracle looked at every 23/6 of time: all its times are multiples of that
    looks = 23 / 6
    oracle = {n: time for time, n, _ in ORACLE["pde"]["growing_domain_1d"]["rho=0.01"]["seq"]}
    for n in (2, 4, 8, 16):
        assert oracle[n] / looks == pytest.approx(round(oracle[n] / looks), abs=1e-9)
        assert oracle[n] - looks < seen[n] <= oracle[n]


def test_a_domain_that_vanishes_is_refused():
    system = problem_a(semi_annulus(24, 1), 2)
    with pytest.raises(ValueError, match=r"size\(2\)=-1 must be positive"):
        next(march_on_growing_domain(system, initial_a(system), lambda t: 1.0 - t, until=2.0))


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / 2, base="clamped")


def test_tissue_that_does_not_move_keeps_its_steady_pattern(body):
    part = EvolvingTuring(Turing(Schnakenberg()))
    still = {"displacement": np.zeros_like(body.nodes)}
    fields = part.on(body).start(State(0.0, still), 0)
    assert set(fields) == set(part.writes)
    later = advanced(part, body, State(0.0, {**still, **fields}), 0.1)
    assert set(later) == set(part.writes)
    assert np.allclose(later["activator"], fields["activator"], atol=1e-9)


@pytest.mark.parametrize(("dilution", "power"), [(True, 2), (False, 0)])
def test_even_growth_of_the_tissue_dilutes_and_then_reacts(body, dilution, power):
    # a short time after a stretch by 1.1 the concentrations are those before over 1.1²
    part = EvolvingTuring(Turing(GrayScott(), half_waves=20), pace=1e-3, dilution=dilution)
    still = {"displacement": np.zeros_like(body.nodes)}
    fields = part.on(body).start(State(0.0, still), 0)
    moved = {**still, **fields, "displacement": 0.1 * body.nodes}
    later = advanced(part, body, State(0.0, moved), 1e-3)
    for name in ("activator", "inhibitor"):
        assert np.allclose(later[name], fields[name] / 1.1**power, atol=1e-6)
    assert (later["band_displacement"] == 0.1 * body.cortex.mesh.doflocs).all()
    assert deformed(body, later["band_displacement"]).area == pytest.approx(
        1.21 * deformed(body, 0 * body.nodes[:, body.cortex.nodes]).area
    )


def test_the_deformed_band_is_the_growing_domain(body):
    # both descriptions of a band stretched evenly, without dilution, run the same
    turing = Turing(Schnakenberg())
    found, band = turing.design(body).conditions, body.cortex.mesh
    start = turing.on(body).start(State(0.0), 0)
    values = np.stack([start["activator"], start["inhibitor"]])
    ends = []
    for space, scale in ((deformed(body, 0.3 * band.doflocs), 1.0), (deformed(body, 0 * band.doflocs), 1.3)):
        system = ReactionDiffusion(space, Schnakenberg(), found.d_u / scale**2, found.d_v / scale**2)
        for moment in march(system, values, until=5.0, tolerance=1e-5):
            end = moment.state
        ends.append(end)
    assert np.allclose(*ends, atol=1e-9)
    assert np.abs(ends[0] - values).max() > 1e-2


def test_a_pattern_that_dies_pulls_no_more():
    # at half its size the band of two half waves is too short for the wave: the activator tends to a + b
    small = semicircle(radius=0.04, thickness=4e-3, size=2e-3, base="roller")
    part = EvolvingTuring(Turing(Schnakenberg(), half_waves=2), pace=3000.0)
    start = part.on(small).start(State(0.0, {"displacement": np.zeros_like(small.nodes)}), 0)
    assert np.ptp(start["pattern"]) == pytest.approx(1.0)
    shrunk = State(0.0, {**start, "displacement": -0.5 * small.nodes})
    end = advanced(part, small, shrunk, 0.5)
    assert np.allclose(end["activator"], 1.0, atol=1e-3)
    assert np.abs(end["pattern"]).max() < 1e-3
    # half way down, the pattern is as high as the activator's range is of that at the start
    half_way = advanced(replace(part, pace=4.0), small, shrunk, 0.5)
    share = np.ptp(half_way["activator"]) / np.ptp(start["activator"])
    assert 0.05 < share < 0.95
    assert half_way["pattern"].min() == 0.0
    assert half_way["pattern"].max() == pytest.approx(share, rel=1e-12)


def test_reactions_that_follow_the_stretch_are_as_fast_as_it_says(body):
    # an even stretch by 1.3 with J^m f is the unstretched band with D / 1.3² and J^m f: time runs J^m as fast
    turing, m, size = Turing(Schnakenberg()), 0.5, 1.3
    part = EvolvingTuring(turing, pace=5.0, dilution=False, stretch_exponent=m, tolerance=1e-5)
    fields = part.on(body).start(State(0.0, {"displacement": np.zeros_like(body.nodes)}), 0)
    moved = State(0.0, {**fields, "displacement": (size - 1) * body.nodes})
    end = advanced(part, body, moved, 1.0)
    faster = size ** (2 * m)
    found = turing.design(body).conditions
    scale = size**2 * faster
    system = ReactionDiffusion(
        deformed(body, 0 * body.cortex.mesh.doflocs), Schnakenberg(), found.d_u / scale, found.d_v / scale
    )
    for moment in march(system, np.stack([fields["activator"], fields["inhibitor"]]), until=5.0 * faster,
                        tolerance=1e-6):  # fmt: skip
        state = moment.state
    assert np.allclose(end["activator"], state[0], atol=1e-4)
    assert np.abs(end["activator"] - fields["activator"]).max() > 1e-2
    assert np.allclose(area_change(body, 0.3 * body.cortex.mesh.doflocs), 1.69, rtol=1e-12)
    # J = (1 + x / 2R)² where both coordinates are stretched alike: exact at first order in the element size
    bent = 0.25 * body.cortex.mesh.doflocs**2 / 0.0404
    exact = np.prod(1 + 0.5 * body.cortex.mesh.doflocs / 0.0404, axis=0)
    assert np.abs(area_change(body, bent) - exact).max() < 0.03 * exact.max()
    with pytest.raises(ValueError, match="stretch_exponent=9 must be between"):
        EvolvingTuring(turing, stretch_exponent=9.0)


def test_bad_options_of_the_evolving_pattern():
    with pytest.raises(ValueError, match="turing="):
        EvolvingTuring(Schnakenberg())
    with pytest.raises(ValueError, match="pace=-1"):
        EvolvingTuring(Turing(Schnakenberg()), pace=-1.0)


def test_the_report_lists_the_modes_that_grow(body):
    found = stability_report(Schnakenberg(), body=body, half_waves=12)
    # problem A: modes 10 to 15 grow, 12 fastest
    assert [mode.half_waves for mode in found.growing] == [10, 11, 12, 13, 14, 15]
    assert not found.isolated
    text = str(found)
    assert text.count("pass") == 4
    assert "12 half waves along" in text
    largest = largest_isolating_ratio(found.conditions, found.growing[2], list(found.modes))
    assert f"12 half waves grow alone at ratios up to {largest:.6g}" in text
    assert stability_report(Schnakenberg(), largest, body, 12).isolated
    assert not stability_report(Schnakenberg(), largest * (1 + 1e-6), body, 12).isolated
    with pytest.raises(ValueError, match="shares its eigenvalue"):
        largest_isolating_ratio(found.conditions, found.growing[2], [replace(found.growing[2], half_waves=3)])
    assert "FAIL" in str(stability_report(Schnakenberg(), 5.0, body))


def test_the_report_draws_the_dispersion_relation(body):
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    found = stability_report(Schnakenberg(), body=body, half_waves=12)
    found.draw(axes)
    curve, points = axes.lines[0], axes.lines[2]
    assert curve.get_ydata().max() == pytest.approx(found.conditions.fastest_rate, rel=1e-3)
    assert len(points.get_xdata()) == 6
    stability_report(Schnakenberg(), 5.0).draw(Figure().add_subplot())


def test_the_title_says_only_what_exists():
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    stability_report(GrayScott(F=0.035, k=0.065)).draw(axes)  # its only steady state has no activator
    assert axes.get_title() == "GrayScott"
    stability_report(Schnakenberg(), 20.0).draw(axes)
    # a = 0.1, b = 0.9: f_u = 0.8, det J = 1, so the critical ratio is ((1 + √1.8)/0.8)²
    assert axes.get_title() == f"Schnakenberg, ratio 20 (critical {((1 + 1.8**0.5) / 0.8) ** 2:.4g})"
