"""turingfold fit: a hidden parameter and a hidden map are found again from files; what it refuses."""

import csv
import json
import shutil

import numpy as np
import pytest

from turingfold import load
from turingfold.cli.main import main

MAP = """
from turingfold import Elastic, GrowthMap, NeoHookean, Scene, Stepping, semicircle

def scenes(quick=False, *, first=1.2, last=1.3):
    body = semicircle(radius=1.0, thickness=0.2, elements=2)
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),)
    steps = Stepping(first=0.5, largest=0.5)
    grow = GrowthMap(cortex=(first, 1.25, 1.1, 1.2, last))
    return {"only": Scene(body=body, terms=terms, processes=(grow,), stepping=steps)}
"""


@pytest.fixture
def target(tmp_path, monkeypatch):
    """Write a case, and the outline of its end to a file in millimetres; return its name."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "map.py").write_text(MAP)
    assert main(["run", "map.py", "--out", "hidden"]) == 0
    millimetres = 1e3 * load("hidden/map/only").pial().T
    np.savetxt("outline.csv", millimetres, delimiter=",", header="x,y", comments="")
    return "outline.csv"


def test_a_map_is_found_again_and_run_and_stored(target, tmp_path, capsys):
    words = ["--target", f"1={target}", "--unit", "mm", "--set", "first=1.1", "--set", "last=1.1"]
    assert main(["fit", "map.py", "--to", "GrowthMap.cortex", *words]) == 0
    said = capsys.readouterr().out
    assert "tell 5 of 5 combinations" in said
    folder = tmp_path / "results/map-fit"
    with (folder / "fit.csv").open() as file:
        values = [float(row["value"]) for row in csv.DictReader(file)]
    hidden = (1.2, 1.25, 1.1, 1.2, 1.3)
    np.testing.assert_allclose(values, hidden, rtol=2e-3)
    result = load(folder / "only")
    assert result.status == "converged"
    np.testing.assert_allclose(result.scene.processes[0].cortex, values)
    best = json.loads((folder / "fit.json").read_text())["parameters"]
    np.testing.assert_allclose(list(best.values()), values)
    assert (folder / "map-fit.png").read_bytes().startswith(b"\x89PNG")


def test_landmarks_of_a_file_count_too(target, tmp_path, capsys):
    result = load("hidden/map/only")
    nodes = result.scene.body.pial[[5, 9]]
    rest = result.scene.body.nodes[:, nodes]
    there = rest + result.last["displacement"][:, nodes]
    lines = [f"mark {k}," + ",".join(f"{1e3 * v:.9g}" for v in (*rest[:, k], *there[:, k])) for k in (0, 1)]
    (tmp_path / "marks.csv").write_text("\n".join(["name,x_a,y_a,x_b,y_b", *lines]) + "\n")
    words = ["--target", f"1={target}", "--unit", "mm", "--set", "first=1.1", "--set", "last=1.1"]
    marked = ["--landmarks", "1=marks.csv"]
    assert main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, *marked]) == 0
    with (tmp_path / "results/map-fit/fit.csv").open() as file:
        values = [float(row["value"]) for row in csv.DictReader(file)]
    np.testing.assert_allclose(values, (1.2, 1.25, 1.1, 1.2, 1.3), rtol=2e-3)
    stored = json.loads((tmp_path / "results/map-fit/only/scene.json").read_text())["case"]["command"]
    assert "--landmarks 1=marks.csv" in stored
    capsys.readouterr()
    for text, words_ in (
        ("name,x,y\n", "first line"),
        (f"name,x_a,y_a,x_b,y_b\na,{9e3},0,1,1\n", "pial surface"),
    ):
        (tmp_path / "marks.csv").write_text(text)
        assert main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, *marked, "--overwrite"]) == 2
        assert words_ in capsys.readouterr().err


def test_bounds_of_all_and_of_one_parameter(target, tmp_path, capsys):
    words = [
        "--target",
        f"1={target}",
        "--unit",
        "mm",
        "--bounds",
        "1:2",
        "--bounds",
        "GrowthMap.cortex.4=1:1.25",
    ]
    assert main(["fit", "map.py", "--to", "GrowthMap.cortex", "--set", "last=1.1", *words]) == 0
    assert "note: GrowthMap.cortex.4: at the largest value allowed" in capsys.readouterr().out
    with (tmp_path / "results/map-fit/fit.csv").open() as file:
        values = [float(row["value"]) for row in csv.DictReader(file)]
    assert max(values) <= 1.3
    assert 1.24 < values[4] <= 1.25
    stored = json.loads((tmp_path / "results/map-fit/only/scene.json").read_text())["case"]["command"]
    assert "--bounds 1.0:2.0 --bounds GrowthMap.cortex.4=1.0:1.25" in stored
    with pytest.raises(SystemExit):
        main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, "--bounds", "none"])
    assert (
        main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, "--bounds", "x=1:2", "--overwrite"]) == 2
    )
    assert "bounds names x, which is not fitted" in capsys.readouterr().err
    again = ["--target", f"1.0={target}", "--overwrite"]
    assert main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, *again]) == 2
    assert "--target has the time 1 twice" in capsys.readouterr().err
    early = ["--landmarks", "soon=marks.csv", "--overwrite"]
    assert main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, *early]) == 2
    assert "--landmarks soon=marks.csv: 'soon' is no time" in capsys.readouterr().err


def test_a_result_is_a_target_too_and_smoothness_may_be_chosen(target, tmp_path, capsys):
    words = ["--target", "1=hidden/map/only", "--noise", "0.002", "--smoothness", "auto"]
    assert main(["fit", "map.py", "--to", "GrowthMap.cortex", *words, "--figure", "mine.svg"]) == 0
    said = capsys.readouterr().out
    assert "the most that moves the map by no more than the noise" in said
    stored = json.loads((tmp_path / "results/map-fit/only/scene.json").read_text())["case"]["command"]
    assert stored.endswith(" --smoothness auto --noise 0.002 --figure mine.svg")
    assert (tmp_path / "mine.svg").is_file()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--to", "GrowthMap.cortx"], "cortx"),
        (["--to", "GrowthMap.cortex.0", "--target", "late=outline.csv"], "'late' is no time"),
        (["--to", "GrowthMap.cortex.0", "--target", "2=outline.csv", "--unit", "mm"], "age"),
        (["--to", "GrowthMap.cortex.0", "--smoothness", "auto"], "three neighbours"),
        (["--to", "GrowthMap.cortex.0"], "are both in m"),  # the file is in mm
    ],
)
def test_what_cannot_be_is_refused(target, words, said, capsys):
    capsys.readouterr()
    assert main(["fit", "map.py", "--target", f"1={target}", *words]) == 2
    assert said in capsys.readouterr().err


def test_resume_goes_on_only_with_a_result_of_its_own(target, tmp_path, capsys):
    words = ["map.py", "--to", "GrowthMap.cortex.0", "--target", f"1={target}", "--unit", "mm"]
    folder = tmp_path / "results/map-fit/only"
    shutil.copytree("hidden/map/only", folder)  # of a run, which no fit has made
    before = {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}
    capsys.readouterr()
    assert main(["fit", *words, "--resume"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "results/map-fit/only holds a result that is none of this fit: it was not fitted" in said
    assert "--out DIR" in said
    assert "--overwrite" in said
    assert {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()} == before

    assert main(["fit", *words, "--bounds", "1:1.15", "--set", "first=1.1", "--overwrite"]) == 0
    assert main(["fit", *words, "--set", "last=1.2", "--resume"]) == 2
    assert "none of this fit: scene.processes" in " ".join(capsys.readouterr().err.split())
    assert load(folder).scene.processes[0].cortex[0] <= 1.15
    assert main(["fit", *words, "--set", "first=1.1", "--resume"]) == 0  # its own, of other bounds
    assert load(folder).scene.processes[0].cortex[0] == pytest.approx(1.2, rel=2e-3)
    (folder.parent / "fit.json").unlink()  # else that already says it
    other = ["map.py", "--to", "GrowthMap.cortex.1", *words[3:]]
    assert main(["fit", *other, "--resume"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "none of this fit: it was fitted by GrowthMap.cortex.0" in said


def test_a_folder_that_cannot_take_the_result_is_refused_before_the_fit(target, tmp_path, capsys):
    words = ["map.py", "--to", "GrowthMap.cortex.0", "--target", f"1={target}", "--unit", "mm"]
    folder = tmp_path / "results/map-fit/only"
    folder.mkdir(parents=True)
    (folder / "notes.txt").write_text("mine")
    for more in ([], ["--resume"], ["--overwrite"]):
        assert main(["fit", *words, *more]) == 2
        assert "only holds files that are no result" in " ".join(capsys.readouterr().err.split())
        assert not (folder.parent / "fit.json").exists()
    (folder / "notes.txt").unlink()
    for name in ("scene.json", "body.npz"):  # of a run that was killed before its first state
        shutil.copy(f"hidden/map/only/{name}", folder)
    assert main(["fit", *words]) == 2
    assert "already holds a fit" in capsys.readouterr().err
    assert not (folder.parent / "fit.json").exists()
