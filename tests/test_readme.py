"""The README's Python runs, and type checkers understand it."""

import subprocess
import sys
from pathlib import Path

import pytest
from fences import fences

README = Path(__file__).parents[1] / "README.md"
BLOCKS = [fence.text for fence in fences(README) if fence.language == "python"]


@pytest.fixture
def script(tmp_path):
    """Return the blocks as one program."""
    assert BLOCKS
    path = tmp_path / "readme.py"
    path.write_text("\n".join(BLOCKS), encoding="utf-8")
    return path


@pytest.mark.slow
def test_the_readme_runs(script):
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=script.parent)
    assert done.returncode == 0, done.stderr
    index, folds, registration = (float(word) for word in done.stdout.split()[:3])
    assert index > 1.2
    assert folds >= 8
    assert registration > 0.75


@pytest.mark.slow
@pytest.mark.parametrize("checker", [("mypy", "--strict"), ("basedpyright", "--level", "error")])
def test_type_checkers_understand_the_readme(script, checker):
    pytest.importorskip(checker[0])
    run = [sys.executable, "-m", *checker, script]
    done = subprocess.run(run, capture_output=True, text=True, cwd=README.parent)
    assert done.returncode == 0, done.stdout
