"""turingfold sensitivity: its table against exact numbers and a second run; what it refuses."""

import csv

import numpy as np
import pytest
from test_cli_parameters import CASE

from turingfold import load
from turingfold.cli.main import main


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "patch.py").write_text(CASE)
    return "patch.py"


def table(folder):
    with (folder / "sensitivity.csv").open() as file:
        rows = list(csv.DictReader(file))
    return {(row["measure"], row["parameter"]): row for row in rows}


def test_energy_is_proportional_to_the_moduli_and_shape_is_not_changed_by_both(case, tmp_path, capsys):
    assert main(["sensitivity", case, "--quick", "--out", "o"]) == 0
    out = capsys.readouterr().out
    assert "only:" in out
    found = table(tmp_path / "o/patch-sensitivity")
    moduli = ["Elastic.gray.mu", "Elastic.gray.kappa"]
    assert {*moduli, "TangentialGrowth.cortex"} <= {parameter for _, parameter in found}
    assert not any(parameter.startswith(("Stepping", "Scene")) for _, parameter in found)
    for measure, exact in (("energy", 1.0), ("perimeter", 0.0), ("gyrification_index", 0.0)):
        both = sum(float(found[measure, name]["per_cent_per_per_cent"]) for name in moduli)
        assert both == pytest.approx(exact, abs=1e-5)
    assert (tmp_path / "o/patch-sensitivity/patch-sensitivity.png").read_bytes().startswith(b"\x89PNG")


def test_the_derivative_is_that_of_runs_with_other_growth(case, tmp_path):
    own = ["--to", "TangentialGrowth.cortex", "--of", "perimeter", "--figure", "mine.svg"]
    assert main(["sensitivity", case, "--quick", *own]) == 0
    (row,) = table(tmp_path / "results/quick/patch-sensitivity").values()
    ends = []
    for growth in ("1.049", "1.051"):
        assert main(["run", case, "--quick", "--out", growth, "--set", f"cortex={growth}"]) == 0
        pial = load(tmp_path / growth / "patch/only").pial()
        ends.append(np.hypot(*np.diff(pial)).sum())
    assert float(row["derivative"]) == pytest.approx((ends[1] - ends[0]) / 2e-3, rel=1e-3)
    assert float(row["value"]) == 1.05
    assert (tmp_path / "mine.svg").is_file()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--to", "TangentialGrowth.cortx"], "has no 'cortx'"),
        (["--to", "Stepping.first"], "no parameter of a part"),
        (["--only", "other"], "no scene 'other'"),
    ],
)
def test_unknown_names_are_refused_before_anything_is_run(case, tmp_path, capsys, words, said):
    assert main(["sensitivity", case, "--quick", *words]) == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "results").exists()


def test_a_scene_with_drag_is_refused_by_name(case, tmp_path, capsys):
    text = CASE.replace("(solid, *pull)", "(solid, Drag(coefficient=1.0))")
    text = text.replace("import Ax", "import Drag, Ax")
    (tmp_path / "patch.py").write_text(text)
    assert main(["sensitivity", case, "--quick"]) == 2
    assert "scene 'only': terms holds Drag" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "results").exists()


def test_parameters_that_cannot_change_alone_are_left_out_unless_named(tmp_path, monkeypatch, capsys):
    """Half a body with a map of the whole surface, its own image: no single value of it may change."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "even.py").write_text(
        '''"""A symmetric map on half a body."""
from turingfold import Elastic, GrowthMap, NeoHookean, Scene, Stepping, half, semicircle

def scenes(quick=False):
    body = half(semicircle(radius=1.0, thickness=0.2, elements=2))
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),)
    grow = GrowthMap(cortex=(1.1, 1.3, 1.1), places=(0.1, 0.5, 0.9))
    steps = Stepping(first=0.5, largest=0.5)
    return {"only": Scene(body=body, terms=terms, processes=(grow,), stepping=steps)}
'''
    )
    assert main(["sensitivity", "even.py", "--of", "perimeter"]) == 0
    said = capsys.readouterr().out
    assert "note: GrowthMap.cortex.0 is left out" in said
    assert "GrowthMap.cortex.1 " in said
    words = ["sensitivity", "even.py", "--to", "GrowthMap.cortex.0", "--overwrite"]
    assert main(words) == 2
    assert "half a body is one of two alike" in capsys.readouterr().err
