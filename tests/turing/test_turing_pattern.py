"""Modes, steady patterns and the process: counts, certificates, orders against the spectral solution."""

import itertools
from time import perf_counter

import numpy as np
import pytest
from turing_problems import ORACLE, initial_a, outer_line, probes, problem_a, semi_annulus, steady_a

from turingfold.errors import NotConvergedError
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle, semiellipse
from turingfold.outlines import outline
from turingfold.parts import Process
from turingfold.scene import Scene
from turingfold.solve.problem import Problem
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import advanced
from turingfold.turing.eigenvalues import rightmost_eigenvalues
from turingfold.turing.kinetics.activator_inhibitor import FitzHughNagumo, GiererMeinhardt
from turingfold.turing.kinetics.bvam import BVAM
from turingfold.turing.kinetics.chemical import Brusselator, GrayScott, Schnakenberg, Thomas
from turingfold.turing.modes import (
    count_half_waves,
    mode_with,
    modes_near,
    sign_changes,
    spectrum,
)
from turingfold.turing.process import Turing, mirrored
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.stability import conditions
from turingfold.turing.steady import newton, settle
from turingfold.verification.atlas.patterns import faults

THICKNESS = 2.5e-3


def body(size=THICKNESS / 2, shape=semicircle, **sides):
    sides = sides or {"radius": 0.0404}
    return shape(**sides, thickness=THICKNESS, size=size, base="clamped")


def test_uniform_states_react_exactly_and_diffusion_conserves():
    for degree in (1, 2):
        system = problem_a(semi_annulus(24, 2), degree)
        state = system.uniform(1.3, 0.4)
        p, q = 0.1 - 1.3 + 1.3**2 * 0.4, 0.9 - 1.3**2 * 0.4
        assert np.allclose(system.rate(state), np.outer([p, q], system.space.weights), atol=1e-15)
        spread = system.space.stiffness @ np.random.default_rng(0).standard_normal(system.space.size)
        assert abs(spread.sum()) < 1e-11
        area = (1 - float(ORACLE["pde"]["semi_annulus"]["R_inner"]) ** 2) * np.pi / 2
        assert system.space.area == pytest.approx(area, rel={1: 4e-3, 2: 4e-6}[degree])


def test_the_jacobian_is_that_of_the_rate():
    system = problem_a(semi_annulus(12, 1), 2)
    rng = np.random.default_rng(0)
    state = system.uniform(1.0, 0.9) + 0.1 * rng.standard_normal((2, system.space.size))
    way = rng.standard_normal(state.shape)
    slope = -(system.matrix(state) @ way.T.ravel()).reshape(-1, 2).T
    remainders = [
        np.abs(system.rate(state + h * way) - system.rate(state) - h * slope).max() for h in (1e-3, 1e-4)
    ]
    assert np.log10(remainders[0] / remainders[1]) == pytest.approx(2.0, abs=0.02)


def test_lumped_mass_is_diagonal_and_keeps_the_area():
    mesh = semi_annulus(24, 2)
    lumped, full = discretise(mesh, 1, lumped=True), discretise(mesh, 1)
    assert lumped.area == pytest.approx(full.area, rel=1e-13)
    off = lumped.mass.copy()
    off.setdiag(0.0)
    assert abs(off).sum() == 0.0
    with pytest.raises(ValueError, match="needs degree=1"):
        discretise(mesh, 2, lumped=True)


def test_laplace_spectrum_of_the_semi_annulus():
    # eigenvalues of quadratic elements converge with order 4
    known = {row["m"]: float(row["k2"]) for row in ORACLE["pde"]["semi_annulus"]["n0"] if row["m"] <= 12}
    errors = []
    for along in (48, 96):
        mesh = semi_annulus(along, along // 48)
        found = spectrum(discretise(mesh, 2), 160.0, outer_line(mesh))
        assert [mode.half_waves for mode in found] == list(range(13))
        assert abs(found[0].value) < 1e-9
        errors.append(max(abs(mode.value / known[mode.half_waves] - 1) for mode in found[1:]))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)
    assert errors[1] < 1e-4


def test_first_radial_mode_is_not_taken_for_one_along_the_band():
    mesh = semi_annulus(150, 8)
    first = float(ORACLE["pde"]["semi_annulus"]["n1"][0]["k2"])
    near = {
        mode.half_waves: mode.value for mode in modes_near(discretise(mesh, 2), first, 6, outer_line(mesh))
    }
    assert near[0] == pytest.approx(first, rel=1e-4)
    assert near[1] == pytest.approx(float(ORACLE["pde"]["semi_annulus"]["n1"][1]["k2"]), rel=1e-4)


