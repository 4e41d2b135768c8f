"""turingfold buckling: the critical growth of a case's scenes as a table and as a picture."""

import pytest

from turingfold.cli.main import main

CASE = '''
"""Growing half discs."""
from turingfold import (
    Drag, Elastic, NeoHookean, Scene, SelfContact, Stepping, TangentialGrowth, semicircle,
)

def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.2, size=0.1, base="roller", layers="sigmoid")
    grow = TangentialGrowth(cortex=1.9)
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    terms = {"plain": (solid,), "dragged": (solid, Drag(coefficient=9.0))}
    return {name: Scene(body=body, terms=listed, processes=(grow,)) for name, listed in terms.items()}
'''


def test_table_and_figure(tmp_path, capsys):
    """T/R = 0.2, θ(y), K = 5μ: 1.7846 and 7 half waves in theory; two elements in the cortex come close."""
    case, figure = tmp_path / "disc.py", tmp_path / "modes.png"
    case.write_text(CASE)
    assert main(["buckling", str(case), "--figure", str(figure)]) == 0
    lines = capsys.readouterr().out.splitlines()
    plain, dragged = (line.split() for line in lines[1:3])
    assert float(plain[1]) == pytest.approx(1.7846, rel=0.02)
    assert int(plain[2]) == 7
    assert plain[1:] == dragged[1:]  # drag changes when a body buckles, not at what growth its tangent does
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_a_stable_scene_is_named_beside_the_others(tmp_path, capsys):
    case, figure = tmp_path / "disc.py", tmp_path / "modes.png"
    less = (
        "import dataclasses\n"
        + CASE.replace("return {name: Scene(", "made = {name: Scene(")
        + """
    calm = dataclasses.replace(made["plain"], processes=(TangentialGrowth(cortex=1.2),))
    return {"calm": calm, "plain": made["plain"]}
"""
    )
    case.write_text(less)
    assert main(["buckling", str(case), "--figure", str(figure)]) == 3  # as for scenes that stop
    printed = capsys.readouterr()
    calm, plain = printed.out.splitlines()[1:3]
    assert calm.split()[:4] == ["calm", "-", "-", "-"]
    assert "stable" in calm
    assert plain.split()[0] == "plain"
    assert float(plain.split()[1]) == pytest.approx(1.7846, rel=0.02)
    assert "calm: No loss of stability until t = 1" in printed.err
    assert "turingfold: scene 2 of 2, plain: its path" in printed.err
    assert "plain: No loss" not in printed.err
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert main(["buckling", str(case), "--only", "calm", "--figure", str(tmp_path / "none.png")]) == 3
    assert "not drawn" in capsys.readouterr().out
    assert not (tmp_path / "none.png").exists()


def test_an_unknown_scene_is_refused(tmp_path, capsys):
    case = tmp_path / "disc.py"
    case.write_text(CASE)
    assert main(["buckling", str(case), "--only", "other"]) == 2
    assert "plain, dragged" in capsys.readouterr().err.replace("'", "")
