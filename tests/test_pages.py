"""What the pages say runs: their Python, the files they show, their commands; and their tables are true."""

import re
import shlex
from pathlib import Path

import pytest
from fences import fences

from turingfold.cli.case import find_case
from turingfold.cli.main import main
from turingfold.cli.parser import parser

PAGES = Path(__file__).parents[1] / ".docs" / "pages"
SIZED = ("run", "sweep", "accuracy", "sensitivity", "buckling")  # commands with a small version of the case
SHOWN = ("app", "verify")  # they serve for ever, or take long: only their words are checked


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


def done(words):
    """Do what a command of turingfold says, with the small version of its case."""
    if words[0] in SHOWN:
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
