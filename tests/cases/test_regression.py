"""The store of the cases' numbers: what it tells, what it lets pass, and what renewing keeps."""

import pytest
import regression
from regression import CASES, as_row, differences, renew, stored

SUMMARY = {
    "status": "converged", "folds": 12, "steps": 30, "newton_iterations": 200, "factorizations": 180,
    "perimeter": 0.31, "energy": 0.85, "gyrification_index": 1.42,
}  # fmt: skip


@pytest.fixture
def store(tmp_path):
    """Return a store of two cases, one of which hangs on a branch."""
    path = tmp_path / "store.csv"
    renew("smooth", {"one": SUMMARY}, path)
    renew("folded", {"one": SUMMARY, "two": SUMMARY}, path)
    text = path.read_text().replace("folded,one,nothing", "folded,one,branch")
    path.write_text(text)
    return path


def test_the_same_numbers_differ_in_nothing(store):
    assert differences("smooth", {"one": SUMMARY}, store) == []


@pytest.mark.parametrize(("changed", "told"), [
    ({"energy": 0.85 * (1 + 3e-6)}, "energy 0.85 -> 0.85000255 (+0.0003 %)"),
    ({"gyrification_index": 1.43}, "gyrification_index 1.42 -> 1.43 (+0.7 %)"),
    ({"perimeter": 0.30}, "perimeter 0.31 -> 0.3 (-3.2 %)"),
    ({"folds": 11}, "folds 12 -> 11"),
    ({"status": "stopped"}, "status converged -> stopped"),
    ({"newton_iterations": 300}, "newton_iterations 200 -> 300 (+50 %), allowed 60"),
    ({"energy": None}, "energy 0.85 -> none"),
])  # fmt: skip
def test_what_moves_is_told_with_both_values(store, changed, told):
    (line,) = differences("smooth", {"one": SUMMARY | changed}, store)
    assert line.startswith(f"smooth, one: {told}")


@pytest.mark.parametrize("changed", [
    {"energy": 0.85 * (1 + 1e-7)}, {"newton_iterations": 210, "factorizations": 200, "steps": 33},
])  # fmt: skip
def test_rounding_and_a_little_work_pass(store, changed):
    assert differences("smooth", {"one": SUMMARY | changed}, store) == []


def test_a_branch_that_rounding_chooses_passes_and_no_more(store):
    other = SUMMARY | {"energy": 0.8, "gyrification_index": 1.5, "folds": 10}
    (line,) = differences("folded", {"one": other, "two": other}, store)
    assert line.startswith("folded, two: ")
    (line,) = differences("folded", {"one": SUMMARY | {"energy": 0.6}, "two": SUMMARY}, store)
    assert line.startswith("folded, one: energy")


def test_scenes_without_row_and_rows_without_scene_are_told(store):
    lines = differences("folded", {"one": SUMMARY, "three": SUMMARY}, store)
    assert [line.partition(";")[0] for line in lines] == [
        "folded, three: has no row", "folded, two: is no scene any more",
    ]  # fmt: skip


def test_renewing_leaves_other_cases_and_what_a_scene_hangs_on(store):
    renew("folded", {"one": SUMMARY | {"energy": 0.9}}, store)
    rows = stored(store)
    assert list(rows) == [("folded", "one"), ("smooth", "one")]
    assert rows["folded", "one"] == as_row("folded", "one", SUMMARY | {"energy": 0.9}, "branch")
    assert rows["smooth", "one"] == as_row("smooth", "one", SUMMARY)


def test_every_row_is_of_a_case_and_hangs_on_something_known():
    rows = stored().values()
    assert {row["case"] for row in rows} == set(CASES)
    assert all(row["hangs_on"] in regression.TOLERANCES for row in rows)
    assert all(list(row) == list(regression.COLUMNS) for row in rows)


def test_a_case_that_is_none_is_refused(capsys):
    with pytest.raises(SystemExit):
        regression.main(["figure33"])
    assert "there is no case figure33; there are dynamics" in capsys.readouterr().err
