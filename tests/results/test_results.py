"""Running scenes: what comes back, and what a failure leaves."""

import copy
import json
import pickle
import re
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from small import GROWTH, RADIUS, THICKNESS, elastic_scene

from turingfold import (
    CoarseMeshWarning,
    Drag,
    Elastic,
    NotConvergedError,
    PathStoppedError,
    Result,
    State,
    Stepping,
    StoppedError,
    half,
    load,
    semicircle,
    simulate,
)
from turingfold.cli.summary import told
from turingfold.extend import Evolution, Process
from turingfold.results.files import json_content
from turingfold.turing.process import Turing

KEYS = {
    "perimeter", "errors", "no_errors", "step_errors", "no_step_errors", "quadrature_errors",
    "softness", "status", "message", "time", "area_growth", "cortex_growth", "core_growth", "centre_growth",
    "dofs", "triangles", "elements_through_cortex", "steps", "newton_iterations", "factorizations",
    "seconds", "seconds_by_part", "growth", "energy", "residual", "negative_pivots", "saddles", "snaps",
    "damped_steps",
    "min_jacobian", "min_gap", "holding_force",
    "inverted_elements", "self_intersections", "gyrification_index",
    "closed_gyrification_index", "closing_radius", "folds", "sulcal_depth", "least_fold_depth",
    "fold_smoothing", "mirror_error", "registration", "registration_p",
    "pattern_half_waves", "converged",
}  # fmt: skip


@pytest.fixture(scope="module")
def grown():
    return simulate(elastic_scene())


@dataclass(frozen=True)
class Breaks(Process):
    """Tangential growth by 1 + 0.3 t until `after`, then not a number; with `after` < 0 it does not begin."""

    after: float = 0.5

    @property
    def writes(self):
        return ("growth",)

    def on(self, body):
        return BreaksOnBody(self.after, (3, *body.quadrature.weights.shape))


@dataclass(frozen=True)
class BreaksOnBody(Evolution):
    after: float
    shape: tuple[int, ...]

    def start(self, state, seed):
        if self.after < 0:
            raise NotConvergedError("no pattern")
        return self.advance(state, state, 0.0)

    def advance(self, before, now, dt):
        growth = np.ones(self.shape)
        growth[0] = 1 + 0.3 * now.time if now.time <= self.after else np.nan
        return {"growth": growth}


def test_states_go_from_rest_to_the_end(grown):
    times = [state.time for state in grown.states]
    assert times[0] == 0.0
    assert times[-1] == grown.scene.until
    assert (np.diff(times) > 0).all()
    assert not grown.states[0]["displacement"].any()
    assert grown.last is grown.states[-1]


def test_history_has_a_row_per_step(grown):
    assert len(grown.history) == len(grown.states) - 1
    assert [row["time"] for row in grown.history] == [state.time for state in grown.states[1:]]
    assert sum(row["step"] for row in grown.history) == pytest.approx(grown.scene.until, rel=1e-12)
    # linear history: g - 1 is proportional to time
    for row in grown.history:
        assert row["growth"] == pytest.approx(1 + (GROWTH - 1) * row["time"], rel=1e-12)


def test_a_result_is_shown_in_a_line(grown):
    assert re.fullmatch(r"Result\(reached the end at t = 1, growth 1\.3, \d+ steps\)", repr(grown))


@pytest.mark.parametrize("asked", ["pial", "pattern", "observe"])
def test_a_step_that_does_not_exist_is_named(grown, asked):
    count = len(grown.states)
    assert np.array_equal(grown.pial(-count), grown.pial(0))
    for step in (count, -count - 1, 0.5, None):
        with pytest.raises(ValueError, match=rf"step={step} must be .*has {count} states, 0 to {count - 1}"):
            getattr(grown, asked)(step)


def test_progress_sees_every_row():
    rows = []
    result = simulate(elastic_scene(), progress=rows.append)
    assert rows == list(result.history)


def test_pial_surface_at_rest_is_the_half_circle(grown):
    x, y = grown.pial(0)
    assert np.hypot(x, y) == pytest.approx(RADIUS, abs=1e-4)  # the middles of edges are on the circle too
    angle = np.arctan2(y, x)
    assert angle[0] == pytest.approx(0.0, abs=1e-12)
    assert angle[-1] == pytest.approx(np.pi, abs=1e-12)
    assert (np.diff(angle) > 0).all()
    assert grown.pial().shape == grown.pial(0).shape


def test_half_body_reports_the_whole_surface():
    body = semicircle(radius=RADIUS, thickness=THICKNESS, size=0.25)
    whole, part = simulate(elastic_scene(body=body)), simulate(elastic_scene(body=half(body)))
    np.testing.assert_allclose(part.pial(0), whole.pial(0), atol=1e-14)
    np.testing.assert_allclose(part.pial(), whole.pial(), atol=1e-7)
    of_part, of_whole = part.summary(), whole.summary()
    assert of_part["mirror_error"] == 0.0
    assert of_part["gyrification_index"] == pytest.approx(of_whole["gyrification_index"], rel=1e-6)


