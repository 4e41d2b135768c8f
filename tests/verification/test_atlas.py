"""The atlas: its judge finds what is wrong, its cells are the same again, and its tables are gone on with."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from small import elastic_scene

from turingfold import Drag, Elastic, NeoHookean, Schnakenberg, SelfContact, Turing, semicircle, simulate
from turingfold.cli.main import main
from turingfold.verification.atlas import patterns
from turingfold.verification.atlas.cells import drawn, scene
from turingfold.verification.atlas.judge import crosses, faults, least_determinant, residual
from turingfold.verification.atlas.run import judged


@pytest.fixture(scope="module")
def result():
    """Return a result of sigmoid layers with two materials, drag and contact."""
    made = elastic_scene(body=semicircle(radius=1.0, thickness=0.25, size=0.25, layers="sigmoid"))
    soft, stiff = NeoHookean(mu=1.0, kappa=5.0), NeoHookean(mu=3.0, kappa=9.0)
    terms = (Elastic(gray=stiff, white=soft), SelfContact(), Drag(coefficient=0.1))
    return simulate(replace(made, terms=terms))


def changed(result, **fields):
    return replace(result, states=(*result.states[:-1], result.last.updated(**fields)))


def test_a_valid_result_has_no_faults(result):
    assert faults(result) == []
    assert residual(result) < 1e-7


def test_a_node_out_of_its_place_is_found(result):
    moved = result.last["displacement"].copy()
    node = int(np.argmin(np.hypot(result.scene.body.nodes[0], result.scene.body.nodes[1] - 0.4)))
    moved[0, node] += 1e-5
    (fault,) = faults(changed(result, displacement=moved))
    assert fault.startswith("residual")


def test_other_moduli_or_growth_are_found(result):
    stiff = NeoHookean(mu=3.0001, kappa=9.0)
    elastic = replace(result.scene.terms[0], gray=stiff)
    other = replace(result, scene=replace(result.scene, terms=(elastic, *result.scene.terms[1:])))
    assert faults(other)[0].startswith("residual")
    assert faults(changed(result, growth=1.0001 * result.last["growth"]))[0].startswith("residual")


def test_a_triangle_that_is_turned_over_in_a_corner_is_found(result):
    body, moved = result.scene.body, np.zeros_like(result.scene.body.nodes)
    corner, middle = body.triangles[0, 0], body.triangles[3, 0]  # det F < 0 once the middle passes 1/4
    other = body.triangles[1, 0]
    moved[:, middle] = 0.55 * (body.nodes[:, corner] - body.nodes[:, other]) * 0.5
    state = result.last.updated(displacement=moved)
    assert least_determinant(body, state) < 0
    assert least_determinant(body, result.last) > 0
    assert faults(changed(result, displacement=moved))[0].startswith("det F*")


def test_a_boundary_that_crosses_itself_is_found(result):
    body = result.scene.body
    assert not crosses(body, body.nodes)
    places = body.nodes.copy()
    apex = body.pial[len(body.pial) // 2]
    places[1, apex] = -0.1  # through the base
    assert crosses(body, places)


def test_what_is_not_finite_is_found(result):
    moved = result.last["displacement"].copy()
    moved[0, 5] = np.nan
    assert faults(changed(result, displacement=moved))[0].startswith("not finite")


@pytest.fixture(scope="module")
def pattern():
    """Return a body and a steady pattern of six half waves on it."""
    body = semicircle(radius=1.0, thickness=0.25, elements=1.5, base="roller")
    return body, Turing(Schnakenberg(), half_waves=6).pattern(body)


def with_state(pattern, state):
    return replace(pattern, steady=replace(pattern.steady, state=state))


def test_patterns_that_are_no_steady_state_or_of_other_waves_are_found(pattern):
    body, found = pattern
    assert patterns.faults(body, found, 6) == []
    assert "6 half waves" in patterns.faults(body, found, 7)
    shifted = with_state(found, 1.0001 * found.steady.state)
    assert any(fault.startswith("residual") for fault in patterns.faults(body, shifted, 6))


def test_a_uniform_state_that_is_unstable_is_found(pattern):
    body, found = pattern
    level = np.array(found.design.conditions.steady_state)[:, None]
    flat = with_state(found, np.broadcast_to(level, found.steady.state.shape).copy())
    assert any("grows" in fault for fault in patterns.faults(body, flat, None))


def test_cells_are_drawn_the_same_again():
    assert drawn("mechanics", 7, 1) == drawn("mechanics", 7, 1)
    assert drawn("mechanics", 7, 1) != drawn("mechanics", 7, 2) != drawn("mechanics", 8, 2)
    assert scene(drawn("mechanics", 1, 0), 5.0).stepping.seconds == 5.0


def test_a_cell_without_time_stops_with_its_reason():
    row = judged("mechanics", 1, 0, 1e-3)
    assert row["outcome"] == "stopped"
    assert "time limit" in row["reason"]


@pytest.mark.slow
def test_the_command_goes_on_with_its_tables(tmp_path, capsys):
    words = ["atlas", "--out", str(tmp_path), "--mechanics", "2", "--patterns", "2", "--marches", "1"]
    assert main([*words, "--seconds", "60", "-j", "2"]) == 0
    assert "mechanics: 2 cells: 2 valid" in capsys.readouterr().out
    assert (tmp_path / "atlas.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader((tmp_path / "mechanics.csv").read_text().splitlines()))
    assert [row["outcome"] for row in rows] == ["valid", "valid"]
    before = (tmp_path / "mechanics.csv").read_bytes()
    assert main([*words, "--seconds", "60"]) == 0
    assert (tmp_path / "mechanics.csv").read_bytes() == before
