"""What is said before a run: of outlines that are not what they seem, of units, and of --quick."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pictures

from turingfold.cli.main import main

ANGLE = 2 * np.pi * np.arange(300) / 300
CIRCLE = np.array([[80.0], [60.0]]) + 30 * np.stack([np.cos(ANGLE), np.sin(ANGLE)])
QUICK = "note: --quick takes elements=2 for 4, cortex=1.2 for 1.7"
SAID = "curve 0 of the pial surface crosses or touches itself, and was taken apart there"
INSIDE = "1 of 2 closed curves lies inside another"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table(*curves, header="x (mm),y (mm)\n"):
    Path("a.csv").write_text(
        header + "\n".join("".join(f"{x:.3f},{y:.3f}\n" for x, y in curve.T) for curve in curves)
    )


def notes(capsys):
    return [line for line in capsys.readouterr().err.splitlines() if "note:" in line]


def run(*words, command="run", file="a.csv"):
    usual = ["--quick", "--set", "elements=3", "--set", "cortex=1.01"]
    return main([command, "section", "--set", f"outline={file}", *usual, *words])


def shifted(factor):
    """Return the circle with the x of one point multiplied."""
    points = CIRCLE.copy()
    points[0, 40] *= factor
    return points


def test_of_a_smooth_outline_nothing_is_said(here, capsys):
    table(CIRCLE)
    assert run() == 0
    assert notes(capsys) == []
    assert "outline:" not in (here / "results/quick/section/section/log.txt").read_text()


def test_a_mistyped_point_is_named_and_its_repair_said_and_logged(here, capsys):
    table(shifted(0.1))
    assert run() == 0
    first, second, *_ = notes(capsys)
    assert "a.csv, line 42: (10.007, 82.294)" in first  # a header, and 40 points before it
    assert "times as far from both its neighbours" in first
    assert SAID in second
    folder = here / "results/quick/section/section"
    assert SAID in (folder / "log.txt").read_text()
    assert SAID in str(json.loads((folder / "scene.json").read_text())["scene"]["body"]["changes"])


def test_a_curve_inside_another_is_said_and_a_ventricle_is_not(here, capsys):
    ventricle = CIRCLE.mean(1, keepdims=True) + 0.3 * (CIRCLE - CIRCLE.mean(1, keepdims=True))
    table(ventricle)
    Path("a.csv").rename("ventricle.csv")
    table(CIRCLE, ventricle)
    assert run() == 0
    (told,) = notes(capsys)
    assert INSIDE in told
    assert "ventricles are given as holes=" in told
    table(CIRCLE)
    assert run("--set", "holes=ventricle.csv", "--overwrite") == 0
    assert notes(capsys) == []


def test_a_sweep_says_it_once(here, capsys):
    table(shifted(0.1))
    words = ["--quick", "--set", "elements=3", "--set", "outline=a.csv", "--vary", "cortex=1.01,1.02"]
    assert main(["sweep", "section", *words, "--keep", "summary"]) == 0
    assert sum(SAID in line for line in notes(capsys)) == 1


def test_steps_of_voxels_are_said_to_be_smoothed_away(here, capsys):
    x = np.arange(101) - 50
    Pictures.fromarray(np.uint8(255 * (np.hypot(*np.meshgrid(x, x)) <= 40))).save("mask.png")
    assert run("--set", "unit=0.0005", file="mask.png") == 0
    (told,) = notes(capsys)
    assert "steps of voxels smoothed away over 0.00075 m, 1.5 voxels (smooth=0 keeps them)" in told


def test_a_missing_unit_is_one_note_and_a_lost_decimal_point_none_of_units(here, capsys):
    table(CIRCLE, header="")
    assert run() == 2
    (told,) = notes(capsys)
    assert "a.csv is 60 by 60 large, read as metres; if they are mm, say so by unit=" in told
    assert run("--set", "unit=mm") == 0
    assert notes(capsys) == []
    table(shifted(1000.0))
    assert run("--overwrite") == 2
    (told,) = notes(capsys)
    assert "line 42" in told
    assert "decimal sign" in told
    table(1000 * CIRCLE)  # in micrometres, though the header says mm
    assert run() == 2
    (told,) = notes(capsys)
    assert "its numbers read in units of 0.001 m, as stated; if they are in others, give unit=" in told


def test_what_quick_changes_is_said_but_not_of_what_is_given(here, capsys):
    table(CIRCLE)
    assert main(["run", "section", "--quick", "--set", "outline=a.csv"]) == 0
    assert f"turingfold: {QUICK}" in notes(capsys)
    words = ["--quick", "--set", "outline=a.csv", "--vary", "cortex=1.01,1.02", "--out", "other"]
    assert main(["sweep", "section", *words]) == 0
    assert "turingfold: note: --quick takes elements=2 for 4" in notes(capsys)
