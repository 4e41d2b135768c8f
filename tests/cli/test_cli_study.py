"""Studies: grids, tables and samples of points; what is kept; parts of a study; going on with one."""

import csv
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from turingfold import load
from turingfold.cli.case import find_case
from turingfold.cli.design import Design, points
from turingfold.cli.main import main
from turingfold.cli.point import Maker, run_point
from turingfold.cli.request import Request, Running

CASE = '''"""A coarse patch of cortex that grows. Less than a second."""
from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle
from turingfold import parameters as p


def scenes(
    quick=False, *, thickness: p.Thickness = 0.01, young: p.YoungGray = 1000.0, cortex: p.Cortex = 1.05,
    base: p.Base = "roller", seed: p.Seed = 0, first: p.Strength = 1.0,
):
    body = semicircle(radius=0.03, thickness=thickness, elements=1, base=base)
    solid, steps = Elastic(gray=NeoHookean.from_young(young, 0.4)), Stepping(first=first, largest=1.0)
    grow = TangentialGrowth(cortex=cortex)
    return {"only": Scene(body=body, terms=(solid,), processes=(grow,), stepping=steps, seed=seed)}
'''
STUDY = Path("results/patch-sweep")


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)


def plan(*vary, **options):
    design = Design(vary=tuple(word.partition("=")[::2] for word in vary), **options)
    return points(find_case("patch"), Request("patch"), design, STUDY, "last")[0]


def table(file="sweep.csv"):
    with (STUDY / file).open(newline="") as opened:
        return list(csv.DictReader(opened))


def said(capsys):
    return " ".join(capsys.readouterr().err.split())


def test_samples_are_combined_with_listed_values_and_stay_within_their_ranges():
    found = plan("thickness=2e-3:4e-3", "seed=3:6", "base=roller,free", method="lhs", samples=8, seed=5)
    assert len(found) == 16
    values = [one.varied for one in found]
    assert [one["base"] for one in values] == 8 * ["roller", "free"]
    assert values[0]["thickness"] == values[1]["thickness"]
    # eight parts of equal length hold a sample each; four whole numbers are met twice each
    parts = sorted(int(8 * (one["thickness"] - 2e-3) / 2e-3) for one in values[::2])
    assert parts == list(range(8))
    assert sorted(one["seed"] for one in values[::2]) == [3, 3, 4, 4, 5, 5, 6, 6]
    assert all(type(one["seed"]) is int for one in values)
    again = plan("thickness=2e-3:4e-3", "seed=3:6", "base=roller,free", method="lhs", samples=8, seed=5)
    assert [one.identity for one in again] == [one.identity for one in found]


def test_a_longer_sobol_study_has_the_points_of_the_shorter():
    few, many = (plan("cortex=1.1:1.9", method="sobol", samples=count) for count in (3, 4))
    assert [one.identity for one in many][:3] == [one.identity for one in few]


def test_a_table_of_points_may_say_the_units_that_the_table_of_a_study_has():
    Path("table.csv").write_text("thickness [m],cortex\n0.008,1.1\n0.009,1.2\n")
    assert [one.varied for one in plan(table=Path("table.csv"))] == [
        {"thickness": 0.008, "cortex": 1.1}, {"thickness": 0.009, "cortex": 1.2},
    ]  # fmt: skip
    assert main(["sweep", "patch", "--points", "table.csv", "--keep", "summary"]) == 0
    heads = list(table()[0])
    assert heads[1:3] == ["thickness [m]", "cortex"]
    assert {"energy [J/m]", "sulcal_depth [m]", "growth", "seconds"} <= set(heads)


