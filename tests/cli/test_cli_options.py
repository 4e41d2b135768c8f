"""Options of running: what is printed, how long scenes may run, what is kept, where the figure goes."""

import argparse
import json
import re
from pathlib import Path

import pytest
from test_cli import GROWS, INTERRUPTED, STOPS, TWO, unwrapped, written  # noqa: F401  (a fixture)

from turingfold import load
from turingfold.cli import commands
from turingfold.cli.main import main
from turingfold.cli.parser import parser
from turingfold.cli.progress import Shares, duration, watching
from turingfold.cli.request import Telling


@pytest.fixture
def case(written):  # noqa: F811
    """Write a case that prints, and return its name."""
    name = written(TWO, step=0.5)
    with Path(name).open("a") as file:
        file.write('\n\nprint("a case may print")\n')
    return name


def answer(capsys):
    """Return what is on standard output, which must be one JSON object, and what is on standard error."""
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 1
    return json.loads(out), err


def test_one_json_object_says_what_became_of_a_run(case, capsys):
    assert main(["run", case, "--json"]) == 0
    found, err = answer(capsys)
    assert "a case may print" in err
    assert "figure: results/tiny/tiny.png" in err
    assert (found["exit_status"], found["case"], found["folder"]) == (0, "tiny", "results/tiny")
    assert found["figures"] == ["results/tiny/tiny.png"]
    assert found["table"] is None
    scene = found["scenes"]["second one"]
    assert (scene["status"], scene["folder"]) == ("converged", "results/tiny/second-one")
    stored = json.loads(Path("results/tiny/second-one/summary.json").read_text())
    assert scene["summary"] == {name: value for name, value in stored.items() if name != "sha256"}
    assert main(["draw", case, "--json"]) == 0
    found, _ = answer(capsys)
    assert found == {"exit_status": 0, "case": "tiny", "folder": "results/tiny",
                     "figures": ["results/tiny/tiny.png"]}  # fmt: skip


def test_one_json_object_says_what_failed(written, capsys):  # noqa: F811
    case = written(STOPS)
    assert main(["run", case, "--json"]) == 3
    found, _ = answer(capsys)
    assert found["exit_status"] == 3
    assert {name: scene["status"] for name, scene in found["scenes"].items()} == {
        "stops": "stopped", "grows": "converged",
    }  # fmt: skip
    assert "it stumbled" in found["scenes"]["stops"]["message"]
    assert main(["run", case, "--json"]) == 2
    found, err = answer(capsys)
    assert found["exit_status"] == 2
    assert "already holds this result" in found["error"]
    assert "already holds this result" in " ".join(err.split())


def test_one_json_object_says_what_became_of_a_sweep(case, capsys):
    words = ["sweep", case, "--only", "first one", "--vary", "TangentialGrowth.cortex=1.1,-1,1.2", "--json"]
    assert main([*words[:-2], "TangentialGrowth.cortex=1.1,1.2", "--json"]) == 0
    found, _ = answer(capsys)
    assert found["table"] == "results/tiny-sweep/sweep.csv"
    assert found["figures"] == ["results/tiny-sweep/tiny-sweep.png"]
    growths = [(one["varied"], one["status"], one["summary"]["growth"]) for one in found["points"]]
    assert growths == [
        ({"TangentialGrowth.cortex": value}, "converged", pytest.approx(value)) for value in (1.1, 1.2)
    ]


@pytest.mark.slow  # two processes are started
def test_what_a_case_prints_in_other_processes_is_no_answer(case, capfd):
    assert main(["run", case, "--json", "-j", "2"]) == 0
    found, err = answer(capfd)
    assert found["scenes"].keys() == {"first one", "second one"}
    assert err.count("a case may print") == 3


