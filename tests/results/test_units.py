"""Units of what is stored: one place says them."""

import ast
from pathlib import Path

import turingfold
from turingfold.results import units


def test_one_place_says_the_units_of_measures():
    """Compound units, which nothing else is called, stand in no other file of the package."""
    package = Path(turingfold.__file__).parent
    written = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value == "J/m"
    }
    assert written == {"results/units.py"}


def test_measures_have_the_units_of_their_docstrings():
    for name in ("perimeter", "sulcal_depth", "fold_amplitude", "min_gap"):
        assert units.measure_unit(name) == "m"
    assert units.measure_unit("energy") == "J/m"  # per m of depth
    assert units.measure_unit("pressure") == "Pa"
    for pure in ("gyrification_index", "folds", "growth", "time", "registration"):
        assert units.measure_unit(pure) == ""
