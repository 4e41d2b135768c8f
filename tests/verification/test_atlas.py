"""The atlas: its judge finds what is wrong, its cells are the same again, and its tables are gone on with."""

import csv
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from small import elastic_scene

from turingfold import (
    Drag,
    Elastic,
    Imperfection,
    Inertia,
    NeoHookean,
    Schnakenberg,
    SelfContact,
    Stepping,
    TangentialGrowth,
    Turing,
    outline,
    semicircle,
    simulate,
)
from turingfold.cli.main import main
from turingfold.verification.atlas import families, patterns
from turingfold.verification.atlas.cells import drawn, scene
from turingfold.verification.atlas.judge import crosses, faults, least_determinant, residual
from turingfold.verification.atlas.known import has_solution, reached, told
from turingfold.verification.atlas.run import FORBIDDEN, _serve, judged


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


def test_walls_that_cross_another_wall_are_found():
    angle = 2 * np.pi * np.arange(60) / 60
    circle = np.stack([np.cos(angle), np.sin(angle)])
    ring = outline(circle, thickness=0.2, size=0.2, holes=(0.4 * circle,))
    assert not crosses(ring, ring.nodes)
    places = ring.nodes.copy()
    places[0, np.hypot(*places) < 0.45] += 0.65  # the hole's wall, whole, through the pial surface
    assert crosses(ring, places)


@pytest.fixture(scope="module")
def moving():
    """Return a result of the midpoint rule, with noise of the moduli and growth."""
    made = elastic_scene(TangentialGrowth(cortex=1.3), Imperfection(of="moduli", amplitude=0.1))
    stepping = Stepping(first=0.1, largest=0.2, scheme="midpoint")
    return simulate(replace(made, terms=(*made.terms, Inertia(density=1e-3)), stepping=stepping))


def test_forces_in_the_middle_of_a_step_are_judged_there(moving):
    assert residual(moving) < 1e-7
    assert residual(changed(moving, growth=1.0001 * moving.last["growth"])) > 1e-5
    factor = moving.last["modulus_factor"] * (1 + 1e-4 * (moving.scene.body.in_cortex))
    assert residual(changed(moving, modulus_factor=factor)) > 1e-5


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
    assert scene("mechanics", drawn("mechanics", 1, 0), 5.0).stepping.seconds == 5.0


def test_a_scene_of_a_family_is_of_its_kind():
    at_rest, in_motion, far = (drawn(family, 3, 0) for family in ("ordinary", "dynamic", "extreme"))
    assert at_rest["moving"] == "none"
    assert in_motion["moving"] != "none"
    assert {drawn("stepping", number, 0)["allowed"] for number in range(12)} > {1, 300}
    assert far["unit"] in (1e-9, 1e-3, 1.0, 1e3)
    assert scene("dynamic", in_motion, 5.0).stepping.seconds == 5.0


AT_REST = {
    "element": "quadratic",
    "poisson": 0.3,
    "law": "none",
    "moving": "none",
    "scheme": "euler",
    "off": 0.0,
}


def test_a_minimum_of_the_energy_is_known_where_there_is_one_and_nowhere_else():
    assert has_solution("ordinary", AT_REST)
    assert has_solution("dynamic", AT_REST | {"moving": "inertia"})
    assert has_solution("mechanics", {"element": "auto", "poisson": "0.48"})  # as read from a table
    for other in (
        {"element": "mixed"}, {"element": "auto", "poisson": 0.49}, {"law": "stress"}, {"moving": "damped"},
        {"scheme": "midpoint"}, {"off": "0.1"},
    ):  # fmt: skip
        assert not has_solution("ordinary", AT_REST | other), other
    assert not has_solution("pattern", drawn("pattern", 0, 0))


def test_the_share_of_known_solutions_counts_neither_refused_cells_nor_those_that_were_told_invalid():
    outcomes = ["valid", "valid", "valid", "stopped", "told invalid", "refused"]
    rows = [AT_REST | {"outcome": outcome} for outcome in outcomes]
    rows += [AT_REST | {"outcome": "stopped", "law": "stress"}]
    assert reached("ordinary", rows) == (3, 5)
    assert told((3, 5)) == "3 of 5 with a known solution reach it (60 %)"
    assert told((0, 0)) == ""


@pytest.mark.parametrize("ratio", [0.01, 1.0, 100.0])
def test_the_energy_of_the_argument_grows_as_it_says(ratio):
    b = np.geomspace(1e-6, 1e6, 200001)  # J*^(2/3)
    a = 1e4 * ratio
    assert (a / b + b**3).min() >= 1.75 * a**0.75
    assert (a / b + b**3).min() < 1.76 * a**0.75


FAST = {"ordinary": (6, 8), "dynamic": (36, 37), "stepping": (5,), "extreme": (0, 4)}


@pytest.mark.parametrize(("family", "number"), [(own, k) for own, seeds in FAST.items() for k in seeds])
def test_scenes_of_a_family_end_well(family, number):
    check(judged(family, number, 0, 60.0), family)


@pytest.mark.slow
@pytest.mark.parametrize("number", [1000, 1001])
@pytest.mark.parametrize("family", families.FAMILIES)
def test_more_scenes_of_a_family_end_well(family, number):
    check(judged(family, number, 0, 120.0), family)


def check(row, family):
    """Hold an outcome to what is allowed, and ordinary and dynamic scenes to their end."""
    assert row["outcome"] not in FORBIDDEN, row["reason"]
    if family in ("ordinary", "dynamic"):
        assert row["outcome"] == "valid", row["reason"]


def test_a_cell_without_time_stops_with_its_reason():
    row = judged("mechanics", 1, 0, 1e-3)
    assert row["outcome"] == "stopped"
    assert "time limit" in row["reason"]


def test_a_worker_ends_quietly_when_who_asked_is_gone():
    ours, theirs = get_context("spawn").Pipe()
    worker = get_context("spawn").Process(target=_serve, args=(theirs,))
    worker.start()
    theirs.close()
    ours.send(("mechanics", 1, 0, 1e-3))  # its answer finds nobody
    ours.close()
    worker.join(60)
    assert worker.exitcode == 0


@pytest.mark.slow
def test_the_command_goes_on_with_its_tables(tmp_path, capsys):
    words = ["atlas", "--out", str(tmp_path), "--mechanics", "2", "--patterns", "2", "--marches", "1"]
    words += ["--ordinary", "1", "--dynamic", "1", "--stepping", "1", "--extreme", "1"]
    assert main([*words, "--seconds", "60", "-j", "2"]) == 0
    assert (
        "extreme: 1 cells: 1 valid; 1 of 1 with a known solution reach it (100 %)" in capsys.readouterr().out
    )
    assert (tmp_path / "atlas.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader((tmp_path / "mechanics.csv").read_text().splitlines()))
    assert [row["outcome"] for row in rows] == ["valid", "valid"]
    before = (tmp_path / "mechanics.csv").read_bytes()
    assert main([*words, "--seconds", "60"]) == 0
    assert (tmp_path / "mechanics.csv").read_bytes() == before