def test_quiet_commands_print_errors_only(case, capsys):
    assert main(["run", case, "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main(["draw", case, "-q"]) == 0
    assert main(["sweep", case, "--only", "first one", "--vary", "TangentialGrowth.cortex=1.1", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main(["run", case, "-q", "--json"]) == 2
    found, err = answer(capsys)
    assert "already holds" in found["error"]
    assert "already holds" in " ".join(err.split())


def test_verbose_commands_print_a_line_for_each_step(written, capsys):  # noqa: F811
    assert main(["run", written(GROWS), "-v"]) == 0
    out, err = capsys.readouterr()
    steps = re.findall(r"^grows: t = (\S+), growth \S+, \d+ iterations, residual \S+, \S+ s$", err, re.M)
    assert steps == ["0.25", "0.5", "0.75", "1"]
    (parts,) = re.findall(r"^time, grows: (.*)$", out, re.M)
    seconds = [float(words.split()[-2]) for words in parts.split(", ")]
    assert seconds == sorted(seconds, reverse=True)


@pytest.mark.parametrize("kind", [".pdf", ".svg"])
def test_the_figure_goes_where_it_is_wanted_and_nowhere_else(written, kind):  # noqa: F811
    Path("cases").mkdir()
    case, file = written(GROWS, "cases/tiny.py", step=1.0), Path(f"mine{kind}")
    begins = {".pdf": b"%PDF", ".svg": b"<?xml"}[kind]
    sweep = ["sweep", case, "--vary", "TangentialGrowth.cortex=1.1,1.2"]
    for command in (["run", case], ["draw", case], sweep):
        assert main([*command, "--figure", str(file)]) == 0
        assert file.read_bytes().startswith(begins)
        file.unlink()
    assert not list(Path().rglob("*.png"))
    assert not Path("figures").exists()


def test_a_figure_that_cannot_be_drawn_is_refused_before_anything_runs(written, capsys):  # noqa: F811
    case = written(TWO)
    assert main(["run", case, "--only", "second one", "--figure", "mine.png"]) == 2
    assert "--figure: a figure shows all scenes, and these have no result yet: first one" in unwrapped(capsys)
    Path(case).write_text(Path(case).read_text().partition("def draw")[0])
    assert main(["run", case, "--figure", "mine.png"]) == 2
    assert "has no function draw" in unwrapped(capsys)
    assert not Path("results").exists()


def test_a_time_limit_stops_a_scene_which_goes_on_as_if_it_had_not_been(written, capsys):  # noqa: F811
    case = written(GROWS, step=0.04)
    assert main(["run", case, "--max-seconds", "0.005"]) == 3
    assert "the time limit of 0.005 s is reached" in unwrapped(capsys)
    result = load_unfinished("results/tiny/grows")
    assert result.status == "stopped"
    assert result.last.time == (result.history[-1]["time"] if result.history else 0.0)
    assert len(result.history) < 25
    assert main(["run", case, "--resume"]) == 0
    assert main(["run", case, "--out", "whole"]) == 0
    parts, whole = (load(f"{folder}/tiny/grows") for folder in ("results", "whole"))
    assert [row["energy"] for row in parts.history] == [row["energy"] for row in whole.history]


def load_unfinished(folder):
    with pytest.warns(UserWarning, match="stopped"):
        return load(folder)


def test_a_time_limit_stops_points_of_a_study(written, capsys):  # noqa: F811
    case = written(GROWS, step=0.04)
    words = ["sweep", case, "--vary", "TangentialGrowth.cortex=1.1", "--keep", "summary"]
    assert main([*words, "--max-seconds", "0.005"]) == 3
    assert "the time limit of 0.005 s is reached" in unwrapped(capsys)
    assert main([*words, "--resume"]) == 0


def test_as_many_states_are_kept_as_are_wanted_and_none_for_paraview(written):  # noqa: F811
    case = written(GROWS, step=0.1)
    assert main(["run", case, "--frames", "2", "--no-vtu"]) == 0
    folder = Path("results/tiny/grows")
    assert [state.time for state in load(folder).states] == pytest.approx([0.0, 0.5, 1.0])
    assert not [*folder.glob("frames*"), *folder.rglob("*.vtu")]
    sweep = ["sweep", case, "--vary", "TangentialGrowth.cortex=1.1"]
    assert main([*sweep, "--keep", "all", "--frames", "5"]) == 0
    point = Path("results/tiny-sweep/cortex=1.1")
    assert len(load(point).states) == 6
    assert len(list(point.glob("frames/*.vtu"))) == 6
    assert main([*sweep, "--no-vtu", "--overwrite"]) == 0
    assert len(load(point).states) == 1
    assert not list(point.rglob("*.vtu"))


def test_the_command_that_goes_on_has_the_same_options(written, capsys):  # noqa: F811
    case = written(INTERRUPTED, step=0.25)
    options = ["--figure", "mine.pdf", "--max-seconds", "60", "--frames", "3", "--no-vtu"]
    assert main(["run", case, *options]) == 130
    assert f"turingfold run {case} {' '.join(options)} --resume" in unwrapped(capsys)


REFUSED = [
    *(["draw", "figure3", *words] for words in (["-v"], ["--max-seconds", "1"], ["--frames", "2"])),
    *(["accuracy", "figure3", *words] for words in (["--max-seconds", "1"], ["--no-vtu"])),
    ["sweep", "figure3", "--no-errors"],
    ["fit", "figure3", "--target", "1=a.csv", "--to", "a", "--jobs", "2"],
]  # fmt: skip


@pytest.mark.parametrize("words", REFUSED, ids=" ".join)
def test_an_option_that_a_command_could_not_heed_is_refused_by_name(capsys, words):
    with pytest.raises(SystemExit) as ending:
        main(words)
    assert ending.value.code == 2
    option = next(word for word in words[2:] if word.startswith("-") and word not in ("--target", "--to"))
    assert f"unrecognized arguments: {option}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--figure", "a.png", "--keep", "summary"], "as --keep summary keeps no states"),
        (["--figure", "a.png", "--task", "1/2"], "--figure: nothing is drawn, as --task"),
        (["--frames", "3"], "--frames: only --keep all keeps the states of points"),
        (["--no-vtu", "--keep", "summary"], "--no-vtu: --keep summary writes no states"),
        (["-j", "2", "--dask", "tcp://nowhere:1"], "--jobs: the cluster has workers of its own"),
        (["-v", "--dask", "local"], "--verbose: a cluster does not tell of steps"),
    ],
)
def test_options_that_a_study_could_not_heed_are_refused(written, capsys, words, said):  # noqa: F811
    assert main(["sweep", written(GROWS), "--vary", "TangentialGrowth.cortex=1.1,1.2", *words]) == 2
    assert said in unwrapped(capsys)
    assert not Path("results").exists()


