"""What the pages say runs: their Python, the files they show, their commands; and their tables are true."""

import ast
import json
import re
import shlex
from pathlib import Path

import pytest
from fences import fences
from test_architecture import ROOMS

from turingfold.cli.case import find_case, shipped
from turingfold.cli.main import main
from turingfold.cli.parser import parser

DOCS = Path(__file__).parents[1] / ".docs"
PAGES = DOCS / "pages"
SIZED = ("run", "sweep", "accuracy", "sensitivity", "fit", "buckling")  # they have a small version of a case
SHOWN = ("app", "animate")  # serve for ever, or other tests run them: only the words are checked
SMALL = {"verify": "layers", "atlas": "--mechanics"}  # words of a small one; as a whole they take minutes


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted(PAGES.glob("*.md")), ids=lambda page: page.stem)
def test_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for fence in fences(page):
        if fence.title:
            Path(fence.title).write_text(fence.text, encoding="utf-8")
        elif fence.language == "python":
            exec(compile(fence.text, page.name, "exec"), names)
        elif not fence.language:
            for line in fence.text.splitlines():
                command, *words = shlex.split(line, comments=True) or [""]
                if command == "turingfold":
                    done(words)


@pytest.mark.slow
def test_the_notebook_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells = json.loads((PAGES / "notebook.ipynb").read_text(encoding="utf-8"))["cells"]
    names, shown = {}, []
    for cell in cells:
        if cell["cell_type"] == "code":
            *statements, last = ast.parse("".join(cell["source"])).body
            exec(compile(ast.Module(statements, []), cell["id"], "exec"), names)
            one = isinstance(last, ast.Expr)  # what a notebook shows
            kind = ast.Expression(last.value) if one else ast.Module([last], [])
            value = eval(compile(kind, cell["id"], "eval" if one else "exec"), names)
            shown.append(value)
    assert "<svg" in shown[0]._repr_html_()
    summary = names["result"].summary()
    assert names["result"].converged
    assert summary["folds"] == 6
    assert summary["registration"] > 0.8
    assert not any(cell.get("outputs") for cell in cells)  # kept out of the history


def done(words):
    """Do what a command of turingfold says, with the small version of its case.

    Cases as they come with the package are run by tests/cases.
    """
    as_it_comes = words[0] == "run" and len(words) == 2 and words[1] in shipped()
    whole = SMALL.get(words[0], words[0]) not in words
    if words[0] in SHOWN or as_it_comes or whole:
        parser().parse_args(words)
        return
    small = ["--quick"] if words[0] in SIZED and "--quick" not in words else []
    assert main([*words, *small]) == 0, words


def test_the_defaults_of_figure_3():
    text = (PAGES / "model.md").read_text(encoding="utf-8")
    table = text.partition("## 10.")[2].partition("## 11.")[0]
    said = dict(re.findall(r"^\| `(\w+)` \| (\S+) \|", table, re.MULTILINE))
    case = find_case("figure3")
    assert list(said) == list(case.parameters)
    for name, parameter in case.parameters.items():
        default = parameter.default
        if isinstance(default, bool):
            assert said[name] == ("on" if default else "off"), name
        elif isinstance(default, (int, float)):
            assert float(said[name]) == default, name
        else:
            assert said[name] == (default or "auto"), name


def test_the_picture_of_the_house():
    (picture,) = (one.text for one in fences(PAGES / "contributors.md") if one.text.startswith(" __main__"))
    storeys = [line for line in picture.splitlines() if line.startswith(" ") and line[1] != " "]
    assert len(storeys) == len(ROOMS)
    for storey, names in zip(storeys, reversed(ROOMS), strict=True):
        assert set(names) <= set(re.findall(r"\w+", storey)), storey


@pytest.mark.parametrize("page", sorted(PAGES.glob("*.md")), ids=lambda page: page.stem)
def test_links_lead_to_what_is_there(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" not in link:
            assert (page.parent / link.partition("#")[0]).exists(), link


def test_the_gallery_has_the_numbers_that_were_kept():
    kept = json.loads((DOCS / "gallery.json").read_text(encoding="utf-8"))
    page = (PAGES / "gallery.md").read_text(encoding="utf-8")
    for scene, words in ((scene, words) for scenes in kept.values() for scene, words in scenes.items()):
        assert f"| {scene} | {' | '.join(words)} |" in page, "write it anew: python .docs/gallery.py"
