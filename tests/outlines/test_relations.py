"""What is said of curves that do not lie to each other as an outline's should."""

import numpy as np
import pytest

from turingfold.geometry.changes import OutlineWarning
from turingfold.outlines import outline

AT = 2 * np.pi * np.arange(160) / 160
PIAL = np.stack([0.03 * np.cos(AT), 0.022 * np.sin(AT)])  # m
AREA = np.pi * 0.03 * 0.022
CORTEX = {"thickness": 2.5e-3, "elements": 2}


def shifted(share, x=0.0, y=0.0):
    return share * PIAL + np.array([[x], [y]])


def tissue(body):
    return body.quadrature.weights.sum()


@pytest.mark.parametrize(
    ("white", "message"),
    [
        (1.2 * PIAL, r"interface: 0\.69 of the area .* inside the pial surface.*at least 0\.9.*same unit"),
        (PIAL, r"interface encloses 1 of the area .* no cortex"),
        (1.02 * PIAL, r"interface encloses 1 of the area .* no cortex"),
        (900 * PIAL, r"interface: 1\.2e-06 of the area .*same unit"),
        (shifted(0.9, x=0.2), r"interface: 0 of the area"),
    ],
)
@pytest.mark.filterwarnings("ignore:interface is .* large")
def test_an_interface_that_is_not_inside_is_refused_by_name(white, message):
    with pytest.raises(ValueError, match=message):
        outline(PIAL, interface=white, elements=2)


def test_a_thickness_that_the_interface_contradicts_is_told():
    depth = 0.1 * 0.026  # between those at the ends of the axes, 3 mm and 2.2 mm
    outline(PIAL, interface=0.9 * PIAL, thickness=depth, elements=2)
    with pytest.warns(OutlineWarning, match=r"thickness=0\.005 m does not move the interface"):
        body = outline(PIAL, interface=0.9 * PIAL, thickness=5e-3, elements=4)
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(0.19 * AREA, rel=1e-3)


@pytest.mark.parametrize(
    ("holes", "message"),
    [
        ([shifted(0.2), shifted(0.2, x=0.2)], r"holes\[1\]: 0 of its area"),
        (1.5 * PIAL, r"holes\[0\]: 0\.44 of its area.*same unit"),  # 1 / 1.5²
    ],
)
def test_a_hole_that_is_not_mostly_inside_is_refused_by_name(holes, message):
    with pytest.raises(ValueError, match=message):
        outline(PIAL, holes=holes, **CORTEX)


@pytest.mark.parametrize(
    ("holes", "message"),
    [
        (shifted(0.2, x=0.028), r"m² of holes outside the pial surface cut off; 1 holes made smaller"),
        (shifted(0.1, x=0.0265), r"1 holes made smaller, from 2\.07e-05 to .*as elements and the cortex"),
        ([shifted(0.2), shifted(0.025, x=-0.015)], r"1 holes too small or thin .* left out, 1\.3e-06 m²"),
        ([shifted(0.2), PIAL * [[0.2], [0.005]] - [[0], [0.01]]], r"1 holes too small or thin .* left out"),
        ([shifted(0.2), shifted(0.025)], r"1\.3e-06 m² of islands in holes too small"),
    ],
)
def test_what_becomes_of_holes_is_told(holes, message):
    with pytest.warns(OutlineWarning, match=message):
        body = outline(PIAL, holes=holes, **CORTEX)
    assert any("hole" in note for note in body.changes.remarks())


def test_holes_that_overlap_are_one():
    """Two equal ellipses a, b, d apart along a, share a b (2 v - sin 2 v), cos v = d/2a."""
    angle = 2 * np.arccos(0.005 / (2 * 0.2 * 0.03))
    common = 0.04 * 0.03 * 0.022 * (angle - np.sin(angle))
    body = outline(PIAL, holes=[0.2 * PIAL, shifted(0.2, x=0.005)], **CORTEX)
    assert tissue(body) == pytest.approx(AREA * (1 - 0.08) + common, rel=2e-3)
    assert body.changes.notes == ("holes 0 and 1 overlap, and are one",)
    twice = outline(PIAL, holes=[0.2 * PIAL, 0.2 * PIAL], **CORTEX)
    assert tissue(twice) == pytest.approx(AREA * (1 - 0.04), rel=1e-3)


def test_a_curve_well_inside_a_hole_is_an_island_in_it():
    body = outline(PIAL, holes=[0.2 * PIAL, 0.4 * PIAL], **CORTEX)
    assert tissue(body) == pytest.approx(AREA * (1 - 0.16 + 0.04), rel=3e-3)
    assert not body.changes.remarks()


def test_what_two_curves_that_cross_both_enclose_is_told():
    with pytest.warns(
        OutlineWarning, match=r"curves 0 and 1 of the pial surface cross each other; .*outside"
    ):
        outline([PIAL, shifted(1.0, x=0.03)], **CORTEX)
    with pytest.raises(ValueError, match=r"points\[0\] and points\[1\] are the same curve"):
        outline([PIAL, PIAL], **CORTEX)


@pytest.mark.parametrize("name", ["points", "interface", "holes"])
def test_points_that_are_not_in_order_are_refused(name):
    curves = {"points": PIAL, "interface": 0.9 * PIAL, "holes": 0.2 * PIAL}
    curves[name] = np.random.default_rng(0).permutation(curves[name], axis=1)
    with pytest.raises(ValueError, match=f"{name} crosses itself .* the points are not in order"):
        outline(**curves, elements=2)


def test_points_sorted_by_one_coordinate_are_not_in_order():
    by_place = np.random.default_rng(1).permutation(PIAL, axis=1)
    by_place = by_place[:, np.argsort(by_place[0].round(6), kind="stable")]
    with pytest.raises(ValueError, match=r"points crosses itself .* the points are not in order"):
        outline(by_place, **CORTEX)
