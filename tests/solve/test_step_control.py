"""Steps of a motion within an error: the estimate on a known motion, lengths of steps, what is refused."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from small import elastic_scene

from turingfold import (
    Drag,
    Inertia,
    Scene,
    Stepping,
    StoppedError,
    Table,
    TangentialGrowth,
    simulate,
)
from turingfold.solve.prediction import Past
from turingfold.solve.step_control import TOLERATED, error_of_step


@pytest.mark.parametrize("times", [(0.0, 0.1, 0.2), (0.0, 0.3, 0.4)])
def test_the_error_is_half_the_acceleration_times_the_step_squared(times):
    # u = (3 t, 4 t) t: the acceleration is 10 everywhere
    direction = np.array([[3.0], [4.0]]) * np.ones((2, 5))
    states = [Past(t, direction * t**2) for t in times]
    dt = times[2] - times[1]
    found = error_of_step(tuple(states[:2]), times[2], states[2].displacement)
    assert found == pytest.approx(0.5 * 10 * dt**2, rel=1e-12)


def test_a_body_at_even_speed_has_no_error_and_one_that_starts_from_rest_has():
    states = [Past(t, t * np.ones((2, 3))) for t in (0.0, 0.2, 0.3)]
    assert error_of_step(tuple(states[:2]), 0.3, states[2].displacement) == pytest.approx(0.0, abs=1e-15)
    assert error_of_step(tuple(states[:1]), 0.2, states[1].displacement) == pytest.approx(0.1 * np.sqrt(2))


def moved(bound, **options):
    """Return a body that grows within 0.1 of its time and comes to rest in the remaining 0.9."""
    grow = TangentialGrowth(cortex=1.3, history=Table(times=(0.0, 0.2), shares=(0.0, 1.0)))
    scene = elastic_scene(grow)
    terms = (*scene.terms, Inertia(density=0.1), Drag(coefficient=1.0))
    stepping = Stepping(first=1e-3, largest=0.1, local_error=bound, **options)
    return replace(scene, terms=terms, until=2.0, stepping=stepping)


def errors(result):
    states = result.states
    found = [0.0]
    for k in range(1, len(states)):
        past = tuple(Past(s.time, s["displacement"]) for s in states[max(0, k - 2) : k])
        found.append(error_of_step(past, states[k].time, states[k]["displacement"]))
    return np.array(found[1:])


def test_steps_keep_the_bound_and_are_long_where_nothing_happens():
    results = [simulate(moved(bound)) for bound in (1e-3, 2.5e-4)]
    for result, bound in zip(results, (1e-3, 2.5e-4), strict=True):
        assert result.converged
        assert errors(result).max() <= TOLERATED * bound * (1 + 1e-9)
    # the error goes with the square of the step: a quarter of it takes steps half as long while it binds
    early = [sum(1 for row in result.history if row["time"] < 0.4) for result in results]
    assert 1.6 < early[1] / early[0] < 2.4
    steps = [row["step"] for row in results[1].history]
    assert max(steps) > 10 * min(steps[1:])
    assert all(after < 1.31 * before for before, after in pairwise(steps))


@pytest.mark.slow
def test_the_peak_of_kinetic_energy_converges_as_the_bound_is_halved():
    peaks = [max(row["kinetic_energy"] for row in simulate(moved(b)).history) for b in (4e-4, 2e-4, 1e-4)]
    changes = np.abs(np.diff(peaks)) / peaks[-1]
    assert changes[1] < 0.1
    assert changes[1] < changes[0]


def test_a_bound_that_no_step_keeps_stops_the_march_with_what_to_try():
    with pytest.raises(StoppedError, match=r"is off by .* more than Stepping\(local_error=1e-09\)"):
        simulate(moved(1e-9, smallest=1e-4))


def test_equilibria_are_refused_as_they_may_jump():
    scene = elastic_scene()
    with pytest.raises(ValueError, match=r"local_error=0.001\) is about a motion, but no term resists any"):
        Scene(body=scene.body, terms=scene.terms, stepping=Stepping(local_error=1e-3))
    with pytest.raises(ValueError, match="local_error=-1 must be positive"):
        Stepping(local_error=-1.0)
