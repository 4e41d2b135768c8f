"""Growth in response to stress: exact bars at a fixed stretch, order in the step, stability, rest."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from skfem import MeshTri1

from turingfold import (
    Body,
    Elastic,
    NeoHookean,
    Scene,
    Stepping,
    StressGrowth,
    Table,
    TangentialGrowth,
    VolumeGrowth,
)
from turingfold.errors import StepTooLongError
from turingfold.geometry.body import by_node
from turingfold.growth.stress_driven import LARGEST
from turingfold.parts import TimeStep
from turingfold.solve.march import begin, march
from turingfold.state import State

WHITE = NeoHookean.from_young(1895.0, 0.4583)
SOLID = Elastic(gray=WHITE)
A = 1 / WHITE.mu


def bar():
    """Return a bar along x whose upper fifth is cortex."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, 3), np.linspace(0, 0.5, 6))
    sides = {"pial": lambda x: x[1] == 0.5, "base": lambda x: x[1] == 0.0}
    return Body(mesh.with_boundaries(sides), 0.1)


def cauchy(stretches, growth):
    """Return the principal Cauchy stresses at stretches (3,) of a body grown by factors (3,)."""
    elastic = np.asarray(stretches) / growth
    J = elastic.prod()
    return WHITE.mu * J ** (-5 / 3) * (elastic**2 - (elastic**2).mean()) + WHITE.kappa * (J - 1)


def held(law, stretches, until, steps):
    """Return the growth of a bar held at in-plane stretches, a white point's (3,), after so many steps."""
    body = bar()
    evolution, operator = law.on(body), SOLID.on(body)
    u = np.diag(np.asarray(stretches) - 1.0) @ body.nodes
    state = State(0.0, {"displacement": u})
    state = state.updated(**evolution.start(state, 0))
    white = np.flatnonzero(~body.in_cortex)[0]
    for _ in range(steps):
        at = operator.during(state, TimeStep(until / steps)).evaluate(by_node(u))
        before = state.updated(**at.finish(frozenset(SOLID.writes)))
        now = State(state.time + until / steps)
        state = before.updated(now.time, **evolution.advance(before, now, until / steps))
        assert (state["growth"][:, :, body.in_cortex] == 1).all()
    return state["growth"][:, 0, white]


@pytest.mark.parametrize("out_of_plane", ["fixed", "tangential"])
@pytest.mark.parametrize("stretches", [(1.2, 1.0), (1.15, 1.15), (0.9, 1.1)])
def test_growth_of_a_held_bar_follows_its_differential_equation(stretches, out_of_plane):
    law = StressGrowth(rate=A, out_of_plane=out_of_plane)
    grows = np.array([1, 1, out_of_plane == "tangential"])

    def rate(time, growth):
        return growth * grows * A * cauchy([*stretches, 1.0], growth)

    exact = solve_ivp(rate, (0, 0.3), np.ones(3), rtol=1e-11, atol=1e-12).y[:, -1]
    errors = [np.abs(held(law, stretches, 0.3, n) - exact).max() for n in (40, 80, 160)]
    assert errors[-1] < 2e-3 * np.abs(exact - 1).max() + 1e-3
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 0.85).all(), orders


