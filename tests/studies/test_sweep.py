"""Scenes with other values of their parameters, from Python and at the command line."""

import csv
import shlex
from dataclasses import replace

import pytest
from small import elastic_scene

from turingfold import Drag, NeoHookean, varied
from turingfold.cli.main import main
from turingfold.studies.sweep import read_values

CASE = '''"""A patch of cortex that grows."""
from turingfold import Elastic, NeoHookean, Scene, SelfContact, Stepping, TangentialGrowth, semicircle


def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.3, size=0.15, base="roller")
    solid, walls = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact()
    grow, steps = TangentialGrowth(cortex=1.2), Stepping(first=0.5, largest=0.5)
    def made(until):
        return Scene(body=body, terms=(solid, walls), processes=(grow,), until=until, stepping=steps)
    return {"half": made(0.5), "whole": made(1.0)}
'''


@pytest.fixture
def scene():
    return elastic_scene()


def test_every_combination_is_made_and_named(scene):
    found = varied(scene, {"TangentialGrowth.cortex": [1.1, 1.25], "Elastic.gray.mu": [2.0, 3.0, 4.0]})
    assert list(found)[:2] == ["cortex=1.1, mu=2", "cortex=1.1, mu=3"]
    assert len(found) == 6
    last = found["cortex=1.25, mu=4"]
    assert (last.processes[0].cortex, last.terms[0].gray.mu) == (1.25, 4.0)
    assert last.terms[0].gray.kappa == scene.terms[0].gray.kappa
    assert last.body is scene.body
    assert scene.processes[0].cortex != 1.25


def test_names_tell_parameters_apart_by_as_little_as_they_need(scene):
    values = {"Elastic.gray.mu": [2.0], "Elastic.gray.kappa": [4.0], "Stepping.largest": [0.5]}
    assert list(varied(scene, values)) == ["mu=2, kappa=4, largest=0.5"]
    solid = replace(scene.terms[0], white=scene.terms[0].gray)
    both = {"Elastic.gray.mu": [2.0], "Elastic.white.mu": [3.0], "Stepping.largest": [0.5]}
    found = varied(replace(scene, terms=(solid,)), both)
    assert list(found) == ["gray.mu=2, white.mu=3, largest=0.5"]
    (changed,) = found.values()
    assert (changed.terms[0].gray.mu, changed.terms[0].white.mu) == (2.0, 3.0)


def test_scene_and_steps_have_parameters_too(scene):
    found = varied(scene, {"Scene.until": [0.5], "Stepping.largest": [0.5], "Scene.seed": [7]})
    (changed,) = found.values()
    assert (changed.until, changed.stepping.largest, changed.seed) == (0.5, 0.5, 7)


def test_a_part_can_be_off(scene):
    found = varied(scene, {"TangentialGrowth": ["on", "off"]})
    assert found["TangentialGrowth=on"] == scene
    assert not found["TangentialGrowth=off"].processes
    assert found["TangentialGrowth=off"].terms == scene.terms


def test_values_are_read_in_the_kind_of_the_parameter(scene):
    assert read_values("1.1:1.3:3", scene, "TangentialGrowth.cortex") == pytest.approx([1.1, 1.2, 1.3])
    assert read_values("1,2.5", scene, "TangentialGrowth.cortex") == [1.0, 2.5]
    assert read_values("auto,mixed", scene, "Elastic.element") == ["auto", "mixed"]
    assert read_values("3,4", scene, "Scene.seed") == [3, 4]
    seeds = read_values("1:9:3", scene, "Scene.seed")
    assert seeds == [1, 5, 9]
    assert [found.seed for found in varied(scene, {"Scene.seed": seeds}).values()] == seeds
    assert read_values("on,off", scene, "Elastic") == ["on", "off"]


@pytest.mark.parametrize(
    ("parameter", "text", "message"),
    [
        ("Growth.cortex", "1", r"no Growth; it has: Scene, Stepping, Elastic.*TangentialGrowth"),
        ("TangentialGrowth.cortx", "1", r"no 'cortx'; it has: cortex"),
        ("TangentialGrowth.cortex.mean", "1", "no 'mean'; it has: no values"),
        ("TangentialGrowth.cortex", "1:2", "FIRST:LAST:COUNT"),
        ("TangentialGrowth.cortex", "high", "must be a number, such as 1"),
        ("Elastic.gray", "1", r"NeoHookean\(.*neither a number nor a word"),
        ("Scene.seed", "high", "must be a whole number, such as 0"),
        ("Scene.seed", "1:2:3", "Scene.seed=1.5 must be a whole number"),
    ],
)
def test_texts_that_say_nothing_are_refused(scene, parameter, text, message):
    with pytest.raises(ValueError, match=message):
        read_values(text, scene, parameter)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "at least|one parameter"),
        ({"TangentialGrowth.cortex": []}, "a value or more"),
        ({"TangentialGrowth.cortex": 1.2}, r"cortex=1\.2 must be a list"),
        ({"TangentialGrowth": "on"}, "'on' must be a list"),
        ({"TangentialGrowth.cortex": [1.5, 1.2, 1.50000001]}, r"values 1\.5 and 1\.50000001, both named"),
        ({"Scene.seed": [1, 1]}, "values 1 and 1, both named 'seed=1'"),
        ({"TangentialGrowth": ["on", "off"], "TangentialGrowth.cortex": [1.2]}, "cannot be varied together"),
        ({"TangentialGrowth.cortex": [1.2], "TangentialGrowth": ["on", "off"]}, "cannot be varied together"),
        ({"Elastic.gray.mu": [2.0], "Elastic.gray": [NeoHookean(mu=1.0, kappa=5.0)]}, "varied together"),
        ({"Elastic": ["on"], "Scene.Elastic": ["on"]}, "Scene has no 'Elastic'"),
        ({"TangentialGrowth": [1.2]}, r"'on' or 'off'; or vary its cortex"),
        ({"Scene": ["off"]}, "cannot be left out"),
        ({"TangentialGrowth.cortex": [-1.0]}, "cortex=-1"),
        ({"Stepping.largest": [2.0]}, "largest=2"),
        ({"Drag.coefficient": [1.0]}, "has 2 Drag"),
    ],
)
def test_values_that_a_scene_cannot_take_are_refused(scene, values, message):
    if "Drag.coefficient" in values:
        two = (*scene.terms, Drag(coefficient=1.0), Drag(coefficient=2.0))
        object.__setattr__(scene, "terms", two)  # which a scene itself would refuse
    with pytest.raises(ValueError, match=message):
        varied(scene, values)


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.py").write_text(CASE)
    return tmp_path