def test_the_rows_of_a_table_are_points_and_a_bad_one_is_refused():
    Path("table.csv").write_text("cortex, TangentialGrowth.core\n1.1, 1.02\n1.2, 1.03\n9, 1.04\n")
    found = plan("young=500,900", table=Path("table.csv"))
    assert [one.name for one in found][:2] == [
        f"cortex=1.1, young={young}, core=1.02" for young in (500, 900)
    ]
    assert len(found) == 6
    scene, stored = Maker().made(found[3])
    assert scene.processes[0].cortex == 1.2
    assert scene.processes[0].core == 1.03
    assert scene.terms[0].gray.young == pytest.approx(900)
    assert stored["changed"] == ["young", "cortex"]
    assert stored["parts"] == {"TangentialGrowth.core": 1.03}
    assert [bool(one.refused) for one in found] == 4 * [False] + 2 * [True]
    assert run_point(found[4]).status == "refused"
    assert "line 4: cortex=9 is out of range" in run_point(found[4]).message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("thickness [mm]\n3\n", r"thickness \[mm\]: its values are in m; convert"),
        ("cortex [m]\n1\n", r"cortex \[m\]: it has no unit"),
        ("cortx\n1\n", "no parameter cortx; did you mean cortex"),
        ("cortex\n", "lines of values"),
        ("cortex,young\n1.1\n", "line 2 must have 2 values: cortex, young"),
        ("cortex\n1.1\n1.1\n", "two points are named 'cortex=1.1'"),
        ("cortex\n9\n8\n", "line 2: cortex=9 is out of range"),  # none can be made
    ],
)
def test_tables_that_say_nothing_are_refused(text, message):
    Path("table.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        plan(table=Path("table.csv"))


def test_a_table_that_is_no_text_is_refused_as_one():
    Path("table.csv").write_bytes(b"\x89PNG\r\n\xff")
    with pytest.raises(ValueError, match=r"table\.csv must have a line|has no parameter"):
        plan(table=Path("table.csv"))


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ((), "nothing is varied"),
        (("cortex=1.1,1.2",), "--lhs samples ranges"),
        (("base=roller:free",), "must be one of|ranges"),
        (("cortex=1.1:1.2:1.3:4",), "FIRST:LAST:COUNT"),
        (("cortex=1.2:1.1",), "lowest value below the highest"),
        (("cortex=1.2:9",), "cortex=9 is out of range"),
        (("cortex=1.1:1.2", "cortex=1.3:1.4"), "given twice"),
    ],
)
def test_what_cannot_be_sampled_is_refused(vary, message):
    with pytest.raises(ValueError, match=message):
        plan(*vary, method="lhs", samples=3)


@pytest.mark.parametrize(
    ("vary", "samples", "count"),
    [
        ((("thickness", "8e-3:9e-3:3000"), ("cortex", "1.1:1.3:2000")), 0, 6_000_000),
        ((("thickness", "8e-3:9e-3"),), 20_000_000_000, 20_000_000_000),
        ((("thickness", "8e-3:9e-3"), ("cortex", "1.1:1.3:400")), 300, 120_000),
        ((("cortex", "1.1:1.3:400"), ("Stepping.largest", "0.1:0.5:400")), 0, 160_000),
    ],
)
def test_more_points_than_may_be_are_refused_before_they_are_made(vary, samples, count):
    design = Design(vary, method="lhs" if samples else "", samples=samples)
    with pytest.raises(ValueError, match=f"would have {count} points, and may have 100000: list fewer"):
        points(find_case("patch.py"), Request("patch.py"), design, Path("out"), "last")


def test_of_a_point_the_summary_the_last_state_or_all_is_kept():
    (one,) = plan("cortex=1.2", "first=0.1")
    ends, sizes = [], []
    for keep in ("all", "last", "summary"):  # each in the folder of the one before
        ends.append(run_point(replace(one, keep=keep, running=Running(overwrite=True))))
        files = [file for file in one.folder.rglob("*") if file.is_file()]
        sizes.append(sum(file.stat().st_size for file in files))
        if keep == "all":
            whole = load(one.folder)
        if keep == "last":
            result = load(one.folder)
            assert len(result.states) == 1
            assert (result.last["displacement"] == whole.last["displacement"]).all()
            assert [row["energy"] for row in result.history] == [row["energy"] for row in whole.history]
            assert (one.folder / "frames.pvd").read_text().count("<DataSet") == 1
    assert [file.name for file in files] == ["point.json"]
    assert len(whole.states) > 5
    assert sizes[0] > 3 * sizes[1] > 9 * sizes[2]
    numbers = [{k: v for k, v in end.summary.items() if not k.startswith("seconds")} for end in ends]
    assert numbers[0] == numbers[1] == numbers[2]