@pytest.mark.parametrize(("degree", "order"), [(1, 1.9), (2, 3.0)])
def test_steady_state_of_band_problem_a_at_its_order(degree, order):
    errors = []
    for along in (96, 192) if degree == 1 else (48, 96):
        system = problem_a(semi_annulus(along, along // 48), degree)
        found = settle(system, initial_a(system))
        assert found.stable
        assert found.residual < 1e-12
        errors.append(np.abs(probes(system, found.state) - steady_a()).max())
    assert np.log2(errors[0] / errors[1]) > order
    assert errors[1] < {1: 1e-3, 2: 3e-5}[degree]


def test_growth_rates_on_the_mesh_are_the_dispersion_relation():
    # about the uniform state the leading eigenvalue is that of the fastest mode
    system = problem_a(semi_annulus(120, 1), 2)
    leading = rightmost_eigenvalues(system, system.uniform(1.0, 0.9))[0]
    assert leading.real == pytest.approx(0.05719095841, rel=1e-5)


def test_the_mean_of_the_activator_is_exact():
    # ∫(p + q) = 0: ⟨u⟩ = a + b at any steady state
    system = problem_a(semi_annulus(72, 1), 2)
    found = settle(system, initial_a(system))
    assert system.space.mean(found.state)[0] == pytest.approx(1.0, abs=1e-12)


def test_unit_square_modes_inside_the_band():
    from skfem import MeshTri

    # fine enough for the row (3, 1), whose mode lies 1.3e-5 of its eigenvalue outside the band
    mesh = MeshTri.init_tensor(*np.linspace(0, [1, 1], 41).T)
    line = np.flatnonzero(mesh.p[1] == 0.0)
    line = line[np.argsort(mesh.p[0, line])]
    modes = spectrum(discretise(mesh, 2), 340.0, line)
    for row in ORACLE["unit_square_mode_isolation"]["rows"]:
        d, gamma = float(row["d"]), float(row["gamma"])
        found = conditions(Schnakenberg(), 1 / gamma, d / gamma)
        assert found.band == pytest.approx((float(row["k2_minus"]), float(row["k2_plus"])), rel=1e-8)
        low, high = found.band
        inside = [mode for mode in modes if low < mode.value < high]
        exact = sorted(
            np.pi**2 * (m * m + n * n) for i, j in row["modes_inside"] for m, n in {(i, j), (j, i)}
        )
        assert np.allclose([mode.value for mode in inside], exact, rtol=1e-3)


def test_the_default_pattern_on_the_semi_circle():
    where = body(THICKNESS / 3)
    pattern = Turing(Schnakenberg()).pattern(where)
    assert pattern.steady.stable
    assert pattern.steady.residual < 1e-12
    angle = np.arctan2(*where.cortex.mesh.doflocs[::-1])
    assert np.corrcoef(pattern.normalised, np.cos(24 * angle))[0, 1] > 0.98
    assert pattern.normalised[pattern.design.middle] == pytest.approx(1.0, abs=1e-3)
    found = pattern.design.conditions
    assert found.fastest_k2 == pytest.approx(pattern.design.mode.value, rel=1e-12)
    assert found.fastest_k2 == pytest.approx(613.38141151902 / 0.0404**2, rel=2e-3)


@pytest.mark.parametrize(
    ("kinetics", "half_waves"),
    [(BVAM(), 20), (GrayScott(), 22), (Brusselator(), 21)],
    ids=["BVAM", "GS", "B"],
)
def test_the_ellipse_holds_as_many_half_waves_as_asked(kinetics, half_waves):
    where = body(shape=semiellipse, width=0.0808, height=0.03)
    pattern = Turing(kinetics, half_waves=half_waves).pattern(where)
    along = pattern.normalised[pattern.design.line]
    assert sign_changes(along - 0.5 * (along.min() + along.max())) == half_waves
    if half_waves % 2 == 0:
        assert along[np.abs(np.arange(len(along)) - len(along) // 2) < 4].max() > 0.9


@pytest.mark.slow
def test_linear_elements_that_lose_the_pattern_are_not_believed():
    # at T/2 the run on linear elements ends with 8 half waves; 0.03 m and finer give 10 on their own
    where = semiellipse(width=2.0, height=0.5, thickness=0.12, size=0.06)
    assert Turing(FitzHughNagumo(), half_waves=10).pattern(where).half_waves == 10
    where = semicircle(radius=1.0, thickness=0.12, size=0.03)
    found = Turing(Brusselator(), half_waves=8, ratio=74.6).pattern(where)
    assert found.half_waves == 8
    assert found.steady.stable


def test_another_number_of_half_waves_than_asked_for_is_refused_with_both():
    where = semicircle(radius=1.0, thickness=0.12, size=0.06)
    with pytest.raises(NotConvergedError, match=r"has 4 half waves .* where 8 were .* critical one 7\.4641"):
        Turing(Brusselator(), half_waves=8, ratio=74.6).pattern(where)


@pytest.mark.parametrize(("count", "closed"), [(24, False), (7, False), (12, True)])
def test_half_waves_are_counted_on_any_kind_of_wave(count, closed):
    x = np.linspace(0.0, 1.0, 801)
    wave = np.cos((np.pi * count) * x)
    for values in (wave, np.exp(4 * wave), -np.exp(4 * wave), wave + 0.3 * np.sin(2 * x) * (not closed)):
        assert count_half_waves(values, closed) == count
        rough = values + 0.02 * np.sin(400 * x) * (not closed) * np.ptp(values)
        assert count_half_waves(rough, closed) == count
    if closed:
        for k in (1, 13, 40):
            assert count_half_waves(np.append(np.roll(wave[:-1], k), wave[:-1][-k]), closed) == count


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_thomas_kinetics_form_a_pattern_from_noise(seed):
    pattern = Turing(Thomas(), half_waves=16, initial="noise").pattern(body(THICKNESS / 3), seed)
    assert pattern.steady.stable
    assert pattern.steady.state.min() > 0
    # ∫ (p − q) = 0: a − ⟨u⟩ = α (b − ⟨v⟩)
    u, v = pattern.system.space.mean(pattern.steady.state)
    assert 150.0 - u == pytest.approx(1.5 * (100.0 - v), rel=1e-10)


def test_the_time_limit_of_a_scene_counts_the_pattern():
    where = body(THICKNESS / 3)
    elastic = Elastic(gray=NeoHookean.from_young(1389.0, 0.4583), white=NeoHookean.from_young(1895.0, 0.4583))
    scene = Scene(
        body=where, terms=(elastic,), processes=(Turing(Schnakenberg()),), stepping=Stepping(seconds=1e-3)
    )
    began = perf_counter()
    with pytest.raises(NotConvergedError, match=r"time limit .* Stepping\(seconds"):
        Problem(scene).start()
    assert perf_counter() - began < 1.0


@pytest.mark.parametrize("half_waves", [24, 18])  # of which half is even, and odd
def test_half_of_a_symmetric_body_carries_half_of_the_same_pattern(half_waves):
    whole = body()
    right = half(whole)
    full, part = (Turing(Schnakenberg(), half_waves=half_waves).pattern(b) for b in (whole, right))
    assert part.design.mode.half_waves == half_waves // 2
    nodes = whole.cortex.mesh.doflocs
    for position, value in zip(right.cortex.mesh.doflocs.T[::37], part.activator[::37], strict=True):
        twin = np.hypot(*(nodes.T - position).T).argmin()
        assert full.activator[twin] == pytest.approx(value, abs=1e-8)


def test_symmetric_noise_gives_a_symmetric_pattern_and_seeds_repeat():
    where = body()
    part = Turing(Schnakenberg(), half_waves=20, initial="noise", symmetric=True)
    first, again, other = (part.pattern(where, seed) for seed in (3, 3, 4))
    twin = mirrored(where.cortex.mesh.doflocs)
    assert np.abs(first.activator - first.activator[twin]).max() < 1e-10
    assert (first.activator == again.activator).all()
    assert (first.activator != other.activator).any()


def test_turing_is_a_process_that_writes_what_it_says():
    part, where = Turing(BVAM(), half_waves=16), body()
    assert isinstance(part, Process)
    fields = part.on(where).start(State(0.0), 0)
    assert set(fields) == set(part.writes)
    assert {value.shape for value in fields.values()} == {(len(where.cortex.nodes),)}
    assert fields["pattern"].min() == 0.0
    assert fields["pattern"].max() == 1.0
    assert fields["activator"].min() < 0
    assert advanced(part, where, State(0.0, fields), 0.1) == {}


def test_what_the_band_cannot_hold_is_refused_with_the_numbers():
    where = body()
    with pytest.raises(ValueError, match=r"half_waves=60 must be below 4\d"):
        Turing(Schnakenberg(), half_waves=60).pattern(where)
    with pytest.raises(ValueError, match=r"needs 2: the largest element .* use elements of at most 0.00\d+"):
        Turing(Schnakenberg(), half_waves=24).pattern(body(THICKNESS))
    with pytest.raises(
        ValueError, match=r"2π √\(D_a/J_aa\) = 0.00\d+ m, needs 2 elements, .* at most 0.00\d+ m"
    ):
        Turing(FitzHughNagumo(), half_waves=24, ratio=1e4).pattern(where)
    with pytest.raises(ValueError, match="half_waves=7 is odd"):
        Turing(Schnakenberg(), half_waves=7, symmetric=True)
    with pytest.raises(ValueError, match="half_waves=7 is odd"):
        Turing(Schnakenberg(), half_waves=7).pattern(half(where))
    with pytest.raises(ValueError, match="half_waves=0 must be"):
        Turing(Schnakenberg(), half_waves=0)
    with pytest.raises(ValueError, match=r"(?s)ratio=8: no pattern grows.*FAIL"):
        Turing(Schnakenberg(), ratio=8.0)
    with pytest.raises(ValueError, match="kinetics='BVAM' must be a kinetics"):
        Turing("BVAM")
    with pytest.raises(ValueError, match="must be below"):
        mode_with(discretise(semi_annulus(24, 1), 1), 200, np.arange(3), 3.0, 0.06)


def test_a_run_cut_short_is_an_error_that_says_when():
    system = problem_a(semi_annulus(24, 1), 1)
    with pytest.raises(NotConvergedError, match="no stable steady state was reached by time") as caught:
        settle(system, initial_a(system), steps=3)
    assert 0 < caught.value.time < 20
    with pytest.raises(NotConvergedError, match="by time 5 "):
        settle(system, initial_a(system), until=5.0)


@pytest.mark.slow
def test_spots_of_bvam_never_settle_and_the_error_says_so():
    with pytest.raises(NotConvergedError, match="no stable steady state was reached by time"):
        Turing(BVAM(r1=0.02, r2=0.2), half_waves=16).pattern(body())


def test_a_pattern_that_stands_though_it_is_unstable_is_left():
    """Long steps damp what grows beside it: a run would stand there for ever."""
    where = semiellipse(width=2.0, height=0.857, thickness=0.133, elements=1, base="free")
    found = Turing(GiererMeinhardt(), half_waves=8).pattern(where)
    assert faults(where, found, 8) == []


def test_newton_that_fails_is_an_error():
    system = problem_a(semi_annulus(24, 1), 1)
    with pytest.raises(NotConvergedError, match="relative residual of"):
        newton(system, initial_a(system), iterations=1)


def test_nan_initial_data_are_refused():
    system = problem_a(semi_annulus(24, 1), 1)
    state = initial_a(system)
    state[1, 5] = np.nan
    with pytest.raises(ValueError, match=r"nan at index \(1, 5\)"):
        settle(system, state)
    with pytest.raises(ValueError, match="d_u=-1"):
        ReactionDiffusion(system.space, Schnakenberg(), -1.0, 1.0)


@pytest.mark.parametrize("half_waves", [12, 16, 20])
def test_a_pattern_round_a_closed_band_may_hardly_be_held_in_its_place(half_waves):
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    ellipse = np.stack([0.018 * np.cos(angle), 0.015 * np.sin(angle)])
    body = outline(ellipse, thickness=3e-3, size=1.5e-3)
    pattern = Turing(Schnakenberg(), half_waves=half_waves).pattern(body)
    rate = pattern.steady.leading.real / pattern.design.conditions.fastest_rate
    assert abs(rate) < 0.01  # of the shift along the band, whichever of two places the mirror symmetry chose
    assert pattern.steady.residual < 1e-12
    along = pattern.normalised[pattern.design.line[:-1]]
    assert np.count_nonzero(np.diff(np.sign(np.append(along, along[0]) - 0.5))) == half_waves


def test_the_search_for_a_pattern_heeds_the_time_limit_wherever_it_is(monkeypatch):
    """With a clock that ticks when it is read, it ends at the next one; eigenvalues take most of them."""
    ticks = itertools.count()
    for module in ("steady", "process"):
        monkeypatch.setattr(f"turingfold.turing.{module}.perf_counter", lambda: next(ticks))
    band, turing = semicircle(radius=1.0, thickness=0.2, elements=2), Turing(Brusselator(), half_waves=12)
    turing.pattern(band, deadline=1e9)
    whole = next(ticks)
    steps = turing.pattern(band, deadline=1e9).steady.steps
    assert whole > 3 * steps  # so that it is heeded after the run, too
    for limit in (0, whole // 2, whole - 2):
        ticks = itertools.count()
        with pytest.raises(NotConvergedError, match=r"the time limit was reached .*--max-seconds"):
            turing.pattern(band, deadline=limit)
        assert next(ticks) <= limit + 3
