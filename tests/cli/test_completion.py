"""What a shell is told at Tab, and that it is told nothing heavy."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from test_cli_parameters import CASE

from turingfold.cli.files import parameter_names, shipped
from turingfold.cli.main import main

pytest.importorskip("argcomplete")
ROOT = Path(__file__).parents[2]


def words_after(line, folder):
    """Return what the program answers a shell that has this line."""
    told = folder / "told"
    asked = {
        "_ARGCOMPLETE": "1", "_ARGCOMPLETE_IFS": "\n", "_ARGCOMPLETE_STDOUT_FILENAME": str(told),
        "COMP_LINE": line, "COMP_POINT": str(len(line)), "PYTHONPATH": str(ROOT),
    }  # fmt: skip
    code = "import sys; from turingfold.cli.main import main; sys.argv[0] = 'turingfold'; main()"
    subprocess.run([sys.executable, "-c", code], env=os.environ | asked, cwd=folder, check=True)
    return told.read_text().split("\n")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("turingfold sw", {"sweep "}),
        ("turingfold run --fr", {"--frames "}),
        ("turingfold draw --ma", {""}),
        ("turingfold run figure", {name for name in shipped() if name.startswith("figure")}),
        ("turingfold run own", {"own.py "}),
        ("turingfold run own.py --set th", {"thickness="}),
        ("turingfold sweep figure3 --vary young_g", {"young_gray="}),
        ("turingfold sweep figure3 --keep s", {"summary "}),
        ("turingfold run nowhere.py --set th", {""}),
        ("turingfold completion z", {"zsh "}),
    ],
)
def test_words_are_completed(tmp_path, line, words):
    (tmp_path / "own.py").write_text(CASE)
    assert set(words_after(line, tmp_path)) == words


def test_parameters_are_read_without_running_the_case(tmp_path):
    case = tmp_path / "case.py"
    case.write_text("raise SystemExit\n\ndef scenes(quick=False, *, one=1, two: int = 2):\n    pass\n")
    assert parameter_names(case) == ["one", "two"]
    case.write_text("def scenes(:")
    assert parameter_names(case) == []


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_script_for_each_shell_says_where_it_goes(capsys, shell):
    assert main(["completion", shell]) == 0
    first, *rest = capsys.readouterr().out.splitlines()
    assert first.startswith("# in ~/.")
    assert f"turingfold completion {shell}" in first
    assert any("_ARGCOMPLETE" in line for line in rest)
    if found := shutil.which(shell):
        script = "\n".join(rest)
        check = "--no-execute" if shell == "fish" else "-n"
        subprocess.run([found, check], input=script, text=True, check=True)


def test_nothing_of_it_is_loaded_unless_a_shell_asks():
    code = "import sys; from turingfold.cli.main import main; main([]); print('argcomplete' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"
