"""Numbers of a state against what is known of it: similar growth, and areas by another formula."""

import numpy as np
import pytest
from small import elastic_scene

from turingfold import Body, TangentialGrowth, half, outline, semicircle, simulate
from turingfold.results.measures import area_numbers, fold_numbers, shape_numbers
from turingfold.results.units import parameter_unit
from turingfold.state import State


def test_areas_of_a_similar_body_grow_by_the_square():
    body = semicircle(radius=0.04, thickness=0.008, size=0.008)
    moved = 0.3 * body.nodes + np.array([[0.01], [0.02]])
    for part in (body, half(body)):
        numbers = area_numbers(part, State(1.0, {"displacement": 0.3 * part.nodes}))
        assert numbers == pytest.approx(dict.fromkeys(numbers, 1.69), rel=1e-13)
    assert area_numbers(body, State(1.0, {"displacement": moved}))["area_growth"] == pytest.approx(1.69)


def loop_area(points):
    """Return the area inside quadratic edges vertex, mid, vertex, ..., by Simpson's rule on x dy - y dx.

    That is exact for cubics, and x dy of a quadratic edge is one.
    """
    a, m, b = points[:, 0::2], points[:, 1::2], np.roll(points[:, 0::2], -1, axis=1)

    def at(x, slope):
        return x[0] * slope[1] - x[1] * slope[0]

    ends = at(a, -3 * a + 4 * m - b) + at(b, a - 4 * m + 3 * b)
    return 0.5 * float(np.sum(ends + 4 * at(m, b - a))) / 6


def test_area_growth_of_a_folded_body_is_that_inside_its_curved_outline(folded):
    body = folded.scene.body
    (pial, _), (base, _) = body.boundary_path("pial"), body.boundary_path("base")
    assert pial[-1] == base[0]
    loop = np.concatenate([pial, base[1:-1]])
    before, after = (loop_area((body.nodes + u)[:, loop]) for u in (0.0, folded.last["displacement"]))
    summary = folded.summary()
    assert before == pytest.approx(np.pi / 2 * 0.04**2, rel=1e-3)
    assert summary["area_growth"] == pytest.approx(after / before, rel=1e-12)
    inner = body.interface
    # the core's outline: interface, and the base between its ends
    ends = [int(np.flatnonzero(base == end)[0]) for end in (inner[0], inner[-1])]
    core = np.concatenate([inner, base[min(ends) + 1 : max(ends)]])
    before, after = (loop_area((body.nodes + u)[:, core]) for u in (0.0, folded.last["displacement"]))
    assert summary["core_growth"] == pytest.approx(after / before, rel=1e-12)
    # what is not core is cortex
    total, share = loop_area(body.nodes[:, loop]), loop_area(body.nodes[:, core])
    cortex = (summary["area_growth"] * total - summary["core_growth"] * share) / (total - share)
    assert summary["cortex_growth"] == pytest.approx(cortex, rel=1e-12)


def test_folds_are_told_with_what_counts_and_the_registration_with_what_chance_gives():
    body = semicircle(radius=1.0, thickness=0.1, size=0.1)
    angle, radius = np.arctan2(body.nodes[1], body.nodes[0]), np.hypot(*body.nodes)
    pattern, outwards = np.cos(16 * angle), body.nodes / np.maximum(radius, 1e-9)
    # crests of 0.05 on the pattern's peaks, or a quarter of a wave beside them
    for shift, p in ((0.0, 0.002), (np.pi / 2, 0.5)):
        push = 0.05 * radius * np.cos(16 * angle + shift)
        fields = {"displacement": push * outwards, "pattern": pattern[body.cortex.nodes]}
        numbers = fold_numbers(body, State(1.0, fields))
        assert numbers["folds"] == 8
        assert (numbers["least_fold_depth"], numbers["fold_smoothing"]) == pytest.approx((0.02, 0.025))
        assert numbers["closing_radius"] == pytest.approx(0.3)
        assert numbers["registration"] == pytest.approx(np.cos(shift), abs=0.02)
        assert numbers["registration_p"] == pytest.approx(p, abs=0.02)
        # the disc enters the sulci a little way, the hull bridges them
        assert 1.0 < numbers["closed_gyrification_index"] < numbers["gyrification_index"]
    ripples = {"displacement": 0.009 * pattern * body.nodes, "pattern": pattern[body.cortex.nodes]}
    numbers = fold_numbers(body, State(1.0, ripples))
    assert numbers["folds"] == numbers["sulcal_depth"] == 0
    assert f"{numbers['gyrification_index']:.2f}" == "1.00"


def test_the_centre_is_inside_half_the_radius():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    move = np.where(np.hypot(*body.nodes) < 0.7, 0.1 * body.nodes, 0.0)
    numbers = area_numbers(body, State(1.0, {"displacement": move}))
    assert numbers["centre_growth"] == pytest.approx(1.21, rel=1e-12)
    assert numbers["area_growth"] == pytest.approx(1.0, rel=1e-12)  # the outline is where it was


@pytest.mark.parametrize("size", [0.3, 0.15])
def test_the_edge_of_the_centre_crosses_elements(size):
    # r → r + r²/2: what was inside 1/2 is inside 5/8, which grows by 25/16, while the area beside it grows by
    # (1 + r)(1 + r/2) = 1.875 there
    body = semicircle(radius=1.0, thickness=0.2, size=size)
    displacement = 0.5 * np.hypot(*body.nodes) * body.nodes
    numbers = area_numbers(body, State(1.0, {"displacement": displacement}))
    assert numbers["centre_growth"] == pytest.approx(25 / 16, rel=2e-3)


def test_a_free_body_that_grows_evenly_in_all_directions_grows_by_the_square():
    body = semicircle(radius=1.0, thickness=0.25, size=0.25)
    free = Body(body.mesh, body.thickness, "free")
    grow = TangentialGrowth(cortex=1.2, core=1.2, radial_core=1.2, radial_cortex=1.2)
    numbers = simulate(elastic_scene(grow, body=free)).summary()
    for name in ("area_growth", "core_growth", "centre_growth"):
        assert numbers[name] == pytest.approx(1.44, rel=1e-6)


def test_a_reaction_rate_has_no_unit_though_it_is_called_as_a_modulus():
    assert parameter_unit("Elastic.gray.kappa") == "Pa"
    assert parameter_unit("Turing.kinetics.kappa") == ""


def test_islands_smaller_than_their_cortex_hold_no_folds():
    """As the plane leaves of the tips of gyri: a whole section used to end without a summary."""
    angle = 2 * np.pi * np.arange(120) / 120
    circle = np.stack([np.cos(angle), np.sin(angle)])
    waves = (1 + 0.1 * np.cos(6 * angle)) * circle
    island = 0.045 * circle + np.array([[1.3], [0.0]])
    alone, both = (outline(loops, thickness=0.1, size=0.05) for loops in ([waves], [waves, island]))
    assert len(both.pial_paths) == 2
    numbers = [fold_numbers(body, State(0.0, {"displacement": 0 * body.nodes})) for body in (alone, both)]
    assert numbers[0]["folds"] == numbers[1]["folds"] == 6
    assert numbers[1]["sulcal_depth"] == pytest.approx(numbers[0]["sulcal_depth"], rel=1e-3)
    assert shape_numbers(both, 0 * both.nodes)["sulcal_depth"] == numbers[1]["sulcal_depth"]