@pytest.mark.parametrize(
    "words", [["--max-seconds", "0"], ["--max-seconds", "nan"], ["--frames", "0"], ["-q", "-v"],
              ["--figure", "mine.txt"]],
)  # fmt: skip
def test_values_that_mean_nothing_are_refused(capsys, words):
    with pytest.raises(SystemExit) as ending:
        main(["run", "figure3", *words])
    assert ending.value.code == 2
    assert words[0] in capsys.readouterr().err or words[0] == "-q"


class Recording(argparse.Namespace):
    """Options that remember which of them were read."""

    def __getattribute__(self, name):
        if not name.startswith("_"):
            super().__getattribute__("__dict__").setdefault("_read", set()).add(name)
        return super().__getattribute__(name)


SHARED = {  # commands that share arguments
    "run": [], "sweep": ["--vary", "a=1"], "accuracy": [], "sensitivity": [], "draw": [], "buckling": [],
    "fit": ["--target", "1=a.csv", "--to", "b"],
}  # fmt: skip
OF_ALL = {"command", "version", "threads", "debug", "json", "quiet"}  # main reads them


@pytest.mark.parametrize("name", SHARED)
def test_every_option_of_a_command_is_read(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    options = parser().parse_args([name, "nowhere.py", *SHARED[name]], Recording())
    with pytest.raises(ValueError, match="no case file"):
        commands.COMMANDS[name](options)
    asked = {key for key in vars(options) if not key.startswith("_")}
    assert asked - OF_ALL - vars(options)["_read"] == set()


ROW = {"growth": 1.1, "newton_iterations": 3, "residual": 1e-9, "seconds": 0.1}


def test_the_time_left_is_that_of_all_scenes(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("turingfold.cli.progress.perf_counter", lambda: clock[0])
    shares = Shares({"a": 1.0, "b": 2.0, "c": 1.0})
    assert shares.left() == ""
    clock[0] = 10.0
    shares.reached("a", {**ROW, "time": 0.5, "step": 0.5})
    assert shares.total == pytest.approx(0.5 / 3)
    assert shares.left() == "about 50 s left"  # half a scene in 10 s, two and a half to go
    shares.reached("b", {**ROW, "time": 1.5, "step": 0.5})  # it goes on from 1.0, half of its way
    clock[0] = 15.0
    assert shares.left() == "about 35 s left"  # three quarters in 15 s, one and three quarters to go
    shares.finished("a")
    shares.finished("b")
    assert shares.counted("scenes") == "2 of 3 scenes"
    assert shares.left() == "about 10 s left"  # one and a half in 15 s
    shares.finished("c")
    assert (shares.total, shares.left()) == (1.0, "")


@pytest.mark.parametrize(("seconds", "words"), [(59.6, "60 s"), (600, "10 min"), (9000, "2.5 h")])
def test_durations_have_units_that_suit_them(seconds, words):
    assert duration(seconds) == words


def test_lines_of_progress_where_there_is_no_terminal(monkeypatch, capsys):
    clock = [0.0]
    monkeypatch.setattr("turingfold.cli.progress.perf_counter", lambda: clock[0])
    with watching({"one": 1.0, "two": 1.0}, Telling.OVERALL) as watch:
        for step in range(1, 101):
            clock[0] += 1.0
            watch.row("one", {**ROW, "time": step / 100, "step": 0.01}, 3 * step)
        watch.ended("one")
    lines = capsys.readouterr().err.splitlines()
    assert lines == [f" {10 * k}%, 0 of 2 scenes, one at growth 1.100, about {words} left" for k, words in
                     enumerate(("3 min", "3 min", "2 min", "2 min", "2 min"), start=1)]  # fmt: skip


def test_one_bar_for_all_scenes_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "150")
    with watching({"one [bold]": 1.0, "two": 1.0}, Telling.OVERALL) as watch:
        watch.row("one [bold]", {**ROW, "time": 0.5, "step": 0.5}, 3)
        watch.ended("two")
    line = [line for line in capsys.readouterr().err.splitlines() if "%" in line][-1]
    assert "1 of 2 scenes, one [bold] at growth 1.100, about 0 s left" in line
    assert " 75%" in line


def test_logs_have_the_command_with_its_options(written):  # noqa: F811
    case = written(GROWS, step=1.0)
    assert main(["run", case, "--frames", "2", "--no-errors"]) == 0
    assert (
        f" turingfold run {case} --no-errors --frames 2\n" in Path("results/tiny/grows/log.txt").read_text()
    )
    assert main(["sweep", case, "--vary", "TangentialGrowth.cortex=1.1"]) == 0
    log = Path("results/tiny-sweep/cortex=1.1/log.txt").read_text()
    assert f" turingfold sweep {case} --vary TangentialGrowth.cortex=1.1\n" in log
