"""Runs that do not reach their end: what is reported, stored and drawn is their last accepted state."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
from small import elastic_scene
from test_results import Breaks

import turingfold as tf
from turingfold import Stepping, StoppedError, UnfinishedWarning, load, simulate
from turingfold.results.validity import ended
from turingfold.results.vtu import entries

HURRIED = Stepping(first=0.1, largest=0.1, smallest=1e-3)


def stopped(out):
    """Return what a run that stops at 0.57 gives, with frames each quarter of its time."""
    scene = elastic_scene(Breaks(after=0.57), stepping=HURRIED)
    with pytest.raises(StoppedError) as caught:
        simulate(scene, out, frames=4)
    return caught.value


def read(out):
    with pytest.warns(UnfinishedWarning):
        return load(out, known=[Breaks])


def test_a_run_that_stops_stores_its_last_state(tmp_path):
    error = stopped(tmp_path / "out")
    result, found = error.result, read(tmp_path / "out")
    assert 0.5 < result.last.time < 0.571  # after the frame of 0.5
    assert found.last.time == result.last.time
    np.testing.assert_array_equal(found.last["displacement"], result.last["displacement"])
    assert found.status == result.status == "stopped"
    assert found.message == str(error)
    listed = entries((tmp_path / "out" / "frames.pvd").read_bytes())
    assert listed[-1][0] == result.last.time
    assert (tmp_path / "out" / listed[-1][1]).exists()


def test_summaries_in_memory_on_disk_and_of_what_is_loaded_agree_to_the_digit(tmp_path):
    error = stopped(tmp_path / "out")
    stored = json.loads((tmp_path / "out" / "summary.json").read_text())
    told = {name: value for name, value in stored.items() if name not in ("run", "sha256")}
    assert read(tmp_path / "out").summary() == error.result.summary() == told
    assert stored["growth"] == pytest.approx(1 + 0.3 * stored["time"], rel=1e-12)  # it grows evenly in time


def test_a_run_that_ends_between_frames_keeps_none_of_it_when_it_goes_on(tmp_path):
    scene, rows = elastic_scene(stepping=HURRIED), []

    def interrupt(row):
        rows.append(row)
        if len(rows) == 6:
            raise KeyboardInterrupt

    simulate(scene, tmp_path / "whole", frames=4)
    with pytest.raises(KeyboardInterrupt):
        simulate(scene, tmp_path / "out", progress=interrupt, frames=4)
    with pytest.warns(UnfinishedWarning, match=r"interrupted at t = 0\.6 of 1"):
        assert load(tmp_path / "out").last.time == rows[-1]["time"]
    assert simulate(scene, tmp_path / "out", resume=True, frames=4).converged
    for kind in ("states", "frames"):
        of_whole = {file.name: file.read_bytes() for file in (tmp_path / "whole" / kind).iterdir()}
        assert {file.name: file.read_bytes() for file in (tmp_path / "out" / kind).iterdir()} == of_whole
    assert (tmp_path / "out/frames.pvd").read_bytes() == (tmp_path / "whole/frames.pvd").read_bytes()


class Killed(BaseException):
    """What nobody catches: to the run's files, a kill."""


def killed(out, after=8, **options):
    rows = []

    def kill(row):
        rows.append(row)
        if len(rows) == after:
            raise Killed

    with pytest.raises(Killed):
        simulate(elastic_scene(stepping=HURRIED), out, progress=kill, frames=2, **options)
    return rows


def test_a_killed_run_is_said_to_be_unfinished_and_shows_its_last_checkpoint(tmp_path, monkeypatch):
    monkeypatch.setattr("turingfold.results.simulate.CHECKPOINT", 0.0)
    rows = killed(tmp_path / "out")
    with pytest.warns(UnfinishedWarning, match=r"out: interrupted at t = 0\.8 of 1\. .*resume"):
        found = load(tmp_path / "out")
    assert not found.converged
    assert found.last.time == rows[-1]["time"]
    assert [state.time for state in found.states] == [0.0, pytest.approx(0.5), rows[-1]["time"]]
    assert found.summary()["energy"] == rows[-1]["energy"]


def test_what_came_after_a_killed_run_s_last_state_is_not_reported(tmp_path):
    rows = killed(tmp_path / "out")  # with a checkpoint at the start alone; the last state is the one of 0.5
    with pytest.warns(UnfinishedWarning):
        found = load(tmp_path / "out")
    assert found.summary()["time"] == found.history[-1]["time"] == rows[4]["time"]
    assert found.summary()["energy"] == rows[4]["energy"]
    (tmp_path / "out/states/000005.npz").unlink()
    with pytest.warns(UnfinishedWarning, match="at t = 0 of 1"):
        assert load(tmp_path / "out").history == ()


def test_going_on_takes_back_what_a_summary_says(tmp_path):
    scene = elastic_scene(stepping=Stepping(first=0.1, largest=0.1, smallest=1e-3, seconds=1e-9))
    with pytest.raises(StoppedError):
        simulate(scene, tmp_path / "out")
    killed(tmp_path / "out", resume=True)
    assert not (tmp_path / "out" / "summary.json").exists()
    with pytest.warns(UnfinishedWarning, match="interrupted"):
        load(tmp_path / "out")


def test_a_finished_run_is_loaded_without_a_word(tmp_path):
    simulate(elastic_scene(), tmp_path / "out")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load(tmp_path / "out").unfinished == ""


