"""The command line as people use it: cases by name, copies, pipes, notebooks, killed processes."""

import csv
import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from test_cli import DIES, GROWS, TWO, unwrapped, written  # noqa: F401  (a fixture)
from test_cli_parameters import CASE

from turingfold import load
from turingfold.cli.case import check_apart, folder_name
from turingfold.cli.files import SHIPPED, shipped
from turingfold.cli.main import main
from turingfold.figures import grid

ROOT = Path(__file__).parents[2]


def test_the_command_alone_names_its_commands_and_version(capsys):
    assert main([]) == 0
    out = capsys.readouterr().out
    for name in ("run", "sweep", "list", "new", "draw", "stability", "compare"):
        assert re.search(rf"^    {name}\s+\w", out, re.MULTILINE)
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.split() == ["turingfold", "0.1.0"]


def test_cases_come_with_the_package_and_a_file_here_wins(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert shipped().keys() == {path.stem for path in (ROOT / "cases").glob("*.py")}
    assert SHIPPED == ROOT / "cases"
    assert main(["list", "figure3"]) == 0
    out = capsys.readouterr().out
    assert "Figure 3: pattern, tension" in out
    assert "--set thickness=0.0025" in out
    assert "thickness of the cortex" in out
    assert "    three hypotheses" in out
    Path("figure3.py").write_text(CASE)
    assert main(["list", "figure3"]) == 0
    assert "A patch of cortex" in capsys.readouterr().out


def test_a_copy_of_a_case_runs_under_its_own_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "mine.py", "--from", "figure2"]) == 0
    assert "turingfold run mine.py" in capsys.readouterr().out
    text = Path("mine.py").read_text()
    assert "turingfold run mine.py" in text
    assert "cases/figure2.py" not in text
    assert main(["list", "mine"]) == 0
    assert main(["new", "mine.py"]) == 2
    assert "mine.py is there already" in unwrapped(capsys)
    assert main(["new", "mine.txt"]) == 2
    assert main(["new", "other.py", "--from", "figure9"]) == 2
    assert "no case figure9; did you mean figure3?" in unwrapped(capsys)
    assert not Path("other.py").exists()


def test_a_case_without_its_files_is_listed_all_the_same(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "999")
    monkeypatch.setenv("FERRET_OUTLINES", str(tmp_path / "nowhere"))
    assert main(["list", "ferret_outlines"]) == 0  # as in a fresh clone
    out = capsys.readouterr().out
    assert "Ferret, real outlines" in out
    assert f"needs a file that is not here: there is no folder {tmp_path / 'nowhere'}" in out


def test_a_case_is_a_script_too(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    end = 'if __name__ == "__main__":\n    from turingfold import run_case\n    run_case(__file__)\n'
    Path("patch.py").write_text(f"{CASE}\n\n{end}")
    monkeypatch.setattr(sys, "argv", ["patch.py", "--quick", "--set", "thickness=8e-3"])
    with pytest.raises(SystemExit) as ending:
        runpy.run_path("patch.py", run_name="__main__")
    assert ending.value.code == 0
    assert "parameters: thickness=0.008" in capsys.readouterr().out
    assert (tmp_path / "results/quick/patch/only/summary.json").is_file()


def test_neither_a_closed_pipe_nor_the_backend_of_a_notebook_ends_anything(written, tmp_path):  # noqa: F811
    reader, writer = os.pipe()
    os.close(reader)
    environment = os.environ | {"MPLBACKEND": "module://a_notebook_that_is_not_here.backend"}
    words = [sys.executable, "-m", "turingfold", "run", written(GROWS, step=0.5)]
    done = subprocess.run(
        words, stdout=writer, stderr=subprocess.PIPE, text=True, env=environment | {"PYTHONPATH": str(ROOT)}
    )
    os.close(writer)
    assert "roken pipe" not in done.stderr
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "results/tiny/tiny.png").exists()  # all of it was done


@pytest.mark.slow
def test_a_killed_process_is_named_and_the_others_go_on(written, tmp_path, capsys):  # noqa: F811
    case = written(DIES)
    assert main(["run", case, "-j", "2"]) == 3
    said = unwrapped(capsys)
    assert "dies: the process that ran it ended by SIGKILL" in said
    assert "Go on with: turingfold run tiny.py --only dies --resume" in said
    assert "Traceback" not in said
    summary = json.loads((tmp_path / "results/tiny/grows/summary.json").read_text())
    assert summary["converged"] is True


@pytest.mark.slow
def test_processes_end_with_the_one_that_started_them(written, tmp_path):  # noqa: F811
    case = written(GROWS, step=0.002)
    words = [sys.executable, "-m", "turingfold", "run", case, "-j", "2"]
    driver = subprocess.Popen(words, stderr=subprocess.DEVNULL, env=os.environ | {"PYTHONPATH": str(ROOT)})
    history = tmp_path / "results/tiny/grows/history.csv"
    while not history.exists() or history.read_text().count("\n") < 5:
        assert driver.poll() is None
    workers = children(driver.pid)
    assert workers
    driver.kill()
    driver.wait()
    for _ in range(200):
        if not any(Path(f"/proc/{pid}").exists() for pid in workers):
            return
        subprocess.run(["sleep", "0.1"])
    pytest.fail("workers outlive the process that started them")


