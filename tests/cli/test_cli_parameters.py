"""Parameters of a case on the command line: --set, --vary, what is stored of them, and what is refused."""

import csv
import hashlib
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from turingfold import load
from turingfold.cli.case import load_case
from turingfold.cli.main import main

CASE = '''"""A patch of cortex that grows, of any size. Less than a second."""
from turingfold import AxonalTension, Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle
from turingfold import parameters as p


@p.quick(elements=1)
def scenes(
    quick=False, *, radius: p.Radius = 0.04, thickness: p.Thickness = 0.01, elements: p.Elements = 2,
    young: p.YoungGray = 1000.0, cortex: p.Cortex = 1.05, base: p.Base = "roller", pulled: p.Tension = False,
    strength: p.Strength = 1e-3,
):
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    solid = Elastic(gray=NeoHookean.from_young(young, 0.4))
    pull = (AxonalTension(strength=strength, patches=2),) if pulled else ()
    return {"only": Scene(
        body=body, terms=(solid, *pull), processes=(TangentialGrowth(cortex=cortex),),
        stepping=Stepping(first=1.0, largest=1.0),
    )}


def draw(results, figure):
    figure.set_layout_engine("none")
    figure.add_axes((0, 0, 1, 1)).plot(*results["only"].pial())
'''
PLAIN = '''"""A case without parameters."""
from turingfold import Elastic, NeoHookean, Scene, semicircle


def scenes(quick=False):
    body = semicircle(radius=0.04, thickness=0.01, elements=1, base="roller")
    return {"only": Scene(body=body, terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),))}
'''


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    Path("plain.py").write_text(PLAIN)
    return tmp_path


def said(capsys):
    return " ".join(capsys.readouterr().err.split())


def mean_thickness(body):
    """Return gray area over the mean of pial and interface length, exact for concentric arcs."""
    area = float(body.quadrature.weights[:, body.in_cortex].sum())
    x, y = body.nodes[:, body.interface]
    return 2 * area / (body.pial_curve.length + np.hypot(np.diff(x), np.diff(y)).sum())


