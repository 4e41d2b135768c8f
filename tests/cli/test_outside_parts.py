"""Results with parts from outside the package: runs, films and comparisons from the command line."""

import os
import py_compile
import shutil
import sys
from importlib.machinery import FileFinder, SourceFileLoader
from pathlib import Path

import pytest

from turingfold.cli.case import load_case
from turingfold.cli.main import main

EXAMPLE = Path(__file__).parents[1] / "examples" / "springs.py"
CASE = '''"""A body on springs."""
from springs import Springs
from turingfold import *
def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.25, size=0.25)
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), Springs(stiffness=2.0))
    steps = Stepping(first=0.5, largest=0.5)
    return {"one": Scene(body=body, terms=terms, processes=(TangentialGrowth(cortex=1.1),), stepping=steps)}
def draw(results, figure):
    figures.section(figure.add_subplot(), results["one"])
'''


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with the case and the file of its parts, which all tests share."""
    found = tmp_path_factory.mktemp("outside")
    shutil.copy(EXAMPLE, found)
    (found / "mine.py").write_text(CASE)
    return found


@pytest.fixture
def folder(home, monkeypatch):
    monkeypatch.chdir(home)
    monkeypatch.delitem(sys.modules, "springs", raising=False)  # of another test's folder
    monkeypatch.syspath_prepend(home)
    if not Path("results").exists():
        assert main(["run", "mine.py"]) == 0
    return Path("results/mine/one")


def test_a_case_knows_the_parts_in_files_beside_it(folder, capsys):
    assert main(["draw", "mine.py"]) == 0


def test_other_commands_are_told_where_parts_are(folder, capsys):
    assert main(["compare", str(folder), str(folder)]) == 2
    assert "Springs" in capsys.readouterr().err
    assert main(["compare", str(folder), str(folder), "--with", "springs.py"]) == 0
    assert main(["animate", str(folder), "--with", "springs.py"]) == 0
    assert (folder / "film.gif").exists()


def test_a_case_with_parts_of_its_own_is_named_as_their_file(folder, capsys):
    Path("own.py").write_text(EXAMPLE.read_text() + CASE.replace("from springs import Springs\n", ""))
    assert main(["run", "own.py"]) == 0
    own = "results/own/one"
    assert main(["compare", own, own]) == 2
    assert "--with FILE.py" in " ".join(capsys.readouterr().err.split())
    assert main(["compare", own, str(folder), "--with", "own.py", "--with", "springs.py"]) == 0
    assert main(["animate", own, "--with", "own.py"]) == 0


def test_a_file_of_parts_that_is_not_there_is_named(folder, capsys):
    assert main(["compare", str(folder), str(folder), "--with", "nowhere.py"]) == 2
    assert "nowhere.py" in capsys.readouterr().err


def test_a_case_and_what_it_imports_are_run_from_their_text(tmp_path, monkeypatch):
    """Python takes stored bytecode for its own if second and size of the source agree."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    case = tmp_path / "bulging.py"
    beside = tmp_path / "beside_bulging.py"
    case.write_text(
        '"""A case."""\nfrom beside_bulging import GROWTH\n\ndef scenes(quick=False):\n    return {}\n'
    )
    for number in (1, 2):
        beside.write_text(f"GROWTH = {number}\n")
        os.utime(beside, (1e9, 1e9))  # as quick editing by a script leaves it
        if number == 1:
            py_compile.compile(str(beside))
        sys.modules.pop("beside_bulging", None)
        found = load_case(case).module.GROWTH
        assert found == number
    sys.modules.pop("beside_bulging", None)
    sys.path.remove(str(tmp_path))


def test_how_a_folder_that_is_on_the_path_is_imported_from_stays(tmp_path, monkeypatch):
    """Others may have their own way there, such as pytest's assertions or a zip."""
    (tmp_path / "standing.py").write_text(
        '"""A case."""\nfrom beside_standing import GROWTH\n\ndef scenes(quick=False):\n    return {}\n'
    )
    (tmp_path / "beside_standing.py").write_text("GROWTH = 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    own = FileFinder(str(tmp_path), (SourceFileLoader, [".py"]))
    monkeypatch.setitem(sys.path_importer_cache, str(tmp_path), own)
    assert load_case(tmp_path / "standing.py").module.GROWTH == 3
    assert sys.path_importer_cache[str(tmp_path)] is own
    sys.modules.pop("beside_standing")