def test_tasks_share_a_study_and_its_table_is_collected(capsys):
    Path("table.csv").write_text("cortex\n1.1\n9\n1.2\n")  # one that cannot be
    words = ["sweep", "patch", "--points", "table.csv", "--keep", "summary"]
    assert main([*words, "--task", "1/2"]) == 0
    assert main(["collect", str(STUDY)]) == 0
    assert "3 points: 2 converged, 1 not run" in capsys.readouterr().out
    assert main([*words, "--task", "2/2"]) == 2
    before = [file.stat().st_mtime_ns for file in STUDY.glob("*/point.json")]
    assert main([*words, "--task", "1/2"]) == 0  # that a scheduler starts again
    assert [file.stat().st_mtime_ns for file in STUDY.glob("*/point.json")] == before
    assert main(["collect", str(STUDY)]) == 0
    rows = table()
    assert [row["status"] for row in rows] == ["converged", "refused", "converged"]
    assert "cortex=9 is out of range" in rows[1]["message"]
    assert [float(rows[k]["growth"]) for k in (0, 2)] == pytest.approx([1.1, 1.2], rel=1e-3)
    parts = [table(f"sweep-task-{k}-of-2.csv") for k in (1, 2)]
    assert parts == [[rows[0], rows[2]], [rows[1]]]
    capsys.readouterr()
    assert main(["sweep", "patch", "--vary", "cortex=1.3", "--task", "1/2"]) == 2
    assert "a study with other points" in said(capsys)


def test_a_study_goes_on_and_grows_and_another_case_is_not_mixed_in(capsys):
    words = ["sweep", "patch", "--keep", "summary", "--vary"]
    assert main([*words, "cortex=1.1,1.2"]) == 0
    first = STUDY / "cortex=1.1" / "point.json"
    before = first.stat().st_mtime_ns
    assert main([*words, "cortex=1.1,1.2,1.3", "--resume"]) == 0
    assert "3 points, 2 of them done" in capsys.readouterr().out
    assert first.stat().st_mtime_ns == before
    assert [row["scene"] for row in table()] == ["cortex=1.1", "cortex=1.2", "cortex=1.3"]
    energy = float(table()[0]["energy [J/m]"])
    Path("patch.py").write_text(CASE.replace("0.4)", "0.3)"))
    assert main([*words, "cortex=1.1", "--resume"]) == 0
    assert first.stat().st_mtime_ns > before  # another case: run again
    assert float(table()[0]["energy [J/m]"]) < 0.95 * energy


def test_a_case_that_changes_under_way_fails_its_points_and_no_more():
    (one,) = plan("cortex=1.2")
    Path("patch.py").write_text(CASE + "\n")
    end = run_point(one)
    assert end.status == "failed"
    assert "was changed since the study began" in end.message
    assert not one.folder.exists()


def test_an_error_in_the_program_is_a_row():
    (one,) = plan("cortex=1.2")

    def broken(_):
        raise ZeroDivisionError("of zero")

    end = run_point(one, None, broken)
    assert (end.status, end.message) == ("failed", "ZeroDivisionError: of zero")


def test_a_table_is_also_parquet_with_units():
    parquet = pytest.importorskip("pyarrow.parquet")
    assert main(["sweep", "patch", "--keep", "summary", "--vary", "base=roller,free"]) == 0
    found = parquet.read_table(STUDY / "sweep.parquet")
    assert found.column("base").to_pylist() == ["roller", "free"]
    assert found.schema.field("energy").metadata == {b"unit": b"J/m"}
    assert found.schema.field("sulcal_depth").metadata == {b"unit": b"m"}
    assert found.column("gyrification_index").to_pylist() == [float(r["gyrification_index"]) for r in table()]


def test_a_disk_without_room_is_said_before_anything_runs(monkeypatch, capsys):
    usage = type("Usage", (), {"free": 1e5})
    monkeypatch.setattr("turingfold.cli.sweep.shutil.disk_usage", lambda place: usage)
    assert main(["sweep", "patch", "--keep", "all", "--vary", "cortex=1.1,1.2"]) == 2
    assert "choose --keep summary" in said(capsys)
    assert not Path("results").exists()


@pytest.mark.slow
def test_a_killed_study_loses_only_the_points_that_ran():
    words = ["sweep", "patch", "--keep", "summary", "--vary", "cortex=1.05:1.5:12"]
    driver = subprocess.Popen([sys.executable, "-m", "turingfold", *words, "-j", "2"])
    deadline = time.monotonic() + 100
    while not (STUDY / "sweep.csv").is_file() or len(table()) < 4:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.kill(driver.pid, signal.SIGKILL)
    driver.wait()
    time.sleep(3)  # its processes end after the step that they are in
    known = {row["scene"]: row for row in table()}
    assert len(known) >= 4
    records = {file: file.stat().st_mtime_ns for file in STUDY.glob("*/point.json")}
    assert main([*words, "--resume"]) == 0
    rows = table()
    assert len(rows) == 12
    assert all(row["status"] == "converged" for row in rows)
    assert {row["scene"]: row for row in rows if row["scene"] in known} == known
    assert all(file.stat().st_mtime_ns == when for file, when in records.items())
