"""What is said of curves that do not lie to each other as an outline's should."""

import numpy as np
import pytest
import shapely

from turingfold.geometry.changes import OutlineWarning
from turingfold.outlines import outline
from turingfold.outlines.fill import angles
from turingfold.outlines.relations import overlapping, united

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
        (1.2 * PIAL, r"interface: 0\.69 of its area, .* inside the pial surface.*at least 0\.9.*same unit"),
        (PIAL, r"interface encloses 1 of the area .* no cortex"),
        (1.02 * PIAL, r"interface encloses 1 of the area .* no cortex"),
        (900 * PIAL, r"interface: 1\.2e-06 of its area, .*same unit"),
        (shifted(0.9, x=0.2), r"interface: 0 of its area"),
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
        ([shifted(0.2), shifted(0.025)], r"1\.3e-06 m² of tissue in or between holes too thin"),
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
    assert body.changes.notes == ("holes 0 and 1 overlap or touch, and are one",)
    twice = outline(PIAL, holes=[0.2 * PIAL, 0.2 * PIAL], **CORTEX)
    assert tissue(twice) == pytest.approx(AREA * (1 - 0.04), rel=1e-3)


def box(left, right, low, high):
    return np.array([[left, right, right, left], [low, low, high, high]])


def test_an_island_that_partly_overlaps_a_hole_is_one_with_it():
    """10 by 10, less 4 by 4 and the 1 by 2 that the third has beyond it: 100 - 16 - 2."""
    holes = [box(-5, 5, -5, 5), box(-2, 2, -2, 2), box(0, 3, -1, 1)]
    for order in ((0, 1, 2), (2, 1, 0), (1, 0, 2)):
        assert united([holes[k] for k in order]).area == pytest.approx(82)
    assert overlapping(holes) == ["holes 1 and 2 overlap or touch, and are one"]
    across = [*holes[:2], box(0, 7, -1, 1)]  # through the wall of the first: all are one
    assert united(across).area == pytest.approx(104)
    assert overlapping(across) == ["holes 0 and 2, 1 and 2 overlap or touch, and are one"]
    assert united([box(0, 1, 0, 1), box(2, 3, 0, 1)]).area == pytest.approx(2)


def walls(body):
    return [shapely.Polygon(body.nodes[:, path.nodes].T) for path in body.boundary_paths("hole")]


@pytest.mark.parametrize("elements", [2, 3, 4])
def test_holes_that_touch_along_a_line_are_one(elements):
    """Halves of an ellipse, that have its long axis in common."""
    half = np.concatenate([0.3 * PIAL[:, :81], [np.linspace(-9e-3, 9e-3, 60)[1:-1], np.zeros(58)]], axis=1)
    body = outline(PIAL, holes=[half, half * [[1], [-1]]], thickness=2.5e-3, elements=elements)
    assert body.changes.notes == ("holes 0 and 1 overlap or touch, and are one",)
    assert len(walls(body)) == 1
    assert tissue(body) == pytest.approx(AREA * (1 - 0.09), rel=1e-3)
    assert angles(body.mesh.p, body.mesh.t).min() > 20


def eight(start):
    at = 2 * np.pi * (np.arange(200) + start) / 200
    return np.stack([8e-3 * np.sin(at), 4e-3 * np.sin(2 * at)])


@pytest.mark.parametrize("elements", [2, 3, 4])
@pytest.mark.parametrize(
    ("holes", "area", "told"),
    [
        ([shifted(0.2, x=-6e-3), shifted(0.2, x=6e-3)], 2 * 0.04 * AREA, "joined to 1|made smaller"),
        # the two lobes: 2 ∫ x dy over half a turn = 2 · 8 · 4 · 4/3 mm²
        (eight(0.3), 2 * 8e-3 * 4e-3 * 4 / 3, "hole 0 crosses or touches itself"),
        (eight(0.0), 2 * 8e-3 * 4e-3 * 4 / 3, "hole 0 crosses or touches itself"),
    ],
)
def test_holes_that_touch_at_a_point_are_joined_or_moved_apart_with_a_word(holes, area, told, elements):
    with pytest.warns(OutlineWarning, match=told):
        body = outline(PIAL, holes=holes, thickness=2.5e-3, elements=elements)
    assert tissue(body) == pytest.approx(AREA - area, rel=2e-3)
    assert angles(body.mesh.p, body.mesh.t).min() > 20
    first, *others = walls(body)
    assert all(first.distance(other) > 0.2 * 2.5e-3 / elements for other in others)
    assert min(shapely.minimum_clearance(wall) for wall in (first, *others)) > 0.1 * 2.5e-3 / elements


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


def test_a_piece_without_a_white_surface_is_told():
    left, right = (shifted(0.8, x) for x in (-0.03, 0.03))
    with pytest.warns(OutlineWarning, match="50% of the area is in pieces without a white surface"):
        outline([left, right], interface=[shifted(0.65, -0.03)], size=1.5e-3)


def test_a_ventricle_half_of_which_lies_beyond_the_midline_is_taken():
    t = np.linspace(-np.pi / 2, np.pi / 2, 80)
    line = np.linspace(0.03, -0.03, 40)[1:-1]
    half = np.hstack([[0.03 * np.cos(t), 0.03 * np.sin(t)], [np.zeros(38), line]])
    ends = ((0.0, 0.03), (0.0, -0.03))
    with pytest.warns(OutlineWarning, match="smaller"):
        body = outline(half, thickness=3e-3, size=1.5e-3, base="roller", base_ends=ends, holes=[shifted(0.2)])
    assert body.boundary_paths("hole")


@pytest.mark.parametrize("gap", [0.0, 3e-5, -1e-3])
@pytest.mark.parametrize("size", [0.7e-3, 1.5e-3])
def test_a_white_surface_that_ends_on_the_base_does_so_in_the_mesh(gap, size):
    """Half ellipses cut at the midline, the white one at a distance that is round-off of a drawing."""
    pial, white = (
        shapely.Polygon(curve.T) & shapely.box(at, -1.0, 1.0, 1.0)
        for curve, at in ((PIAL, 0.0), (0.9 * PIAL, gap))
    )
    points, interface = (np.array(one.exterior.coords)[:-1].T for one in (pial, white))
    ends = ((0.0, 0.022), (0.0, -0.022))
    body = outline(points, interface=[interface], size=size, base="roller", base_ends=ends)
    assert body.changes.smallest_angle > 20
    assert len(body.interface_paths) == 1
    cortex = body.quadrature.weights[:, body.in_cortex].sum()
    assert cortex == pytest.approx(0.5 * AREA * (1 - 0.9**2), rel=2e-3)
    assert np.ptp(body.nodes[0, body.boundary_paths("base")[0].nodes]) == 0.0
