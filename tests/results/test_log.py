"""log.txt: what is told of a run, of one that goes on, of warnings and of errors that nobody expects."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from small import elastic_scene
from test_results import Breaks

import turingfold as tf
from turingfold import Stepping, StoppedError, Tracker, simulate
from turingfold.results.files import OutputError

HURRIED = Stepping(first=0.1, largest=0.1, smallest=1e-3)


def lines(folder):
    """Return the lines of a log without their times, each of which must be one of today's."""
    text = (folder / "log.txt").read_text()
    found = re.findall(r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00 +(.*(?:\n  .*)*)$", text, re.MULTILINE)
    assert sum(one.count("\n") + 1 for one in found) == text.count("\n")
    return found


def test_a_run_says_with_what_how_far_and_how_it_ended(tmp_path):
    result = simulate(elastic_scene(stepping=HURRIED), tmp_path, case={"command": "turingfold run mine"})
    head, body, begins, *progress, end = lines(tmp_path)
    command, versions = head.splitlines()
    assert command == "turingfold run mine"
    assert f"numpy {np.__version__}" in versions
    assert body == f"{result.summary()['triangles']} triangles, 1 through the cortex"
    assert begins.startswith("begins: t = 0 of 1, growth 1.0000, 0 steps, 0 iterations")
    assert [line.split(",")[0] for line in progress] == [f"{10 * k}%" for k in range(1, 11)]
    spent = sum(row["newton_iterations"] for row in result.history)
    assert end.startswith(f"converged: t = 1 of 1, growth 1.3000, 10 steps, {spent} iterations, ")


def test_many_steps_have_ten_lines_and_few_have_one_each(tmp_path):
    for first, count in ((0.5, 2), (0.02, 10)):
        steps = Stepping(first=first, largest=first)
        simulate(elastic_scene(stepping=steps), tmp_path / str(first))
        assert len([line for line in lines(tmp_path / str(first)) if "%" in line]) == count


def test_a_run_that_stops_and_goes_on_adds_to_its_log_and_a_new_one_begins_anew(tmp_path):
    scene = elastic_scene(Breaks(after=0.57), stepping=HURRIED)
    with pytest.raises(StoppedError) as stop:
        simulate(scene, tmp_path)
    first = (tmp_path / "log.txt").read_text()
    status, message = lines(tmp_path)[-1].split("\n  ")
    assert status.startswith("stopped: t = 0.56")
    assert message == str(stop.value)
    with pytest.raises(StoppedError):
        simulate(scene, tmp_path, resume=True)
    both = (tmp_path / "log.txt").read_text()
    assert both.startswith(first)
    assert "goes on: t = 0.5" in both.removeprefix(first)
    with pytest.raises(StoppedError):
        simulate(scene, tmp_path, overwrite=True)
    assert (tmp_path / "log.txt").read_text().count("begins") == 1


def test_warnings_are_told_and_shown(tmp_path):
    def warn(state, fields):
        warnings.warn("the moon is full", stacklevel=1)

    with pytest.warns(UserWarning, match="the moon is full"):
        simulate(elastic_scene(), tmp_path, trackers=[Tracker(call=warn, times=(0.5,))])
    assert "warning: the moon is full" in lines(tmp_path)
    shown = warnings.showwarning
    with pytest.raises(ValueError, match="already holds"):
        simulate(elastic_scene(), tmp_path)
    assert warnings.showwarning is shown


def test_an_error_that_nobody_expects_is_told(tmp_path):
    def fail(state, fields):
        raise LookupError("no such thing")

    with pytest.raises(LookupError):
        simulate(elastic_scene(), tmp_path, trackers=[Tracker(call=fail, times=(0.5,))])
    assert lines(tmp_path)[-1] == "ended by LookupError: no such thing"


def test_a_run_that_stops_before_its_first_state_is_in_its_log(tmp_path):
    pattern = tf.Turing(tf.Schnakenberg(), half_waves=4)
    scene = elastic_scene(pattern, stepping=Stepping(first=0.1, largest=0.1, seconds=1e-9))
    with pytest.raises(tf.NotConvergedError, match="the time limit was reached while the pattern was sought"):
        simulate(scene, tmp_path)
    assert lines(tmp_path)[-1].startswith("stopped before the first state: the time limit was reached")


def test_a_log_is_not_written_through_a_link(tmp_path):
    mine, out = tmp_path / "mine", tmp_path / "out"
    mine.write_text("mine")
    simulate(elastic_scene(), out)
    (out / "log.txt").unlink()
    (out / "log.txt").symlink_to(mine)
    with pytest.raises(OutputError, match=r"log\.txt: .*nothing is written through links"):
        simulate(elastic_scene(), out, resume=True)
    assert mine.read_text() == "mine"


def test_results_without_a_log_are_loaded_and_gone_on_with(tmp_path):
    simulate(elastic_scene(), tmp_path)
    (tmp_path / "log.txt").unlink()
    assert tf.load(tmp_path).converged
    assert simulate(elastic_scene(), tmp_path, resume=True).converged
    assert lines(Path(tmp_path))[-1].startswith("converged: ")