def test_a_sweep_makes_results_a_table_and_a_figure(case, capsys):
    words = ["sweep", "tiny.py", "--only", "whole", "--vary", "TangentialGrowth.cortex=1.1:1.3:3"]
    assert main(words) == 0
    told = capsys.readouterr().out
    assert "cortex=1.2" in told
    folder = case / "results" / "tiny-sweep"
    assert (folder / "tiny-sweep.png").read_bytes().startswith(b"\x89PNG")
    with (folder / "sweep.csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    assert [row["scene"] for row in rows] == ["cortex=1.1", "cortex=1.2", "cortex=1.3"]
    assert [float(row["growth"]) for row in rows] == pytest.approx([1.1, 1.2, 1.3], rel=0.01)
    given = [float(row["TangentialGrowth.cortex"]) for row in rows]
    assert given == pytest.approx([1.1, 1.2, 1.3], rel=1e-15)
    assert rows[0]["registration"] == rows[0]["registration_p"] == ""
    assert float(rows[0]["least_fold_depth"]) > 0
    assert main(words) == 2  # they are there already
    assert "--resume" in capsys.readouterr().err


@pytest.mark.slow
def test_all_scenes_of_a_case_are_swept_also_in_processes(case, capsys):
    words = ["sweep", "tiny.py", "--vary", "SelfContact=on,off", "-j", "2"]
    assert main(words) == 0
    folders = {path.name for path in (case / "results" / "tiny-sweep").iterdir() if path.is_dir()}
    assert folders == {f"{name}-SelfContact={word}" for name in ("half", "whole") for word in ("on", "off")}
    told = capsys.readouterr().out
    assert "whole, SelfContact=off" in told
    with (case / "results" / "tiny-sweep" / "sweep.csv").open(newline="") as table:
        rows = {row["scene"]: row["SelfContact"] for row in csv.DictReader(table)}
    assert all(name.endswith(f"={word}") for name, word in rows.items())
    assert set(rows.values()) == {"on", "off"}


SWEPT = [
    "sweep", "tiny.py", "--vary", "Elastic.element=auto,mixed", "--vary", "SelfContact=on,off",
    "--out", "a folder", "--only", "whole",
]  # fmt: skip


def said(capsys):
    return " ".join(capsys.readouterr().err.split())


def test_an_interrupted_sweep_says_how_to_go_on_with_it(case, capsys, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("turingfold.cli.point.simulate", stopped)
    assert main(SWEPT) == 130
    command = said(capsys).partition("Go on with: ")[2]
    assert shlex.split(command) == ["turingfold", *SWEPT, "--resume"]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (["Scene.until=0.5", "Scene.until=0.7"], "Scene.until is given twice"),
        (["TangentialGrowth=on,off", "TangentialGrowth.cortex=1.1,1.2"], "cannot be varied together"),
        (["TangentialGrowth.cortex=1.1,1.10000001"], "values 1.1 and 1.10000001, both named 'cortex=1.1'"),
    ],
)
def test_sweeps_whose_results_would_be_mixed_up_are_refused(case, capsys, values, message):
    assert main(["sweep", "tiny.py", *(word for value in values for word in ("--vary", value))]) == 2
    assert message in said(capsys)
    assert not (case / "results").exists()


def test_the_table_is_of_the_last_sweep(case, capsys):
    words = ["sweep", "tiny.py", "--only", "half", "--vary"]
    for cortex in ("1.1", "1.2"):
        assert main([*words, f"TangentialGrowth.cortex={cortex}"]) == 0
    folder = case / "results" / "tiny-sweep"
    rows = (folder / "sweep.csv").read_text().splitlines()
    assert [row.partition(",")[0] for row in rows] == ["scene", "cortex=1.2"]
    assert (folder / "cortex=1.1" / "states").is_dir()
    with pytest.raises(SystemExit, match="0"):
        main(["sweep", "--help"])
    explained = " ".join(capsys.readouterr().out.split())
    assert "sweep.csv and the figure there are of the last sweep alone" in explained


@pytest.mark.parametrize("words", ["", "cortex", "=1", "cortex="])
def test_what_is_no_assignment_is_refused(case, capsys, words):
    with pytest.raises(SystemExit) as stopped:
        main(["sweep", "tiny.py", "--vary", words])
    assert stopped.value.code == 2
    assert "NAME=VALUE" in capsys.readouterr().err
