"""Problems with known answers, outside the tests: each holds, and a wrong answer is told."""

import csv
import math
from dataclasses import replace

import pytest

from turingfold.cli.main import main
from turingfold.cli.verify import verify
from turingfold.verification import Check, Quantity, checks

CHEAP = ("linear theory", "closed thresholds", "isolation", "weeks", "tissue", "rotation", "patch", "line")


def wrong(check, number):
    """Return a check whose first expected number is another one."""

    def compute():
        first, *others = check.compute()
        return [replace(first, expected=number), *others]

    return replace(check, compute=compute)


def test_cheap_problems_hold_and_are_written(tmp_path, capsys):
    file = tmp_path / "verify.csv"
    assert main(["verify", *CHEAP, "--out", str(file)]) == 0
    out = capsys.readouterr().out
    assert "Brusselator: critical ratio" in out
    assert "FAIL" not in out
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert len(rows) > 50
    assert {row["holds"] for row in rows} == {"True"}
    assert all(abs(float(row["got"]) - float(row["expected"])) < 1e-3 for row in rows)


def test_a_wrong_answer_gives_status_3(capsys):
    (check,) = checks(["closed thresholds"])
    assert verify([wrong(check, 7.5)]).status == 3
    assert capsys.readouterr().out.count("FAIL") == 1


@pytest.mark.parametrize(("expected", "got", "holds"), [
    (2.0, 2.02, True), (2.0, 2.03, False), (0.0, 0.005, True), (0.0, 0.02, False), (1.0, math.nan, False),
])  # fmt: skip
def test_errors_are_relative_or_absolute_at_zero_and_nan_fails(expected, got, holds):
    assert Quantity("number", expected, got, 0.0101).holds == holds


def test_a_word_that_names_no_problem_is_refused(capsys):
    assert main(["verify", "phrenology"]) == 2
    assert "'phrenology'" in capsys.readouterr().err


def test_every_problem_has_its_formula_and_its_own_name():
    every = checks(full=True)
    assert len({check.problem for check in every}) == len(every) > len(checks())
    assert all(isinstance(check, Check) and check.source and check.compute.__doc__ for check in every)


@pytest.mark.slow
@pytest.mark.parametrize("check", checks(full=True), ids=lambda check: check.problem)
def test_problem(check):
    for one in check.compute():
        assert one.holds, one
