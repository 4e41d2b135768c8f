"""-q, -v and --json of commands that run scenes for something else than results; units of their tables."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from test_cli_buckling import CASE as DISCS
from test_cli_fit import MAP
from test_cli_parameters import CASE

from turingfold import load
from turingfold.cli import commands
from turingfold.cli.main import main
from turingfold.verification.check import Check, Quantity

COMMANDS = {
    "accuracy": ["accuracy", "patch.py", "--quick", "--steps", "0"],
    "sensitivity": ["sensitivity", "patch.py", "--quick", "--to", "Elastic.gray.mu"],
    "fit": ["fit", "map.py", "--to", "GrowthMap.cortex.0", "--target", "1=outline.csv"],
    "buckling": ["buckling", "disc.py", "--only", "plain"],
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in {"patch": CASE, "disc": DISCS, "map": MAP}.items():
        Path(f"{name}.py").write_text(text)
    return tmp_path


@pytest.fixture
def outline(here, capsys):
    """Write the outline that the fit is to find, of a first value of 1.25."""
    assert main(["run", "map.py", "--out", "hidden", "--set", "first=1.25", "-q"]) == 0
    points = load("hidden/map/only").pial().T
    np.savetxt("outline.csv", points, delimiter=",", header="x [m],y [m]", comments="")


def answered(capsys):
    """Return the one JSON object on standard output, and what is on standard error."""
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 1
    return json.loads(out), err


def rows(file):
    with Path(file).open(newline="") as text:
        return list(csv.DictReader(text))


@pytest.mark.parametrize("command", COMMANDS)
def test_quiet_prints_nothing(outline, command, capsys):
    assert main([*COMMANDS[command], "-q"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("command", ["accuracy", "sensitivity", "fit"])
def test_verbose_prints_a_line_for_each_step(outline, command, capsys):
    assert main([*COMMANDS[command], "-v"]) == 0
    told = capsys.readouterr().err
    steps = re.findall(r"^.*: t = \S+, growth \S+, \d+ iterations, residual .*$", told, re.M)
    assert len(steps) == {"accuracy": 2, "sensitivity": 1, "fit": 2}[command]


def test_verbose_buckling_prints_the_growth_of_each_step_and_what_is_found(here, capsys):
    assert main([*COMMANDS["buckling"], "-v"]) == 0
    out, err = capsys.readouterr()
    growths = [float(own) for own in re.findall(r"^plain: t = \S+, growth (\S+), \S+ s$", err, re.M)]
    assert len(growths) > 5
    assert growths[-1] > 1.78 > growths[-2]
    assert "scene 1 of 1, plain: buckles at growth 1.7" in err
    assert "plain: t =" not in out


def test_one_object_says_how_far_the_runs_of_accuracy_are_apart(here, capsys):
    assert main([*COMMANDS["accuracy"], "--json", "--figure", "mine.svg"]) == 0
    found, err = answered(capsys)
    folder = "results/quick/patch-accuracy"
    assert (found["exit_status"], found["folder"], found["figures"]) == (0, folder, ["mine.svg"])
    assert Path("mine.svg").read_bytes().startswith(b"<?xml")
    assert [run["status"] for run in found["runs"].values()] == ["converged", "converged"]
    coarse, fine = found["series"]["only"]["mesh"]
    assert coarse["distance"] > 0 == fine["distance"]
    (first, _) = rows(found["table"])
    assert float(first["energy [J/m]"]) == coarse["energy"]
    assert float(first["distance [T]"]) == coarse["distance"]
    assert float(first["seconds"]) == coarse["seconds"]
    assert "run 2 of 2" in err


def test_one_object_has_the_sensitivities(here, capsys):
    assert main([*COMMANDS["sensitivity"], "--json"]) == 0
    found, _ = answered(capsys)
    own = found["scenes"]["only"]
    share = own["parameters"]["Elastic.gray.mu"]["per_cent_per_per_cent"]["perimeter"]
    table = {row["measure"]: row for row in rows(found["table"])}
    assert float(table["perimeter"]["per_cent_per_per_cent"]) == share
    units = {name: (row["measure_unit"], row["parameter_unit"]) for name, row in table.items()}
    assert units["perimeter"] == ("m", "Pa")
    assert units["energy"] == ("J/m", "Pa")
    assert units["gyrification_index"] == ("", "Pa")
    assert found["runs"]["only"]["status"] == "converged"
    assert Path(found["figures"][0]).is_file()


def test_one_object_has_what_was_fitted_and_a_second_fit_is_refused_before_it_begins(outline, capsys):
    assert main([*COMMANDS["fit"], "--json"]) == 0
    found, err = answered(capsys)
    assert found["parameters"]["GrowthMap.cortex.0"]["value"] == pytest.approx(1.25, rel=1e-4)
    assert found["misfits"]["1"] < 1e-4
    assert found["runs"]["only"]["summary"]["converged"]
    assert [row["unit"] for row in rows(found["table"])] == [""]
    assert "set 1 of the parameters: misfit" in err
    assert main([*COMMANDS["fit"], "--json"]) == 2
    refused, err = answered(capsys)
    assert "already holds a fit" in refused["error"]
    assert "misfit" not in err
    assert main([*COMMANDS["fit"], "--resume", "-q"]) == 0


def test_one_object_has_what_buckles_and_what_does_not(here, capsys):
    calm = DISCS.replace("cortex=1.9", "cortex=1.2")
    Path("calm.py").write_text(calm)
    assert main([*COMMANDS["buckling"], "--json", "--figure", "modes.svg"]) == 0
    found, _ = answered(capsys)
    plain = found["scenes"]["plain"]
    assert plain["growth"] == pytest.approx(1.7846, rel=0.02)
    assert (plain["half_waves"], plain["localised"], plain["limit_point"]) == (7, False, False)
    assert found["figures"] == ["modes.svg"]
    assert main(["buckling", "calm.py", "--only", "plain", "--json"]) == 3
    found, err = answered(capsys)
    assert found["scenes"]["plain"]["growth"] is None
    assert "No loss of stability" in found["scenes"]["plain"]["message"]
    assert "No loss of stability" in err


def test_what_verify_finds_wrong_is_an_error_also_of_a_quiet_one(monkeypatch, capsys):
    from turingfold.verification import registry

    check = Check("A problem", lambda: [Quantity("two", 2.0, 2.5, 0.1), Quantity("one", 1.0, 1.0, 0.1)], "us")
    monkeypatch.setattr(registry, "checks", lambda words, *, full: [check])
    assert main(["verify", "-q"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "A problem: two is 2.5, expected 2" in err
    assert "one is" not in err
    assert main(["verify", "--json"]) == 3
    found, _ = answered(capsys)
    assert [(row["quantity"], row["holds"]) for row in found["numbers"]] == [("two", False), ("one", True)]


def test_commands_that_show_what_is_there_answer_with_one_object_too(here, capsys):
    sweep = ["sweep", "patch.py", "--quick", "--vary", "cortex=1.04,1.05"]
    assert main([*sweep, "--out", "o", "--keep", "all", "-q"]) == 0
    capsys.readouterr()
    folder = "o/patch-sweep"
    assert main(["collect", folder, "--json"]) == 0
    found, _ = answered(capsys)
    assert found == {
        "exit_status": 0, "folder": folder, "table": f"{folder}/sweep.csv", "points": {"converged": 2},
    }  # fmt: skip
    assert main(["plot", folder, "--x", "cortex", "--figure", "p.svg", "--json"]) == 0
    assert answered(capsys)[0]["figures"] == ["p.svg"]
    one, two = f"{folder}/cortex=1.04", f"{folder}/cortex=1.05"
    assert main(["compare", one, two, "--json"]) == 0
    found, err = answered(capsys)
    length = next(row for row in found["measures"] if "length" in row["name"] or "perimeter" in row["name"])
    assert length["ratio"] == pytest.approx(length["b"] / length["a"])
    assert length["name"] in err
    assert main(["stability", "Schnakenberg", "--half-waves", "6", "--json"]) == 0
    found, _ = answered(capsys)
    assert found["unstable"]
    assert 6 in found["growing_half_waves"]
    assert found["ratio"] > found["critical_ratio"]
    assert main(["animate", one, "--json", "--figure", "f.gif"]) == 0
    assert answered(capsys)[0]["figures"] == ["f.gif"]
    for words in (["collect", folder], ["compare", one, two], ["stability", "Schnakenberg"]):
        assert main([*words, "-q"]) == 0
        assert capsys.readouterr() == ("", "")


def test_every_command_that_prints_numbers_takes_the_same_words():
    """`app` serves; `list`, `new` and `completion` print what is for people or for a shell."""
    from turingfold.cli.parser import parser

    (actions,) = (one for one in parser()._actions if one.choices)
    assert set(actions.choices) == set(commands.COMMANDS)
    words = {
        name: {word for action in own._actions for word in action.option_strings}
        for name, own in actions.choices.items()
    }
    silent = {"app", "list", "new", "completion", "doctor"}
    assert {name for name, own in words.items() if not {"-q", "--quiet", "--json"} <= own} == silent
    steps = {"run", "sweep", "accuracy", "sensitivity", "fit", "buckling", "atlas"}
    assert {name for name, own in words.items() if {"-v", "--verbose"} <= own} == steps


def test_a_figure_of_an_earlier_command_is_not_taken_for_that_of_one_that_failed(here, capsys):
    words = "mine.png is of an earlier command; this one has drawn nothing there."

    def status(*asked):
        return main([*asked, "--figure", "mine.png"])

    assert status("run", "patch.py", "--set", "young=-1") == 2
    assert words not in capsys.readouterr().err  # there is none yet
    assert status("stability", "Schnakenberg", "--param", "a=0.1") == 0
    first = Path("mine.png").read_bytes()
    assert status("stability", "Schnakenberg", "--param", "a=0.15") == 0
    assert words not in capsys.readouterr().err
    second = Path("mine.png").read_bytes()
    assert second != first
    for failing in (
        ("stability", "Schnakenberg", "--param", "c=1"),
        ("run", "patch.py", "--set", "young=-1", "-q"),
    ):
        assert status(*failing) == 2
        assert words in " ".join(capsys.readouterr().err.split())
        assert Path("mine.png").read_bytes() == second