def children(pid):
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(word) for task in tasks for word in task.read_text().split()]


COMPUTES = '''"""A patch whose length is computed."""
from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle


def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.25, elements=1)
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),)
    grow, steps = TangentialGrowth(cortex=1.1), Stepping(first=1.0, largest=1.0)
    return {"one": Scene(body=body, terms=terms, processes=(grow,), stepping=steps)}


def computed(results):
    with open("computed", "a") as file:
        file.write("x")
    return COMPUTED


def draw(results, figure, computed):
    figure.set_layout_engine("none")
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.plot(computed["line"])
'''


def test_what_a_case_computes_is_stored_and_drawn_from_there(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    case = Path("own.py")
    case.write_text(COMPUTES.replace("COMPUTED", '{"line": [1.0, 2.0], "words": "as they are"}'))
    assert main(["draw", "own.py"]) == 2
    assert main(["run", "own.py"]) == 0
    assert main(["draw", "own.py"]) == 0
    assert main(["run", "own.py", "--resume"]) == 0
    assert Path("computed").read_text() == "x"  # once
    stored = np.load("results/own/computed.npz")
    np.testing.assert_array_equal(stored["line"], [1.0, 2.0])
    assert main(["run", "own.py", "--overwrite"]) == 0
    assert Path("computed").read_text() == "xx"  # other results, again
    case.write_text(COMPUTES.replace("COMPUTED", '{"line": [3.0]}'))
    assert main(["run", "own.py", "--resume"]) == 0  # another text of the case, again
    np.testing.assert_array_equal(np.load("results/own/computed.npz")["line"], [3.0])
    mistakes = {"[1.0]": "must return a dict of arrays", '{"f": [print]}': "'f' is no array of"}
    for wrong, words in mistakes.items():
        case.write_text(COMPUTES.replace("COMPUTED", wrong))
        capsys.readouterr()
        assert main(["run", "own.py", "--overwrite"]) == 2
        assert words in unwrapped(capsys)


def test_folders_are_names_on_every_system():
    assert folder_name("P0 to P4: T/4") == "P0-to-P4-T-4"
    assert folder_name("con") == "con-scene"
    assert folder_name("LPT1.txt") == "LPT1.txt-scene"
    assert folder_name("console") == "console"
    assert folder_name("...") == "scene"
    long = folder_name(", ".join(f"parameter_{k}=1.23456" for k in range(40)))
    assert len(long) < 200
    assert long != folder_name(", ".join(f"parameter_{k}=1.23456" for k in range(41)))
    for names in (["PMG", "pmg"], ["a b", "a-b"], ["ä", "Ä"]):
        with pytest.raises(ValueError, match="would have one folder"):
            check_apart(names, Path("case.py"))
    check_apart(["PMG", "PMG 2"], Path("case.py"))


def test_a_sweep_of_many_points_has_its_table_and_its_pictures(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    monkeypatch.setattr("turingfold.cli.sweep.PAGE", 2)
    assert main(["sweep", "patch", "--quick", "--vary", "cortex=1.01:1.05:5"]) == 0
    folder = tmp_path / "results/quick/patch-sweep"
    with (folder / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    growths = [float(row["growth"]) for row in rows]
    np.testing.assert_allclose(growths, np.linspace(1.01, 1.05, 5), rtol=1e-3)
    assert {path.name for path in folder.glob("*.png")} == {f"patch-sweep{k}.png" for k in ("", "-2", "-3")}
    result = load(folder / "cortex=1.01")
    drawn = grid(Figure(), {f"panel {k}": (result, -1) for k in range(27)}, columns=6)
    assert "{aa}" in drawn[26].get_title(loc="left")  # more than there are letters


def test_a_table_grows_as_points_end_and_outlives_what_comes_after(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    table, seen = Path("results/quick/patch-sweep/sweep.csv"), []

    def names():
        return [line.partition(",")[0] for line in table.read_text().splitlines()[1:]]

    def broken(*_):
        raise RuntimeError("no picture today")

    def say(line):
        if "converged at growth" in line:
            seen.append(names())

    monkeypatch.setattr("turingfold.cli.sweep.say", say)
    monkeypatch.setattr("turingfold.cli.sweep.draw", broken)
    with pytest.raises(RuntimeError, match="no picture"):
        main(["sweep", "patch", "--quick", "--vary", "cortex=1.01,1.02"])
    assert seen == [["cortex=1.01"], ["cortex=1.01", "cortex=1.02"]]
    assert names() == seen[-1]


INTERRUPTS = """
import runpy, sys

class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            {raised}

sys.meta_path.insert(0, Interrupts())
sys.argv = ["turingfold", "list"]
runpy.run_module("turingfold", run_name="__main__", alter_sys=True)
"""


@pytest.mark.parametrize(
    ("module", "raised"),
    [
        ("turingfold.cli.main", "raise KeyboardInterrupt"),
        ("turingfold.cli.parser", "raise KeyboardInterrupt"),
        ("turingfold.errors", "raise KeyboardInterrupt"),
        ("turingfold.errors", "raise RuntimeError('in a class') from KeyboardInterrupt()"),
    ],
)
def test_ctrl_c_while_modules_are_imported_is_no_traceback(module, raised):
    code = INTERRUPTS.format(module=module, raised=raised)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.strip()) == (130, "turingfold: stopped.")