def test_observe_at_rest_shows_no_stress(grown):
    fields = grown.observe(0)
    shape = grown.scene.body.quadrature.weights.shape
    assert {name: values.shape for name, values in fields.items()} == dict.fromkeys(
        ("von_mises", "pressure", "jacobian", "stress_xx", "stress_yy", "stress_xy", "stress_zz"), shape
    )
    assert np.abs(fields["von_mises"]).max() < 1e-12
    assert np.abs(fields["jacobian"] - 1).max() < 1e-13
    assert np.abs(grown.observe()["von_mises"]).max() > 0.01  # growth that is held back stresses the body


def test_observing_discretises_each_term_once(grown, monkeypatch):
    made, original = [], Elastic.on
    monkeypatch.setattr(Elastic, "on", lambda term, body: made.append(body) or original(term, body))
    again = Result(grown.scene, grown.states, grown.history)
    last, first, last_again = again.observe(), again.observe(0), again.observe()
    assert len(made) == 1
    for name, values in last.items():
        np.testing.assert_array_equal(values, last_again[name])  # what came between leaves no trace
        np.testing.assert_array_equal(values, grown.observe()[name])
        assert np.abs(values - first[name]).max() > 0.01


def test_summary_of_a_scene_without_pattern_and_contact(grown):
    summary = grown.summary()
    body = grown.scene.body
    base = body.nodes[1] == 0
    assert set(summary) == KEYS
    assert summary["dofs"] == 2 * (body.nodes.shape[1] - base.sum())  # clamped
    assert summary["triangles"] == body.mesh.nelements
    assert summary["elements_through_cortex"] == 1.0
    assert summary["growth"] == GROWTH
    assert summary["steps"] == len(grown.history)
    assert summary["newton_iterations"] == sum(row["newton_iterations"] for row in grown.history)
    assert summary["min_jacobian"] == min(row["min_jacobian"] for row in grown.history)
    assert summary["registration"] is None
    assert summary["min_gap"] is None
    assert summary["holding_force"] is None
    assert summary["self_intersections"] == 0
    assert summary["mirror_error"] < 1e-9 * RADIUS
    assert summary["converged"] is True
    assert 0 < sum(summary["seconds_by_part"].values()) <= summary["seconds"]


def test_summary_of_a_folding_scene(folded):
    summary = folded.summary()
    assert -1 <= summary["registration"] <= 1
    turing = next(part for part in folded.scene.processes if isinstance(part, Turing))
    assert summary["pattern_half_waves"] == turing.half_waves
    assert summary["min_gap"] > 0
    assert folded.pattern().shape == folded.pial().shape[1:]
    assert folded.pattern().min() >= 0
    assert folded.pattern().max() <= 1


def test_a_march_that_stops_keeps_what_it_reached():
    scene = elastic_scene(Breaks(), stepping=Stepping(first=0.1, largest=0.1, smallest=1e-3))
    with pytest.raises(StoppedError, match=r"'growth' is not finite") as caught:
        simulate(scene)
    result = caught.value.result
    assert 0.5 - 2e-3 <= result.last.time <= 0.5
    assert caught.value.time == result.last.time
    assert not result.converged
    assert result.summary()["converged"] is False
    assert len(result.history) == len(result.states) - 1


def test_a_scene_that_does_not_begin_says_why():
    with pytest.raises(NotConvergedError, match="no pattern"):
        simulate(elastic_scene(Breaks(after=-1.0)))


def test_the_time_limit_stops_a_march():
    with pytest.raises(StoppedError, match="time limit"):
        simulate(elastic_scene(stepping=Stepping(seconds=1e-9)))


@pytest.mark.parametrize("options", [{"frames": 0}, {"resume": True}, {"overwrite": True}])
def test_options_that_make_no_sense(options):
    with pytest.raises(ValueError, match=r"frames=0|need a folder"):
        simulate(elastic_scene(), **options)


def test_going_on_and_starting_over_exclude_each_other(tmp_path):
    with pytest.raises(ValueError, match="choose one of the two"):
        simulate(elastic_scene(), tmp_path / "out", resume=True, overwrite=True)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("scene", [None, elastic_scene, "cases/figure3.py"])
def test_only_a_scene_can_be_run(scene):
    with pytest.raises(ValueError, match=r"scene=.* must be a Scene object, such as Scene\(body="):
        simulate(scene)