def test_states_are_found_by_their_time():
    result = simulate(elastic_scene(stepping=Stepping(first=0.25, largest=0.25)))
    times = [state.time for state in result.states]
    assert times == [0.0, 0.25, 0.5, 0.75, 1.0]
    found = [result.at(time=t) for t in (0.0, 0.1, 0.3, 0.76, 1.0)]
    assert all(state is result.states[k] for state, k in zip(found, (0, 0, 1, 3, 4), strict=True))
    assert result.at(time=0.75, exact=True) is result.states[3]
    np.testing.assert_array_equal(result.pial(found[3]), result.pial(3))
    with pytest.raises(ValueError, match=r"time=0\.76 has no state, the nearest is 0\.75"):
        result.at(time=0.76, exact=True)
    with pytest.raises(ValueError, match=r"time=1\.1 must be from 0 to 1"):
        result.at(time=1.1)


def test_an_end_with_triangles_turned_over_is_invalid(tmp_path, monkeypatch):
    turned = iter([0, 0, 2, 1] + 20 * [0])  # in between only
    monkeypatch.setattr("turingfold.results.simulate.inverted", lambda body, state: next(turned))
    result = simulate(elastic_scene(stepping=HURRIED), tmp_path / "out")
    assert result.status == "invalid"
    assert not result.converged
    with pytest.warns(UnfinishedWarning, match=r"invalid at .* 2 of 10 states, the first that of t = 0\.3,"):
        assert load(tmp_path / "out").summary() == result.summary()


def rows(**columns):
    """Return a history of four rows with other numbers in some columns."""
    usual = {"inverted_elements": [0] * 4, "self_intersections": [0] * 4, "negative_pivots": [0] * 4}
    table = {"time": [0.25, 0.5, 0.75, 1.0], **usual, **columns}
    return [dict(zip(table, values, strict=True)) for values in zip(*table.values(), strict=True)]


def test_every_fault_of_an_invalid_run_is_named():
    status, message = ended(
        rows(inverted_elements=[0, 2, 1, 0], self_intersections=[0, 0, 0, 5]), moves=False
    )
    assert status == "invalid"
    assert "2 of 4 states, the first that of t = 0.5, have triangles that are turned over" in message
    assert "1 of 4 states, the first that of t = 1, have a boundary that crosses itself" in message
    assert "smaller elements or less growth, and SelfContact" in message
    assert "minimum" not in message
    only = ended(rows(self_intersections=[0, 0, 0, 5]), moves=False)[1]
    assert "turned over" not in only
    assert "less growth" not in only


@pytest.mark.parametrize(("count", "words"), [(1, "it has 1 direction in"), (3, "it has 3 directions in")])
def test_a_run_that_ends_on_a_saddle_says_so(count, words):
    status, message = ended(rows(negative_pivots=[0, 0, 0, count]), moves=False)
    assert status == "converged"
    assert message.startswith(f"The last state is no minimum of the energy: {words} which that falls, so")
    told = ended(rows(negative_pivots=[0, 0, 0, count]), moves=True)[1]
    assert "no minimum of the step's incremental potential" in told
    status, message = ended(rows(inverted_elements=[1] * 4, negative_pivots=[0, 0, 0, count]), moves=False)
    assert status == "invalid"
    assert words in message
    assert ended(rows(negative_pivots=[count, count, 2, 0]), moves=False) == ("converged", "")


def test_the_saddle_that_a_nearly_incompressible_body_passes_is_told_of_where_it_ends_there(tmp_path):
    body = tf.semicircle(radius=1.0, thickness=0.25, elements=1, base="roller")
    solid = tf.Elastic(gray=tf.NeoHookean.from_young(3.0, 0.4995))
    swelling = tf.Swelling(coefficient=0.8, zone="cortex")
    scene = tf.Scene(body=body, terms=(solid,), processes=(swelling,), until=0.55)
    result = simulate(scene, tmp_path / "out", errors=False)
    assert result.status == "converged"
    assert result.summary()["negative_pivots"] == 1
    assert "it has 1 direction in which that falls" in result.message
    assert load(tmp_path / "out").message == result.message  # without a warning: it is at its end
    assert simulate(replace(scene, until=0.6)).message == ""


def test_a_scene_that_stops_at_once_has_its_start(tmp_path):
    scene = elastic_scene(Breaks(after=0.0), stepping=HURRIED)
    with pytest.raises(StoppedError) as caught:
        simulate(scene, tmp_path / "out")
    with pytest.warns(UnfinishedWarning, match="stopped at t = 0 of 1"):
        assert load(tmp_path / "out", known=[Breaks]).summary() == caught.value.result.summary()


def test_walls_that_pass_through_the_mirror_or_each_other_end_as_invalid():
    """Without contact: half a disc whose surface crosses its image, counted as on the whole.

    With three elements: with two a triangle turns over too, and that is what is said first.
    """
    body = tf.half(tf.semicircle(radius=1.0, thickness=0.2, elements=3, base="roller"))
    solid = tf.Elastic(gray=tf.NeoHookean(mu=1.0, kappa=5.0))
    scene = tf.Scene(body=body, terms=(solid,), processes=(tf.TangentialGrowth(cortex=1.8),))
    result = simulate(scene)
    crossings = tf.self_intersections(result.pial(), closed=False, quadratic=True)  # of both halves
    assert result.summary()["self_intersections"] == crossings > 0
    assert result.status == "invalid"
    assert "SelfContact" in result.message
