"""turingfold accuracy: trials, their differences, the table and the figure."""

import csv
import shlex
from dataclasses import replace

import numpy as np
import pytest
from small import elastic_scene

from turingfold import Drag, Stepping, TangentialGrowth, outline, semicircle, simulate
from turingfold.cli.main import main
from turingfold.geometry.curve import Curve
from turingfold.studies.accuracy import Difference, compared, told, trials

CASE = '''"""A small one."""
from turingfold import *

def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.25, size=0.25)
    elastic, grow = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), TangentialGrowth(cortex=1.3)
    stepping = Stepping(first=0.5, largest=0.5)
    return {"disc, small": Scene(body=body, terms=(elastic,), processes=(grow,), stepping=stepping)}
'''


def scene(**options):
    return elastic_scene(body=semicircle(radius=1.0, thickness=0.25, size=0.25, base="roller"), **options)


def test_trials_are_named_and_ordered():
    found = trials(scene(), meshes=2, steps=1)
    assert list(found) == ["as it is", "mesh x2", "mesh x4", "steps x2"]
    sizes = [found[name].body.mesh.nelements for name in ("as it is", "mesh x2", "mesh x4")]
    assert sizes[1:] == [4 * sizes[0], 16 * sizes[0]]
    assert found["steps x2"].stepping.largest == 0.5 * scene().stepping.largest
    assert replace(found["steps x2"], stepping=scene().stepping, body=scene().body).terms == scene().terms


@pytest.mark.parametrize(("meshes", "steps"), [(0, 0), (-1, 2), (1, 0.5)])
def test_trials_of_nothing_are_refused(meshes, steps):
    with pytest.raises(ValueError, match=r"meshes|steps"):
        trials(scene(), meshes=meshes, steps=steps)


def test_differences_are_those_of_the_results():
    made = trials(scene(), meshes=2, steps=1)
    results = {name: simulate(made[name]) for name in made}
    series = compared(results)
    assert [trial.finer for trial in series["mesh"]] == [1, 2, 4]
    assert [trial.finer for trial in series["steps"]] == [1, 2]
    coarse, finest = results["as it is"], results["mesh x4"]
    first, second, last = series["mesh"]
    energies = coarse.history[-1]["energy"], finest.history[-1]["energy"]
    assert first.energy_error == pytest.approx(abs(energies[0] / energies[1] - 1), rel=1e-12)
    assert first.energy == energies[0]
    assert first.gyrification == coarse.summary()["gyrification_index"]
    # the distance of material points is at least that of the outlines
    apart = Curve(finest.pial(), False).nearest(coarse.pial())[0].max() / 0.25
    assert apart <= first.distance * (1 + 1e-9) < 0.2
    assert first.distance > 4 * second.distance
    assert first.energy_error > 4 * second.energy_error
    assert (last.energy_error, last.gyrification_error, last.distance) == (0.0, 0.0, 0.0)
    assert series["steps"][0].energy_error < 1e-12  # elasticity knows no steps


def test_halved_steps_show_the_order_of_the_drag():
    steps = Stepping(first=0.25, largest=0.25)
    elastic = scene(stepping=steps)
    made = trials(replace(elastic, terms=(*elastic.terms, Drag(coefficient=1.0))), meshes=0, steps=3)
    series = compared({name: simulate(made[name]) for name in made})
    assert list(series) == ["steps"]
    assert [trial.steps for trial in series["steps"]] == [4, 8, 16, 32]
    # against h/8, errors of first order are as 7 : 3 : 1
    distances = [trial.distance for trial in series["steps"][:3]]
    assert distances[0] / distances[2] == pytest.approx(7, rel=0.05)
    assert distances[1] / distances[2] == pytest.approx(3, rel=0.05)


def test_rigid_motion_of_a_free_body_is_no_difference():
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    body = outline(np.stack([1.2 * np.cos(angle), np.sin(angle + 0.3)]), thickness=0.25, size=0.25)
    assert len(body.fixed) == 3
    result = simulate(elastic_scene(body=body))
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    moved = turn @ (body.nodes + result.last["displacement"]) + np.array([[0.4], [-0.2]]) - body.nodes
    states = (*result.states[:-1], result.last.updated(displacement=moved))
    series = compared({"as it is": replace(result, states=states), "steps x2": result})
    assert series["steps"][0].distance < 1e-12


def test_only_whole_runs_of_a_scene_are_compared():
    result = simulate(scene())
    with pytest.raises(ValueError, match="as it is"):
        compared({"mesh x2": result})
    with pytest.raises(ValueError, match=r"'mesh x2' stopped at t = 1"):
        compared({"as it is": result, "mesh x2": replace(result, status="stopped")})


def test_no_energy_at_all_is_no_large_error_of_it():
    series = compared({name: simulate(one) for name, one in trials(scene_at_rest(), steps=0).items()})
    assert series["mesh"][0].energy_error < 1e-2


def scene_at_rest():
    return replace(scene(), processes=(TangentialGrowth(cortex=1.0),))


def test_other_numbers_of_sulci_are_pointed_out():
    trial = Difference(1, 2.0, 100, 10, 1.0, 3, 1.0, 1.0, 0.1, 0.1, 0.1)
    words = "\n".join(told({"mesh": [trial, replace(trial, finer=2)]}))
    assert "differs" not in words
    assert "compared" in words
    assert "differs" in "\n".join(told({"mesh": [trial, replace(trial, finer=2, folds=4)]}))


def test_the_command_writes_table_and_figure_of_whole_runs_only(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results" / "small-accuracy"
    folder.mkdir(parents=True)
    made = folder / "accuracy.csv", folder / "small-accuracy.png"
    for file in made:
        file.write_text("of an earlier run")
    (tmp_path / "small.py").write_text(CASE.replace("largest=0.5", "largest=0.5, seconds=1e-6"))
    assert main(["accuracy", "small.py"]) == 3
    assert not any(file.exists() for file in made)
    (tmp_path / "small.py").write_text(CASE)
    assert main(["accuracy", "small.py", "--resume"]) == 0
    told_, progress = capsys.readouterr()
    assert "turingfold: run 3 of 3, disc, small, steps x2: converged\n" in progress
    assert (folder / "small-accuracy.png").read_bytes().startswith(b"\x89PNG")
    with (folder / "accuracy.csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    assert [(row["scene"], row["series"], row["finer"]) for row in rows] == [
        ("disc, small", "mesh", "1"), ("disc, small", "mesh", "2"),
        ("disc, small", "steps", "1"), ("disc, small", "steps", "2"),
    ]  # fmt: skip
    errors = [float(row["energy_error"]) for row in rows[:2]]
    assert errors[0] > errors[1] == 0.0
    assert f"{errors[0]:.1e}" in told_


def test_an_interrupted_run_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.py").write_text(CASE)

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("turingfold.cli.workers.simulate", stopped)
    words = ["accuracy", "small.py", "--meshes", "1", "--steps", "2"]
    assert main(words) == 130
    command = " ".join(capsys.readouterr().err.split()).partition("Go on with: ")[2]
    assert shlex.split(command) == ["turingfold", *words, "--resume"]


def test_an_interrupt_before_the_start_is_no_crash(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def stopped(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("turingfold.cli.accuracy.find_case", stopped)
    assert main(["accuracy", "small.py"]) == 130
    assert "stopped." in capsys.readouterr().err