def test_elements_that_turn_over_beside_the_integration_points_are_counted():
    result = simulate(elastic_scene())
    assert result.summary()["inverted_elements"] == 0
    body, state = result.scene.body, result.last
    corner = body.mesh.t[0, body.in_cortex.argmax()]
    moved = state["displacement"].copy()
    opposite = body.nodes[:, body.mesh.t[1:3, body.in_cortex.argmax()]].mean(1)
    moved[:, corner] = 1.6 * (opposite - body.nodes[:, corner])  # through the opposite side
    turned = replace(result, states=(*result.states[:-1], state.updated(displacement=moved)))
    assert turned.summary()["inverted_elements"] >= 1


def test_mixed_elements_that_their_bubbles_turn_over_are_counted():
    made = elastic_scene()
    result = simulate(replace(made, terms=(replace(made.terms[0], element="mixed"),)))
    assert result.summary()["inverted_elements"] == 0
    bubble = result.last["bubble"].copy()
    bubble[0, 3] += THICKNESS
    turned = replace(result, states=(*result.states[:-1], result.last.updated(bubble=bubble)))
    assert turned.summary()["inverted_elements"] == 1


def test_a_coarse_cortex_is_warned_about():
    with pytest.warns(CoarseMeshWarning, match=r"only 1 element\(s\) through the cortex"):
        simulate(elastic_scene())
    fine = semicircle(radius=1.0, thickness=0.4, size=0.1)
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always", CoarseMeshWarning)
        simulate(elastic_scene(body=fine, stepping=Stepping(first=1.0, largest=1.0), until=0.1))
    assert not [warning for warning in given if warning.category is CoarseMeshWarning]


@pytest.mark.parametrize("copied", [lambda item: pickle.loads(pickle.dumps(item)), copy.deepcopy])
def test_results_states_and_errors_can_be_copied(copied, folded):
    folded.observe()  # with what is kept from it
    again = copied(folded)
    assert again.summary() == folded.summary()
    assert repr(again.history) == repr(folded.history)
    for state, other in zip(again.states, folded.states, strict=True):
        assert state.fields.keys() == other.fields.keys()
        assert all(np.array_equal(state[name], other[name]) for name in state.fields)
    with pytest.raises(TypeError, match="item assignment"):
        again.last.fields["displacement"] = None
    stopped = copied(StoppedError(NotConvergedError("why", time=0.5, residual=1e-3), folded))
    assert (type(stopped), str(stopped), stopped.time, stopped.residual) == (StoppedError, "why", 0.5, 1e-3)
    assert stopped.result.summary() == folded.summary()
    path = copied(PathStoppedError("why", None, time=0.5, residual=1e-3))
    assert (str(path), path.path, path.time) == ("why", None, 0.5)


@dataclass(frozen=True)
class StartsSlowly(Breaks):
    def on(self, body):
        time.sleep(0.3)
        return super().on(body)


def test_the_time_limit_counts_what_the_start_takes():
    hurried = Stepping(first=0.1, largest=0.1, seconds=0.25)
    with pytest.raises(StoppedError, match=r"at t = 0 of 1: the time limit of 0\.25 s is reached"):
        simulate(elastic_scene(StartsSlowly(after=1.0), stepping=hurried))


def test_what_holds_a_body_is_not_counted_as_unknown():
    """A free body keeps 3 unknowns only to hold it in place; where drag does that, none."""
    body = semicircle(radius=RADIUS, thickness=THICKNESS, size=0.25, base="free")
    for more, held in (((), 3), ((Drag(coefficient=1.0),), 0)):
        scene = elastic_scene(body=body)
        scene = replace(scene, terms=(*scene.terms, *more))
        assert Result(scene, (State(0.0, {"displacement": 0 * body.nodes}),), ()).summary()["dofs"] == (
            2 * body.nodes.shape[1] - held
        )


def test_states_that_are_no_minima_and_snaps_are_summed_up_and_told(grown):
    rows = [dict(row) for row in grown.history]
    for k, pivots, snapped in ((1, 3, 0.0), (2, 0, 1.0), (-1, 2, 1.0)):
        rows[k] |= {"negative_pivots": pivots, "snapped": snapped}
    result = replace(grown, history=tuple(rows))
    summary = result.summary()
    assert (summary["negative_pivots"], summary["saddles"], summary["snaps"]) == (2, 2, 2)
    steps = len(rows)
    said = f"2 of {steps} states no minimum, the last one too; 2 of {steps} reached by a snap"
    assert f"equilibria: {said}" in told("case", {"one": result}, Path("out"))
    assert next(told("case", {"one": result, "two": grown}, Path("out"))).endswith(said)
    assert not any("equilibria" in line for line in told("case", {"one": grown}, Path("out")))


def test_a_result_of_a_program_without_estimates_is_read(tmp_path):
    simulate(elastic_scene(), tmp_path / "old")
    file = tmp_path / "old" / "summary.json"
    summary = json.loads(file.read_text())
    for name in ("errors", "no_errors", "step_errors", "no_step_errors", "quadrature_errors", "sha256"):
        del summary[name]
    file.write_bytes(json_content(summary, signed=True))
    assert load(tmp_path / "old").status == "converged"
