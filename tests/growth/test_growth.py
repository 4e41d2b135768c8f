"""Growth laws, histories, zones, stages."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import expit

from turingfold import NeoHookean, TangentialGrowth, semicircle
from turingfold.errors import InadmissibleStateError, MissingFieldError
from turingfold.geometry.layers import cortex_indicator
from turingfold.growth.histories import (
    Exponential,
    Gompertz,
    Linear,
    Logistic,
    Table,
    growth_time,
    postnatal_day,
)
from turingfold.growth.laws import RateGrowth
from turingfold.growth.stages import stress_free_restart
from turingfold.growth.zones import Ellipse, HalfPlane, Window, Zone
from turingfold.outlines import outline
from turingfold.parts import TimeStep
from turingfold.scene import Scene
from turingfold.solve.problem import Problem
from turingfold.state import State
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import advanced, check_process


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=1.0, thickness=0.1, size=0.05, base="roller", layers="sigmoid")


@pytest.fixture(scope="module")
def disc():
    at = 2 * np.pi * np.arange(200) / 200
    return outline(np.stack([np.cos(at), np.sin(at)]), thickness=0.1, size=0.05, layers="sigmoid")


def grown(law, body, time):
    return advanced(law, body, State(0.0), time)["growth"]


PUBLIC_CODE_STILL = (
    Zone(region=Ellipse(centre=(0, 0), semi_axes=(0.5, 0.5), edge=0.2, ramp="straight"), growth=0.0),
    Zone(region=HalfPlane(point=(0, -0.4), normal=(0, 1), edge=0.2, ramp="straight"), growth=0.0),
)


@pytest.mark.parametrize(
    "law",
    [
        TangentialGrowth(cortex=1.9, core=1.1, radial_core=1.05, radial_cortex=1.2, swelling_core=1.1),
        TangentialGrowth(out_of_plane="tangential", thinning=0.4, history=Logistic()),
        TangentialGrowth(zones=(Zone(region=Window(start=0.2, end=0.6, edge=0.1)),)),
        RateGrowth(zones=PUBLIC_CODE_STILL[:1], radial_rate=0.3, out_of_plane="tangential"),
    ],
)
def test_every_law_is_a_process(law, body):
    end = check_process(law, body, State(0.0), 0.3)
    assert end["growth"].shape == (3, *body.quadrature.weights.shape)
    assert (law.on(body).start(State(0.0), 0)["growth"] == 1).all()


def test_the_paper_law_is_the_sigmoid_between_one_and_g(body):
    along, across, out = grown(TangentialGrowth(cortex=1.9), body, 0.5)
    y = 1.0 - np.hypot(*body.quadrature.points)
    assert along == pytest.approx(1 + 0.45 / (1 + np.exp(10 * (y / 0.1 - 1))), abs=1e-5)
    assert (across == 1).all()
    assert (out == 1).all()


def test_radial_growth_of_the_cortex_acts_along_the_normal_in_the_cortex_only(body):
    along, across, _ = grown(TangentialGrowth(cortex=1.0, radial_cortex=1.5), body, 1.0)
    theta = cortex_indicator(body)
    assert (along == 1).all()
    assert across == pytest.approx(1 + 0.5 * theta)


def test_the_public_code_law_passes_the_published_values():
    body = semicircle(radius=1.0, thickness=0.1, size=0.02, base="roller", layers="sigmoid")
    law = RateGrowth(rate=1.9, thinning=0.0)
    assert grown(law, body, np.log(1.9) / 1.9)[0].max() == pytest.approx(1.9, rel=1e-3)  # t = 0.338
    assert grown(law, body, 1.0)[0].max() == pytest.approx(6.69, abs=0.01)


def test_the_public_code_law_solves_its_differential_equation(body):
    law = RateGrowth(rate=1.9, thinning=0.5, radial_rate=0.4)
    along, across, _ = grown(law, body, 0.9)
    depth = body.depth.ravel()[::97]

    def rate(t, log_g):
        return 1.9 * expit(10 * (1 - depth / (0.1 - 0.05 * t)))

    exact = solve_ivp(rate, (0, 0.9), np.zeros_like(depth), rtol=1e-10, atol=1e-12).y[:, -1]
    assert np.log(along.ravel()[::97]) == pytest.approx(exact, abs=1e-7)
    assert np.log(across.ravel()[::97]) == pytest.approx(exact * 0.4 / 1.9, abs=1e-7)


def test_laws_of_one_scene_multiply(body):
    """At t = 1/2, θ = 1 in gray: (1.1 + 0.2 θ) exp(0.15 θ) along, 1.05 + 0.1 θ across, exp(0.15 θ) out."""
    sharp = replace(body, layers="sharp")
    laws = (
        TangentialGrowth(cortex=1.6, core=1.2, radial_cortex=1.3, radial_core=1.1),
        RateGrowth(rate=0.3, thinning=0.0, out_of_plane="tangential"),
    )
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    theta = np.broadcast_to(sharp.in_cortex.astype(float), sharp.quadrature.weights.shape)
    expected = (1.1 + 0.2 * theta) * np.exp(0.15 * theta), 1.05 + 0.1 * theta, np.exp(0.15 * theta)
    for processes in (laws, laws[::-1]):
        problem = Problem(Scene(body=sharp, terms=(solid,), processes=processes))
        state = problem.processed(problem.start(), 0.5)
        np.testing.assert_allclose(state["growth"], np.stack(expected), rtol=1e-13)


def test_sharp_layers_have_one_thickness(body):
    sharp = replace(body, layers="sharp")
    for law in (TangentialGrowth(thinning=0.5), RateGrowth(thinning=0.5)):
        with pytest.raises(ValueError, match='needs a body with layers="sigmoid"'):
            law.on(sharp).start(State(0.0), 0)


def test_growth_does_not_depend_on_the_steps_taken(body):
    law = RateGrowth()
    state = State(0.0, law.on(body).start(State(0.0), 0))
    for dt in (0.1, 0.3, 0.2):
        state = state.updated(state.time + dt, **advanced(law, body, state, dt))
    assert state["growth"] == pytest.approx(grown(law, body, 0.6), rel=1e-14)


def test_thinning_moves_the_indicator_outward(body):
    whole = grown(TangentialGrowth(cortex=2.0), body, 1.0)[0]
    thin = grown(TangentialGrowth(cortex=2.0, thinning=0.5), body, 1.0)[0]
    assert thin == pytest.approx(1 + expit(10 * (1 - body.depth / 0.05)))
    assert (thin <= whole).all()


def test_the_still_regions_of_the_public_code(disc):
    x, y = disc.quadrature.points
    radius = np.hypot(x, y)
    still = np.clip(1 - 5 * np.maximum(0.5 - radius, 0), 0, 1) * np.clip(1 + 5 * np.minimum(0.4 + y, 0), 0, 1)
    along = grown(TangentialGrowth(cortex=1.9, core=1.5, zones=PUBLIC_CODE_STILL), disc, 1.0)[0]
    free = grown(TangentialGrowth(cortex=1.9, core=1.5), disc, 1.0)[0]
    assert along - 1 == pytest.approx(still * (free - 1), abs=1e-12)
    assert (along[still == 0] == 1).all()
    assert (still == 0).any()


@pytest.mark.parametrize("law", [TangentialGrowth, RateGrowth])
def test_a_zone_changes_growth_and_thickness_inside_it_only(law, body):
    window = Window(start=0.4, end=0.6, edge=0.05)
    plain, more, thin = (
        grown(law(zones=zones), body, 0.3)[0]
        for zones in ((), (Zone(region=window, growth=2.0),), (Zone(region=window, thickness=0.25),))
    )
    angle = np.arctan2(*body.quadrature.points[::-1]) / np.pi
    inside, outside = (angle > 0.451) & (angle < 0.549), (angle < 0.399) | (angle > 0.601)
    assert more[outside] == pytest.approx(plain[outside], abs=1e-12)
    assert thin[outside] == pytest.approx(plain[outside], abs=1e-12)
    twice = 1 + 2 * (plain - 1) if law is TangentialGrowth else plain**2
    assert more[inside] == pytest.approx(twice[inside])
    # a cortex of a quarter of the thickness has the growth of four times the depth
    theta = expit(10 * (1 - body.depth / 0.025))
    if law is TangentialGrowth:
        assert thin[inside] == pytest.approx(1 + 0.27 * theta[inside])
    else:
        assert (thin < plain - 0.01)[inside & (body.depth > 0.04) & (body.depth < 0.08)].all()


def test_regions_have_their_shares_at_known_places(body):
    x, y = body.quadrature.points
    turned = Ellipse(centre=(0.5, 0.4), semi_axes=(0.4, 0.2), edge=0.1, angle=0.5 * np.pi).share(body)
    radius = np.hypot((x - 0.5) / 0.2, (y - 0.4) / 0.4)
    assert (turned[radius > 1] == 0).all()
    assert turned[radius < 0.5] == pytest.approx(1.0)
    half_way = np.abs(radius - 0.75) < 0.01
    assert turned[half_way] == pytest.approx(0.5, abs=0.05)
    below = HalfPlane(point=(0, 0.5), normal=(0, 3), edge=0.25, ramp="straight").share(body)
    assert below == pytest.approx(np.clip((0.5 - y) / 0.25, 0, 1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ellipse(centre=(0, 0), semi_axes=(0.5, 0.2), edge=0.3), "edge=0.3 must be .* at most 0.2"),
        (lambda: Ellipse(centre=(0, 0), semi_axes=(0.5, -1), edge=0.1), "semi_axes=-1"),
        (lambda: HalfPlane(point=(0, 0), normal=(0, 0), edge=0.1), "no length"),
        (lambda: Window(start=0.4, end=0.4, edge=0.1), "start=0.4 and end=0.4 leave no window"),
        (lambda: Window(start=0.9, end=0.1, edge=0.2), "edge=0.2 must be .* at most 0.1"),
        (lambda: Window(start=0.4, end=1.4, edge=0.1), "end=1.4"),
        (lambda: Window(start=0.4, end=0.6, edge=0.2), "edge=0.2"),
        (lambda: Window(start=0.4, end=0.6, edge=0.1, ramp="round"), "ramp='round'"),
        (lambda: Zone(region="left"), "region='left'"),
        (lambda: Zone(region=Window(start=0.4, end=0.6, edge=0.1), growth=-1.0), "growth=-1"),
        (lambda: Zone(region=Window(start=0.4, end=0.6, edge=0.1), thickness=0), "thickness=0"),
        (lambda: TangentialGrowth(zones=(Window(start=0.4, end=0.6, edge=0.1),)), "is no Zone"),
        (lambda: TangentialGrowth(radial_cortex=0), "radial_cortex=0"),
        (lambda: TangentialGrowth(thinning=1.5), "thinning=1.5"),
        (lambda: RateGrowth(rate=np.inf), "rate=inf"),
        (lambda: growth_time(40), "day=40 must be between 0 and 32"),
        (lambda: postnatal_day(1.1), "time=1.1 must be between 0 and duration=1"),
        (lambda: growth_time(4, slowing=-1), "slowing=-1"),
        (lambda: postnatal_day(0.5, duration=0), "duration=0"),
    ],
)
def test_bad_options_are_refused_by_name(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_window_goes_round_the_seam_of_a_closed_surface_only(disc, body):
    window = Window(start=0.9, end=0.15, edge=0.05, ramp="straight")
    x, y = disc.quadrature.points
    past = (np.arctan2(y, x) / (2 * np.pi) - 0.9) % 1.0  # the outline begins at angle 0; 0.25 is its width
    known, out = np.clip(np.minimum(past, 0.25 - past) / 0.05, 0, 1), np.hypot(x, y) > 0.5
    assert window.share(disc)[out] == pytest.approx(known[out], abs=2e-4)
    with pytest.raises(ValueError, match=r"start=0\.9 must be less than end=0\.15.*not closed"):
        window.share(body)


def test_a_zone_outside_the_body_is_refused(body):
    law = TangentialGrowth(zones=(Zone(region=Ellipse(centre=(3, 0), semi_axes=(1, 1), edge=0.1), growth=2),))
    with pytest.raises(ValueError, match=r"lies outside the body, which extends from \(-1, 0\) to \(1, 1\)"):
        law.on(body).start(State(0.0), 0)


def test_a_cortex_thinned_away_is_an_inadmissible_state(body):
    with pytest.raises(InadmissibleStateError, match="no cortex at t = 1"):
        grown(RateGrowth(thinning=1.0), body, 1.0 + 1e-9)


def test_shrinking_through_zero_is_an_inadmissible_state(body):
    law = TangentialGrowth(cortex=0.5)
    with pytest.raises(InadmissibleStateError, match="growth factor reaches"):
        grown(law, body, 2.5)


@pytest.mark.parametrize(
    "history", [Linear(), Exponential(), Logistic(), Gompertz(), Table(times=(0, 0.5, 1), shares=(0, 0.7, 1))]
)
def test_histories_run_from_one_to_the_final_factor(history):
    values = [history.factor(1.9, t) for t in np.linspace(0, 1, 21)]
    assert values[0] == pytest.approx(1.0)
    assert values[-1] == pytest.approx(1.9)
    assert np.all(np.diff(values) > 0)


def test_an_exponential_history_has_a_constant_relative_rate():
    history = Exponential(duration=2.0)
    times = np.linspace(0.1, 1.9, 7)
    slopes = [(history.factor(1.9, t + 1e-6) - history.factor(1.9, t - 1e-6)) / 2e-6 for t in times]
    rates = np.array(slopes) / [history.factor(1.9, t) for t in times]
    assert rates == pytest.approx(np.log(1.9) / 2.0)


def test_growth_slows_down_with_age_from_the_first_to_the_last_day():
    assert growth_time(0) == 0
    assert growth_time(32, duration=3.0) == 3.0
    steady = [growth_time(day, slowing=1e6) for day in (4, 8, 16)]
    assert steady == pytest.approx([0.125, 0.25, 0.5], rel=1e-4)
    slopes = [growth_time(day + 1e-6) - growth_time(day) for day in (1, 13)]
    assert slopes[0] / slopes[1] == pytest.approx(np.e, rel=1e-6)
    assert postnatal_day(growth_time(11.0, duration=3.0), duration=3.0) == pytest.approx(11.0)


def test_a_restarted_body_is_free_of_stress_and_follows_its_new_shape(body):
    x, y = body.nodes
    moved = State(1.0, {"displacement": np.stack([0.2 * x, -0.1 * y + 0.05 * y * x**2])})
    new = stress_free_restart(body, moved)
    still = np.zeros(2 * new.nodes.shape[1])
    potential = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)).on(new).during(State(0.0), TimeStep(0.1))
    elastic = potential.evaluate(still)
    forces, scale = elastic.gradient()
    assert np.abs(forces).max() < 1e-13 * np.sqrt(scale)
    # det of the deformation gradient, integrated over the old body, is the new area
    px = body.quadrature.points[0]
    det = 1.2 * (0.9 + 0.05 * px**2)
    assert new.quadrature.weights.sum() == pytest.approx((det * body.quadrature.weights).sum(), rel=1e-6)
    assert (new.in_cortex == body.in_cortex).all()
    assert new.thickness == body.thickness
    assert new.base == "roller"
    assert len(new.fixed) == len(body.fixed)
    some = new.quadrature.points[:, 0]
    brute = np.array([np.hypot(*(new.nodes[:, new.pial] - p[:, None])).min() for p in some.T])
    assert new.depth[0] == pytest.approx(brute, abs=0.02)


def test_a_folded_over_body_cannot_be_restarted(body):
    x, y = body.nodes
    folded = {"displacement": np.stack([0 * x, -1.5 * y * (np.abs(x) < 0.3)])}
    with pytest.raises(ValueError, match="triangle"):
        stress_free_restart(body, State(1.0, folded))


@pytest.mark.parametrize("wrong", [None, State])
def test_what_is_no_body_or_state_cannot_be_restarted(body, wrong):
    with pytest.raises(ValueError, match=r"body=.* must be a Body object"):
        stress_free_restart(wrong, State(1.0))
    with pytest.raises(ValueError, match=r"state=.* must be a State object, such as result\.last"):
        stress_free_restart(body, wrong)


def test_a_state_without_displacement_cannot_be_restarted(body):
    with pytest.raises(MissingFieldError, match=r"no field 'displacement' \(it has: growth\).*result\.last"):
        stress_free_restart(body, State(1.0, {"growth": np.ones(3)}))
