"""Estimated errors of the steps against those that steps an eighth as long show: within a factor of three."""

import json
from dataclasses import replace

import pytest
from small import GRAY, elastic_scene

from turingfold import (
    Drag,
    Elastic,
    Inertia,
    Scene,
    Stepping,
    StiffnessDamping,
    StressGrowth,
    TangentialGrowth,
    load,
    semicircle,
    simulate,
)
from turingfold.results.carried import NoEstimateError
from turingfold.results.measures import shape_numbers
from turingfold.results.step_error import step_errors

BODY = semicircle(radius=1.0, thickness=0.25, size=0.25, base="roller")
SOLID = Elastic(gray=GRAY)
DAMPING = StiffnessDamping(elastic=SOLID, time=0.1)
TOLD = ("energy", "perimeter")  # the others are those of a smooth body


def moving(*terms, scheme="euler", processes=()):
    """Return a scene that 10 steps leave far from its limit."""
    processes = (TangentialGrowth(cortex=1.3), *processes)
    stepping = Stepping(first=0.1, largest=0.1, scheme=scheme)
    return Scene(body=BODY, terms=(SOLID, *terms), processes=processes, stepping=stepping)


SCENES = {
    "drag": lambda: moving(Drag(coefficient=1.0)),
    "strong drag": lambda: moving(Drag(coefficient=100.0)),
    "growth by stress": lambda: moving(processes=(StressGrowth(rate=1.0),)),
    "both": lambda: moving(Drag(coefficient=100.0), processes=(StressGrowth(rate=1.0),)),
    "inertia": lambda: moving(Inertia(density=1.0), DAMPING),
    "inertia by the midpoint rule": lambda: moving(Inertia(density=1.0), DAMPING, scheme="midpoint"),
}


def numbers(result):
    found = shape_numbers(result.scene.body, result.last["displacement"])
    return found | {"energy": result.history[-1]["energy"]}


def shorter(scene, n):
    now = scene.stepping
    return replace(scene, stepping=replace(now, first=now.first / n, largest=now.largest / n))


@pytest.mark.parametrize("name", SCENES)
def test_estimates_are_within_a_factor_of_three(name):
    scene = SCENES[name]()
    result = simulate(scene, errors=True)
    found, (half, fine) = numbers(result), (numbers(simulate(shorter(scene, n))) for n in (4, 8))
    again = 1 / 3 if scene.stepping.scheme == "midpoint" else 1.0
    for number in TOLD:
        true = abs(fine[number] + again * (fine[number] - half[number]) - found[number])
        assert 1 / 3 < result.step_errors[number] / true < 3, number


def test_an_equilibrium_does_not_depend_on_its_steps():
    scene = elastic_scene()
    result = simulate(scene, errors=True)
    assert set(result.step_errors) == set(result.errors)
    assert not any(result.step_errors.values())
    assert result.error("energy") == result.errors["energy"] > 0
    there, fine = numbers(result), numbers(simulate(shorter(scene, 4)))
    assert fine["energy"] == pytest.approx(there["energy"], rel=1e-9)


def test_too_few_steps_and_longer_ones_that_do_not_get_there_have_none():
    scene, drag = elastic_scene(), moving(Drag(coefficient=1.0))
    state = simulate(scene).last
    with pytest.raises(NoEstimateError, match="3 step"):
        step_errors(drag, (0.3, 0.6, 1.0), state, 0.0)
    hurried = replace(drag, stepping=replace(drag.stepping, seconds=1e-9))
    with pytest.raises(NoEstimateError, match="time limit"):
        step_errors(hurried, (0.2, 0.5, 0.7, 1.0), state, 0.0)


def test_they_are_kept_in_the_folder_null_where_there_are_none(tmp_path):
    moved = simulate(moving(Drag(coefficient=1.0)), tmp_path / "moved")
    assert moved.step_errors["energy"] > 0
    assert moved.error("energy") is None  # as that of the mesh is not known
    assert load(tmp_path / "moved").step_errors == moved.step_errors
    simulate(elastic_scene(), tmp_path / "off", errors=False)
    kept, off = (json.loads((tmp_path / name / "summary.json").read_text()) for name in ("moved", "off"))
    assert kept["step_errors"] == moved.step_errors
    assert off["step_errors"] is None


def test_an_interrupted_estimate_leaves_the_result(tmp_path, monkeypatch):
    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr("turingfold.results.step_error.step_errors", interrupted)
    with pytest.raises(KeyboardInterrupt):
        simulate(elastic_scene(), tmp_path)
    kept = load(tmp_path)
    assert kept.converged
    assert kept.no_step_errors == "The estimate was interrupted."
