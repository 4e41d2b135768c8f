"""Checks of input: what is refused, and by which words."""

import numpy as np
import pytest

from turingfold.checks import file_path, finite, finite_array


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.array([1.0, 2.0 + 1j]), "points is complex; it must be real"),
        ([1.0, 2.0 + 0j], "points is complex; it must be real"),
        (np.array([1.0, 2.0j], dtype=object), "must be an array of numbers"),
        (["one", "two"], "must be an array of numbers"),
        (["one"] * 5000, "points=.{100,200} must be an array of numbers"),
        ([[1.0], [2.0, 3.0]], "must be an array of numbers"),
        ([1.0, np.nan], r"points is nan at index \(1,\)"),
        ([1.0, 2.0, 3.0], r"shape \(3,\); it must be \(2,\)"),
    ],
)
def test_arrays_that_are_not_real_are_refused(value, message):
    with pytest.raises(ValueError, match=message):
        finite_array("points", value, (2,))


def test_an_array_in_place_of_a_number_is_told_by_its_shape():
    with pytest.raises(ValueError, match=r"^size=an array of shape \(99,\) must be a finite number\.$"):
        finite("size", np.ones(99))


def test_real_arrays_are_taken_over_without_a_copy():
    given = np.array([1.0, 2.0])
    assert finite_array("points", given, (2,)) is given
    assert finite_array("points", [1, 2], (None,)).dtype == float


def test_a_path_is_that_of_a_file(tmp_path):
    (tmp_path / "a.csv").write_text("")
    assert file_path("path", str(tmp_path / "a.csv"), "a table") == tmp_path / "a.csv"
    for value, message in ((None, "path=None must be the path of a table"), (tmp_path, "there is no file")):
        with pytest.raises(ValueError, match=message):
            file_path("path", value, "a table")