@pytest.mark.parametrize("set_point", [1.0, 1.05])
def test_growth_above_a_volume_follows_its_differential_equation(set_point):
    law = VolumeGrowth(rate=2.0, set_point=set_point)
    J = 1.2 * 1.1

    def rate(time, growth):
        return 2.0 * np.maximum(J / growth**2 - set_point, 0)

    exact = solve_ivp(rate, (0, 0.5), [1.0], rtol=1e-11, atol=1e-12).y[0, -1]
    errors = [abs(held(law, (1.2, 1.1), 0.5, n)[0] - exact) for n in (20, 40, 80)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 2e-3
    assert (orders > 0.85).all(), orders


@pytest.mark.parametrize("law", [StressGrowth(rate=1e4 * A), VolumeGrowth(rate=1e6)])
def test_any_step_comes_down_to_the_end_without_overshooting(law):
    # the end: no stress along the directions that grow; for volume growth J* at its set point
    ends = [held(law, (1.2, 1.1), 1.0, n) for n in (40, 80)]
    for end in ends:
        if isinstance(law, VolumeGrowth):
            assert end[0] ** 2 == pytest.approx(1.2 * 1.1, rel=1e-3)
        else:
            assert np.abs(cauchy([1.2, 1.1, 1.0], end)[:2]).max() < 1e-2 * WHITE.mu
    np.testing.assert_allclose(*ends, rtol=1e-3)


@pytest.mark.parametrize("law", [StressGrowth(rate=A), VolumeGrowth(rate=1.0)])
def test_a_response_ends_within_a_step_and_nothing_grows_after_it(law):
    until = held(law, (1.1, 1.05), 0.3, 30)
    ended = held(replace(law, end=0.3), (1.1, 1.05), 0.6, 60)
    assert ended == pytest.approx(until, rel=1e-12)
    within = held(replace(law, end=0.295), (1.1, 1.05), 0.6, 60)
    assert 0 < np.abs(within - until).max() < 0.05 * np.abs(until - 1).max()
    with pytest.raises(ValueError, match="end=0"):
        replace(law, end=0.0)


@pytest.mark.parametrize("law", [StressGrowth(rate=A), VolumeGrowth(rate=5.0)])
def test_growth_that_is_too_fast_for_a_step_is_refused_and_not_cut(law):
    with pytest.raises(StepTooLongError, match="growth would change by a factor of"):
        held(law, (2.0, 1.5), 1.0, 1)


def test_a_march_halves_steps_in_which_growth_is_too_fast():
    # a cortex that grows threefold along the bar pulls its white matter
    gray = TangentialGrowth(cortex=3.0, history=Table(times=(0.0, 0.5), shares=(0.0, 1.0)))
    processes, stepping = (gray, StressGrowth(rate=20 * A)), Stepping(first=0.5, largest=0.5)
    scene = Scene(body=bar(), terms=(SOLID,), processes=processes, stepping=stepping)
    states = [step.state for step, _ in march(scene, begin(scene))]
    assert len(states) > 2
    changes = [np.log(after["response"] / before["response"]) for before, after in pairwise(states)]
    assert np.abs(changes).max() <= LARGEST
    assert np.abs(np.log(states[-1]["response"])).max() > 2 * LARGEST


@pytest.mark.parametrize("law", [StressGrowth(rate=10 * A), VolumeGrowth(rate=10.0)])
def test_a_body_at_rest_stays_at_rest(law):
    scene = Scene(body=bar(), terms=(SOLID,), processes=(law,))
    for step, _ in march(scene, begin(scene)):
        assert np.abs(step.state["displacement"]).max() < 1e-12
        assert np.abs(step.state["growth"] - 1).max() < 1e-12


def test_a_rigid_rotation_does_not_change_the_stress_along_the_tissue():
    from turingfold.growth.stress_driven import in_tissue

    body, turn = bar(), np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    found = []
    for R in (np.eye(2), turn):
        u = (R @ np.array([[1.2, 0.1], [0.1, 0.9]]) - np.eye(2)) @ body.nodes
        growth = np.ones((3, *body.quadrature.weights.shape)) * np.array([1.3, 0.9, 1.0])[:, None, None]
        state = State(0.0, {"displacement": u, "growth": growth})
        at = SOLID.on(body).during(state, TimeStep(1.0)).evaluate(by_node(u))
        found.append(in_tissue(body, state.updated(**at.finish(frozenset({"cauchy_stress"})))))
    np.testing.assert_allclose(found[1], found[0], atol=1e-10 * WHITE.mu)


def test_it_multiplies_the_prescribed_growth_and_lowers_the_energy():
    body = bar()
    gray = (TangentialGrowth(cortex=1.2),)
    energies = []
    for processes in (gray, (*gray, StressGrowth(rate=A))):
        scene = Scene(body=body, terms=(SOLID,), processes=processes)
        *_, (step, _) = march(scene, begin(scene))
        energies.append(step.numbers["energy"])
    assert energies[1] < 0.9 * energies[0]
    cortex = step.state["growth"][:, :, body.in_cortex]
    np.testing.assert_allclose(cortex[0], 1.2, rtol=1e-12)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_bad_rates_are_refused(rate):
    with pytest.raises(ValueError, match="rate="):
        StressGrowth(rate=rate)