def table(folder):
    with (folder / "sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_set_makes_the_body_and_the_material_that_were_asked_for(here, capsys):
    words = ["--set", "thickness=8e-3", "--set", "young=1500", "--set", "pulled=on"]
    assert main(["run", "patch", "--quick", *words]) == 0
    assert "parameters: thickness=0.008, young=1500, pulled=on" in capsys.readouterr().out
    folder = here / "results/quick/patch/only"
    scene = load(folder).scene
    assert mean_thickness(scene.body) == pytest.approx(8e-3, rel=0.01)
    assert scene.body.elements_through_cortex == pytest.approx(1)
    assert scene.terms[0].gray.young == pytest.approx(1500)
    assert len(scene.terms) == 2
    stored = json.loads((folder / "scene.json").read_text())["case"]
    assert stored["name"] == "patch"
    assert stored["sha256"] == hashlib.sha256(CASE.encode()).hexdigest()
    assert stored["changed"] == ["thickness", "young", "pulled"]
    assert stored["parameters"] == {
        "radius": 0.04, "thickness": 8e-3, "elements": 1, "young": 1500.0, "cortex": 1.05, "base": "roller",
        "pulled": True, "strength": 1e-3,
    }  # fmt: skip


IDLE = "strength=0.002 changes nothing with the other parameters as they are (turingfold list patch)"


@pytest.mark.parametrize(
    ("words", "idle"),
    [
        (["run", "patch", "--set", "strength=2e-3"], True),
        (["run", "patch", "--set", "strength=2e-3", "--set", "pulled=on"], False),
        (["run", "patch", "--set", "strength=1e-3", "--set", "elements=1"], False),  # as they are by default
        (["sweep", "patch", "--set", "strength=2e-3", "--vary", "cortex=1.02,1.03"], True),
        (["sweep", "patch", "--vary", "strength=2e-3,3e-3"], True),
        (["sweep", "patch", "--vary", "strength=2e-3,3e-3", "--set", "pulled=on"], False),
    ],
)
def test_values_that_change_nothing_are_noted(here, capsys, words, idle):
    assert main([*words, "--quick"]) == 0
    told = said(capsys)
    assert (IDLE in told) == idle
    assert ("nothing with the other" in told) == idle


def test_the_users_number_of_elements_wins_over_that_of_the_quick_version(here):
    assert main(["run", "patch", "--quick", "--set", "elements=3"]) == 0
    body = load(here / "results/quick/patch/only").scene.body
    assert body.elements_through_cortex == pytest.approx(3)


def test_another_scene_in_the_folder_is_told_by_its_parameters_and_the_remedy(here, capsys):
    assert main(["run", "patch", "--quick"]) == 0
    words = said(capsys)
    assert "1 element(s) through the cortex" in words
    assert "so drop --quick for numbers" in words
    assert main(["run", "patch", "--quick", "--set", "radius=0.05", "--set", "elements=3"]) == 2
    assert "(radius was 0.04 and is 0.05); choose another folder (out=..., --out DIR)" in said(capsys)
    assert main(["run", "patch", "--set", "elements=1", "--set", "cortex=1.01"]) == 0
    assert "so --set elements=3 for numbers" in said(capsys)


@pytest.mark.skipif(shutil.which("git") is None, reason="there is no git here")
def test_a_result_says_what_made_it(here):
    case, words = here / "patch.py", ["git", "-c", "user.name=a", "-c", "user.email=b@c", "-C", str(here)]
    assert "commit" not in load_case(case).provenance({}, quick=True)
    for more in (["init", "-q"], ["add", "patch.py"], ["commit", "-qm", "patch"]):
        subprocess.run([*words, *more], check=True)
    done = subprocess.run([*words, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    assert load_case(case).provenance({}, quick=True)["commit"] == done.stdout.strip()
    case.write_text(CASE + "\n")
    assert main(["run", "patch", "--quick", "--set", "cortex=1.01"]) == 0
    stored = json.loads((here / "results/quick/patch/only/scene.json").read_text())["case"]
    assert stored["commit"] == done.stdout.strip() + "-dirty"
    assert stored["command"] == "turingfold run patch --set cortex=1.01 --quick"


def test_a_value_of_a_part_can_be_set_too(here, capsys):
    assert main(["run", "patch", "--set", "Stepping.first=0.5", "--set", "Stepping.largest=0.5"]) == 0
    assert "Stepping.largest=0.5" in capsys.readouterr().out
    result = load(here / "results/patch/only")
    assert result.summary()["steps"] == 2
    stored = json.loads((here / "results/patch/only/scene.json").read_text())["case"]
    assert stored["parts"] == {"Stepping.first": "0.5", "Stepping.largest": "0.5"}


def test_a_sweep_over_parameters_has_true_bodies(here):
    words = ["--vary", "thickness=4e-3:8e-3:3", "--vary", "radius=0.03,0.05"]
    assert main(["sweep", "patch", "--quick", *words]) == 0
    folder = here / "results/quick/patch-sweep"
    rows = table(folder)
    assert len(rows) == 6
    for row in rows:
        thickness, radius = float(row["thickness [m]"]), float(row["radius [m]"])
        assert row["status"] == "converged"
        body = load(folder / row["scene"].replace(", ", "-")).scene.body
        assert mean_thickness(body) == pytest.approx(thickness, rel=0.01)
        assert body.pial_curve.length == pytest.approx(np.pi * radius, rel=0.01)
    assert {(float(r["thickness [m]"]), float(r["radius [m]"])) for r in rows} == {
        (t, r) for t in (4e-3, 6e-3, 8e-3) for r in (0.03, 0.05)
    }


def test_parameters_and_values_of_parts_are_varied_together(here):
    words = ["--vary", "cortex=1.02,1.05", "--vary", "Elastic.gray.mu=300,500"]
    assert main(["sweep", "patch", "--quick", *words]) == 0
    rows = table(here / "results/quick/patch-sweep")
    assert [row["scene"] for row in rows] == [
        f"cortex={cortex}, mu={mu}" for cortex in ("1.02", "1.05") for mu in (300, 500)
    ]
    energies = [float(row["energy [J/m]"]) for row in rows]
    assert energies[1] > energies[0]  # stiffer
    assert energies[2] > energies[0]  # more growth


def test_an_inadmissible_point_is_a_row_and_the_others_are_run(here, capsys):
    # thickness must stay below half the radius: 0.015 does not fit a radius of 0.02
    words = ["--vary", "radius=0.02,0.04", "--vary", "thickness=0.005,0.015"]
    assert main(["sweep", "patch", "--quick", *words]) == 2
    rows = table(here / "results/quick/patch-sweep")
    statuses = {row["scene"]: row["status"] for row in rows}
    assert statuses.pop("radius=0.02, thickness=0.015") == "refused"
    assert len(statuses) == 3
    assert "refused" not in statuses.values()
    (refused,) = [row for row in rows if row["status"] == "refused"]
    assert "thickness=0.015 m must be less than 0.01 m" in refused["message"]
    assert refused["folds"] == ""
    assert "must be less than 0.01 m" in said(capsys)
    assert (here / "results/quick/patch-sweep/patch-sweep.png").exists()


def test_a_point_that_cannot_start_is_a_row_and_no_picture(here):
    text = Path("patch.py").read_text().replace("AxonalTension, ", "AxonalTension, Schnakenberg, Turing, ")
    pattern = "(Turing(Schnakenberg(), half_waves=2000), TangentialGrowth(cortex=cortex))"  # too fine for any
    ours = f"{pattern} if cortex > 1.1 else (TangentialGrowth(cortex=cortex),)"
    Path("patch.py").write_text(text.replace("(TangentialGrowth(cortex=cortex),)", ours))
    assert main(["sweep", "patch", "--quick", "--vary", "cortex=1.05,1.2"]) == 2
    rows = table(here / "results/quick/patch-sweep")
    assert [row["status"] for row in rows] == ["converged", "refused"]
    assert "half_waves=2000" in rows[1]["message"]
    assert (here / "results/quick/patch-sweep/patch-sweep.png").exists()


def test_drawing_reads_what_was_run_and_makes_no_scene(here, capsys):
    assert main(["run", "patch", "--set", "thickness=8e-3"]) == 0
    Path("patch.py").write_text(CASE.replace("    body = ", "    raise AssertionError\n    body = "))
    capsys.readouterr()
    assert main(["draw", "patch"]) == 0
    assert capsys.readouterr().out.split() == ["figure:", "results/patch/patch.png"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["patch", "--set", "thicknes=1e-3"], "no parameter thicknes; did you mean thickness?"),
        (["patch", "--set", "thickness=8"], "thickness=8 is out of range (0.0001 to 0.02 m"),
        (["patch", "--set", "young=soft"], "young=soft must be a number in Pa"),
        (["patch", "--set", "young=1", "--set", "young=2"], "young is set twice"),
        (["patch", "--set", "cortex=90"], "1.9 growth by 90 per cent"),
        (["patch", "--set", "Scene.body.thickness=2e-3"], "vary the parameter of the case"),
        (["patch", "--set", "AxonalTension.strength=1"], "the scene has no AxonalTension"),
        (["plain", "--set", "radius=0.03"], "no parameter radius: its scenes() takes none"),
        (["figure33"], "no case figure33; did you mean figure3?"),
    ],
)
def test_what_cannot_be_set_is_said_and_nothing_runs(here, capsys, words, message):
    assert main(["run", *words]) == 2
    assert message in said(capsys)
    assert not (here / "results").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--vary", "Scene.body.thickness=2e-3"], "would leave the mesh"),
        (["--vary", "thickness=2e-3,2"], "thickness=2 is out of range"),
        (["--vary", "radius=0.03", "--set", "radius=0.04"], "radius is given twice"),
        (["--vary", "radius=0.02", "--vary", "thickness=0.015"], "must be less than 0.01 m"),  # all of them
    ],
)
def test_sweeps_that_cannot_be_are_refused(here, capsys, words, message):
    assert main(["sweep", "patch", *words]) == 2
    assert message in said(capsys)
    assert not (here / "results").exists()
