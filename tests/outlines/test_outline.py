"""Bodies from curves: exact shapes, what is repaired and how that is told, what is refused."""

import re
import warnings
from time import perf_counter

import numpy as np
import pytest
import shapely
from planar import area
from scipy.interpolate import CubicSpline

from turingfold import memory
from turingfold.geometry.changes import OutlineWarning
from turingfold.outlines import RefinementDisc, outline
from turingfold.outlines.fill import angles
from turingfold.outlines.line import line
from turingfold.outlines.loops import closed_loops


def circle(count=240, radius=1.0):
    at = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(at), np.sin(at)])


def half_circle(count=120):
    at = np.pi * np.arange(count + 1) / count
    arc = np.stack([np.cos(at), np.sin(at)])
    arc[1, [0, -1]] = 0.0
    return np.concatenate([arc, np.zeros((2, 1))], axis=1)


def flower(depth=0.25, petals=5, count=400):
    at = 2 * np.pi * np.arange(count) / count
    return (1 + depth * np.cos(petals * at)) * np.stack([np.cos(at), np.sin(at)])


@pytest.fixture(scope="module")
def disc():
    return outline(circle(), thickness=0.1, size=0.05)


@pytest.fixture(scope="module")
def petals():
    return outline(flower(), thickness=0.1, size=0.05)


def test_a_disc_has_the_areas_and_lengths_of_a_disc(disc):
    weights = disc.quadrature.weights
    assert weights.sum() == pytest.approx(np.pi, rel=1e-6)
    assert weights[:, disc.in_cortex].sum() == pytest.approx(np.pi * (1 - 0.9**2), rel=1e-4)
    assert disc.pial_curve.length == pytest.approx(2 * np.pi, rel=1e-6)
    assert disc.pial_curve.closed
    assert np.hypot(*disc.nodes[:, disc.interface]) == pytest.approx(0.9, abs=1e-5)


def test_the_area_of_the_curved_mesh_converges_with_order_four():
    sizes = (0.16, 0.08)
    points = flower(depth=0.1, petals=3)
    exact = np.pi * (1 + 0.5 * 0.1**2)  # ½∫r² of r = 1 + 0.1 cos 3φ
    errors = [abs(outline(points, thickness=0.1, size=h).quadrature.weights.sum() - exact) for h in sizes]
    assert np.log2(errors[0] / errors[1]) > 3.5


@pytest.mark.filterwarnings("ignore:points is .* large, read as metres")
@pytest.mark.parametrize("unit", [1e3, 1e-3, 0.3048])
def test_the_mesh_is_the_same_in_any_unit(petals, unit):
    scaled = outline(unit * flower(), thickness=0.1 * unit, size=0.05 * unit)
    assert np.array_equal(scaled.mesh.t, petals.mesh.t)
    assert scaled.nodes / unit == pytest.approx(petals.nodes, abs=1e-12)


@pytest.mark.parametrize("offset", [17.3, 1e4])
def test_a_shifted_body_has_the_same_mesh(petals, offset):
    shifted = outline(flower() + offset, thickness=0.1, size=0.05)
    assert np.array_equal(shifted.mesh.t, petals.mesh.t)
    lost = 1e3 * np.finfo(float).eps * offset  # coordinates have so few digits left, curvatures fewer still
    assert shifted.nodes - offset == pytest.approx(petals.nodes, abs=lost)


@pytest.mark.parametrize("points", [circle(), flower()])
def test_a_body_is_meshed_a_million_lengths_from_the_origin(points):
    """Its points are known to 1e-10 only, so that triangles that are equally good may be swapped."""
    near, far = (outline(points + offset, thickness=0.1, size=0.05) for offset in (0.0, 1e6))
    assert far.mesh.nelements == near.mesh.nelements
    assert far.quadrature.weights.sum() == pytest.approx(near.quadrature.weights.sum(), rel=1e-8)


def test_ends_of_the_base_lie_on_the_outline():
    points, options = half_circle(), {"thickness": 0.1, "size": 0.05, "base": "roller"}
    body = outline(points, base_ends=((-1.0, -0.03), (1.03, 0.0)), **options)
    assert body.nodes[1, body.boundary_path("base")[0]] == pytest.approx(0.0, abs=1e-12)
    for ends in (((-1, 0), (1, -50)), ((-1.06, 0), (1, 0)), ((-1000, 0), (1000, 0))):
        with pytest.raises(ValueError, match=r"base_ends: .* from the outline, more than size=0\.05 m"):
            outline(points, base_ends=ends, **options)


def test_depth_and_normal_of_a_disc_are_radial(disc):
    x, y = disc.quadrature.points
    radius = np.hypot(x, y)
    assert disc.depth == pytest.approx(1 - radius, abs=1e-5)
    away = radius > 0.2  # at the centre every direction is nearest
    tx, ty = disc.tangent
    assert (tx + y / radius)[away] == pytest.approx(0.0, abs=2e-3)
    assert (ty - x / radius)[away] == pytest.approx(0.0, abs=2e-3)


def test_depth_is_the_distance_to_the_nearest_pial_point_at_concavities(petals):
    at = np.linspace(0, 2 * np.pi, 20_001)
    fine = (1 + 0.25 * np.cos(5 * at)) * np.stack([np.cos(at), np.sin(at)])
    points = petals.quadrature.points.reshape(2, -1)[:, ::23]
    brute = np.array([np.hypot(*(fine - p[:, None])).min() for p in points.T])
    assert petals.depth.ravel()[::23] == pytest.approx(brute, abs=2e-4)


def test_the_interface_lies_one_thickness_below_the_surface(petals):
    distance, _, arc = petals.pial_curve.nearest(petals.nodes[:, petals.interface])
    assert distance == pytest.approx(0.1, rel=5e-3)
    assert np.sum(np.diff(arc) < 0) == 1  # once around


@pytest.mark.parametrize("size", [0.03, 0.05])
def test_triangles_are_well_shaped_and_of_the_asked_size(size):
    body = outline(flower(), thickness=0.1, size=size, grading=0.3)
    mesh = body.mesh
    smallest = angles(mesh.p, mesh.t)
    assert smallest.min() > 20
    assert np.percentile(smallest, 1) > 28
    gray = mesh.t[:, body.in_cortex]
    edges = np.hypot(*(mesh.p[:, gray] - mesh.p[:, np.roll(gray, 1, axis=0)]))
    assert edges.mean() == pytest.approx(size, rel=0.12)
    assert edges.max() < 1.8 * size


def test_direction_shape_and_repeated_points_do_not_matter(disc):
    points = circle()
    clockwise = points[:, ::-1].T  # (n, 2)
    repeated = np.repeat(points, 2, axis=1)
    closed = np.concatenate([points, points[:, :1]], axis=1)
    for variant in (clockwise, repeated, closed):
        body = outline(variant, thickness=0.1, size=0.05)
        assert body.quadrature.weights.sum() == pytest.approx(np.pi, rel=1e-6)
        assert body.pial_curve.length == pytest.approx(disc.pial_curve.length, rel=1e-9)
        forward = body.nodes[:, body.pial[[0, 2]]]
        assert forward[0, 0] * forward[1, 1] > forward[1, 0] * forward[0, 1]  # counter-clockwise


def test_a_part_of_the_outline_is_the_base():
    body = outline(half_circle(), thickness=0.1, size=0.05, base="roller", base_ends=((-1, 0), (1, 0)))
    base, closed = body.boundary_path("base")
    assert not closed
    assert body.nodes[1, base] == pytest.approx(0.0, abs=1e-15)
    assert set(2 * base + 1) < set(body.fixed)
    assert body.pial_curve.length == pytest.approx(np.pi, rel=1e-6)
    ends = body.nodes[:, body.interface[[0, -1]]]
    assert ends == pytest.approx(np.array([[0.9, -0.9], [0.0, 0.0]]), abs=1e-4)
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(0.5 * np.pi * 0.19, rel=1e-3)


def test_a_slanted_base_meets_the_interface_on_a_node():
    at = np.linspace(-0.25 * np.pi, 1.1 * np.pi, 200)
    points = np.stack([np.cos(at), np.sin(at)])
    points = np.concatenate([points, np.linspace(points[:, -1], points[:, 0], 12)[1:-1].T], axis=1)
    ends = points[:, 199], points[:, 0]
    body = outline(points, thickness=0.15, size=0.06, base="clamped", base_ends=ends)
    base = set(body.boundary_path("base")[0].tolist())
    assert set(body.interface[[0, -1]].tolist()) < base
    distance = body.pial_curve.nearest(body.nodes[:, body.interface])[0]
    assert distance == pytest.approx(0.15, rel=0.012)  # GEOS offsets to a hundredth


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": circle()[:, :7]}, "7 different points"),
        ({"points": circle()[:, :200]}, "open curve"),
        ({"points": circle()[0]}, "shape"),
        ({"points": circle() + 1j}, "points is complex"),
        ({"points": [["a", "b"]] * 9}, "must be an array of numbers"),
        ({"points": np.full((2, 20), 1.0)}, "1 different points"),
        ({"points": circle() * np.where(np.arange(240) == 7, np.nan, 1)}, "point 7 .*finite"),
        ({"size": 0.3}, "size=0.3 m must be at most twice"),
        ({"thickness": -0.1}, "thickness=-0.1"),
        ({"thickness": 1.2}, "hardly any white matter"),
        ({"thickness": 1e-4, "size": 5e-5}, "same unit"),
        ({"thickness": None}, "thickness is missing"),
        ({"thickness": np.ones(3)}, "thickness has 3 values"),
        ({"thickness": 0.1 - 0.2 * (np.arange(240) == 3)}, r"thickness is -0\.1 m at point 3"),
        ({"size": None}, "say either size"),
        ({"size": 1e-3, "fine": RefinementDisc((1.0, 0.0), 0.05, 0.01)}, "same unit"),
        ({"hole": "open"}, "hole='open'"),
        ({"hole": "clamped"}, "hole='clamped' .* there are none; give holes="),
        ({"holes": 3}, r"holes has shape \(\)"),
        ({"thickness": np.ones(239)}, "thickness has 239 values, and its curve 240 points"),
        ({"thickness": [np.ones(240)] * 2}, "thickness has 2 rows of values, and points has 1"),
        ({"thickness": []}, "thickness has 0 values"),
        (
            {"points": [circle(), 3 + circle(100)], "thickness": [np.ones(240), np.ones(99)]},
            r"thickness\[1\] has 99 values, and its curve 100 points",
        ),
        (
            {"points": [circle(), 3 + circle()], "thickness": np.ones(240)},
            "1 rows of values, and points has 2",
        ),
        ({"points": [circle(), 3 + circle()], "thickness": [0.1, 0.1]}, "1 rows of values, and points has 2"),
        ({"thickness": np.full(240, 0.1), "interface": 0.9 * circle()}, "beside interface it must be one"),
        ({"thickness": lambda at: 0.1 + at[0], "interface": 0.9 * circle()}, "beside interface it must be"),
        ({"inset": 0.0}, "inset=0"),
        ({"base": "roller"}, "needs base_ends"),
        ({"base": "clamped", "base_ends": ((1, 0), (1, 0))}, "same point"),
        ({"smooth": -1.0}, "smooth=-1"),
    ],
)
def test_bad_input_is_refused_by_name(change, message):
    with pytest.raises(ValueError, match=message):
        outline(**({"points": circle(), "thickness": 0.1, "size": 0.05} | change))


@pytest.mark.parametrize("options", [{}, {"grading": 0.1}, {"fine": RefinementDisc((1.0, 0.0), 0.3, 0.2)}])
@pytest.mark.parametrize("thickness", [0.1, 0.02])
def test_triangles_expected_are_those_made_and_too_many_refused(thickness, options, monkeypatch):
    given = {"points": circle(), "thickness": thickness, "size": 0.02, **options}
    made = outline(**given).mesh.nelements
    monkeypatch.setattr(memory, "memory_left", lambda: 1e6)
    before = perf_counter()
    with pytest.raises(ValueError, match=r"^size=0\.02 m .* triangles, .* GB are left") as told:
        outline(**given)
    assert perf_counter() - before < 1.0
    assert float(re.search("about (.*?) triangles", str(told.value))[1]) == pytest.approx(made, rel=0.4)


def test_without_holes_may_be_said_by_none_and_one_curve_by_a_list_of_one(disc):
    bodies = (outline([circle()], thickness=np.full(240, 0.1), size=0.05),)
    bodies += (outline(circle(), thickness=0.1, size=0.05, holes=None),)
    for body in bodies:
        assert body.boundary_paths("hole") == ()
        assert body.quadrature.weights.sum() == pytest.approx(disc.quadrature.weights.sum(), rel=1e-12)


def test_an_eight_becomes_its_two_loops_and_says_so():
    at = 2 * np.pi * (np.arange(400) + 0.3) / 400
    eight = np.stack([np.sin(2 * at), 2 * np.sin(at)])
    with pytest.warns(UserWarning, match="curve 0 of the pial surface crosses or touches itself"):
        body = outline(eight, thickness=0.1, size=0.05)
    assert len(body.pial_paths) == 2
    assert "crosses or touches itself" in str(body.changes)
    # even-odd area: both loops count
    lobe = shapely.make_valid(shapely.Polygon(eight.T)).area
    assert body.quadrature.weights.sum() == pytest.approx(lobe, rel=0.01)
    assert angles(body.mesh.p, body.mesh.t).min() > 20


def test_islands_and_closed_off_sulci_are_part_of_the_pial_surface():
    island = 0.4 * circle() + np.array([[2.0], [0.0]])
    with pytest.warns(UserWarning, match=r"1 of 3 closed curves lies inside another.*gyrification.*holes="):
        body = outline([circle(), island, 0.3 * circle()[:, ::-1]], thickness=0.1, size=0.05)
    lengths = 2 * np.pi * np.array([1.0, 0.4, 0.3])
    found = [body.pial_curves.parts[k].length for k in range(3)]
    assert found == pytest.approx(lengths, rel=1e-6)  # the longest first
    assert body.quadrature.weights.sum() == pytest.approx(np.pi * (1 + 0.16 - 0.09), rel=1e-6)
    cortex = np.pi * (1 - 0.9**2 + 0.4**2 - 0.3**2 + 0.4**2 - 0.3**2)
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(cortex, rel=1e-3)
    turns = [np.sign(area(body.nodes[:, path.nodes])) for path in body.pial_paths]
    assert turns == [1, 1, -1]  # tissue on the left
    x, y = body.quadrature.points
    exact = np.minimum(
        np.minimum(np.abs(1 - np.hypot(x, y)), np.abs(np.hypot(x, y) - 0.3)), 9 * (x > 1.3) + 1
    )
    exact = np.where(x > 1.3, 0.4 - np.hypot(x - 2, y), exact)
    assert body.depth == pytest.approx(exact, abs=1e-5)
    assert len(body.fixed) == 6


@pytest.mark.parametrize("hole", ["free", "clamped"])
def test_a_ventricle_is_no_pial_surface(hole):
    body = outline(circle(), thickness=0.1, size=0.05, holes=[0.3 * circle()], hole=hole)
    assert len(body.pial_paths) == 1
    (wall,) = body.boundary_paths("hole")
    assert np.hypot(*body.nodes[:, wall.nodes]) == pytest.approx(0.3, abs=1e-6)
    assert body.quadrature.weights.sum() == pytest.approx(np.pi * 0.91, rel=1e-5)
    x, y = body.quadrature.points
    assert body.depth == pytest.approx(1 - np.hypot(x, y), abs=1e-5)
    assert len(body.supported) == (2 * len(wall.nodes) if hole == "clamped" else 0)


@pytest.mark.parametrize("inner", [0.3, 0.2])
def test_a_ventricle_whose_wall_is_an_inner_ring_of_white_matter_is_no_cortex(inner):
    body = outline(circle(), interface=[0.8 * circle(), inner * circle()], holes=[0.3 * circle()], size=0.05)
    assert body.changes.cortex == pytest.approx(0.0, abs=1e-4)
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(np.pi * 0.36, rel=1e-4)


@pytest.mark.parametrize("radius", [0.06, 0.08, 0.1, 0.15, 0.3])
def test_a_round_hole_keeps_its_area_however_coarse_the_elements(radius):
    body = outline(circle(), thickness=0.1, size=0.05, holes=[radius * circle()])
    assert body.quadrature.weights.sum() == pytest.approx(
        np.pi * (1 - radius**2), abs=2e-3 * np.pi * radius**2
    )
    assert body.changes.holes == pytest.approx(0.0, abs=2e-3)
    assert not [remark for remark in body.changes.remarks() if "area of holes" in remark]


def test_the_area_that_holes_lose_is_told():
    slit = np.array([[0.4], [0.05]]) * circle()
    with pytest.warns(OutlineWarning, match=r"area of holes lost 6\.") as told:
        body = outline(circle(), thickness=0.2, size=0.1, holes=[slit])
    assert len(told) == 1
    lost = 1 - (np.pi - body.quadrature.weights.sum()) / (np.pi * 0.02)
    assert body.changes.holes == pytest.approx(lost, abs=5e-3)  # the circle is not quite a circle


@pytest.mark.parametrize(("width", "gone"), [(0.0, True), (1e-6, True), (1e-3, False)])
def test_a_fissure_whose_walls_touch_is_gone_and_that_is_told(width, gone):
    at = np.linspace(0.5 * np.pi + width / 2, 2.5 * np.pi - width / 2, 240)
    down = 1 - np.linspace(0.0, 0.6, 30)[1:]
    left, right = (np.stack([np.full(29, side * width / 2), y]) for side, y in ((-1, down[::-1]), (1, down)))
    points = np.concatenate([np.stack([np.cos(at), np.sin(at)]), right, left], axis=1)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        body = outline(points, thickness=0.1, size=0.05)
    remark = " ".join(body.changes.remarks())
    # each wall to one element above the bottom, and from where it is an element deep
    share = 2 * (0.6 - 0.05) / (2 * np.pi + 1.2)
    assert body.changes.closed == pytest.approx(share if gone else 0.0, abs=0.01)
    assert ("of the pial surface lies in fissures that are gone" in remark) == gone
    assert any("fissures that are gone" in str(one.message) for one in told) == gone


def test_a_given_interface_is_kept_and_depth_is_a_share_of_the_way():
    white = 0.8 * circle() + np.array([[0.05], [0.0]])
    body = outline(circle(), interface=[white], size=0.05)
    assert np.hypot(*(body.nodes[:, body.interface] - [[0.05], [0.0]])) == pytest.approx(0.8, abs=1e-6)
    assert body.changes.cortex == pytest.approx(0.0, abs=1e-4)
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(np.pi * 0.36, rel=1e-4)
    x, y = body.quadrature.points
    outer, inner = 1 - np.hypot(x, y), np.hypot(x - 0.05, y) - 0.8
    assert body.relative_depth == pytest.approx(outer / (outer + inner), abs=1e-4)


@pytest.mark.parametrize("form", ["points", "place"])
def test_a_varying_thickness_puts_the_interface_where_it_says(form):
    points = circle()
    thick = 0.15 + 0.05 * points[0]
    given = thick if form == "points" else lambda at: 0.15 + 0.05 * at[0] / np.hypot(*at)
    body = outline(points, thickness=given, size=0.04)
    assert body.thickness == pytest.approx(0.15, rel=1e-3)
    # the envelope of discs of radius T(s) around the circle: its distance from each of them is at least that
    white = body.nodes[:, body.interface[::2]]
    gaps = np.hypot(*(white[:, :, None] - points[:, None])) - thick
    assert gaps.min(1) == pytest.approx(0.0, abs=2e-3)
    assert body.relative_depth[:, body.in_cortex].max() < 1.02


def test_a_neck_thinner_than_two_cortices_parts_the_white_matter():
    at = 2 * np.pi * np.arange(300) / 300
    peanut = (0.6 + 0.5 * np.cos(2 * at)) * np.stack([np.cos(at), np.sin(at)])  # 0.2 wide at the neck
    body = outline(peanut, thickness=0.12, size=0.05)
    assert len(body.pial_paths) == 1
    assert len(body.interface_paths) == 2
    neck = np.abs(body.mesh.p[0, body.mesh.t]).max(0) < 0.05
    assert body.in_cortex[neck].all()


def test_walls_that_touch_are_moved_apart_and_the_rest_stays():
    deep = np.array([[-1.0, -1e-3, 0.0, 1e-3, 1.0, 1.0, -1.0], [1.0, 1.0, -0.5, 1.0, 1.0, -1.0, -1.0]])
    ring = shapely.segmentize(shapely.LinearRing(deep.T), 0.02)
    points = shapely.get_coordinates(ring).T[:, :-1]
    body = outline(points, thickness=0.2, size=0.06)
    x, y = body.nodes[:, body.pial]
    within = (np.abs(x) < 0.2) & (y < 0.85) & (y > -0.4)
    assert np.abs(x[within]).min() > 0.9 * 0.06 / 4  # half the gap
    assert np.abs(x[within]).max() < 1.3 * 0.06 / 4
    away = (np.abs(x) > 0.1) & (np.abs(np.abs(x) - 1) + np.abs(np.abs(y) - 1) > 0.05)
    on = np.minimum(np.abs(np.abs(x) - 1), np.abs(np.abs(y) - 1))
    assert on[away] == pytest.approx(0.0, abs=1e-3)
    assert body.changes.lost == pytest.approx(1.5 * 0.03 / 4, rel=0.25)
    # corners of the square are rounded; walls stand half a gap from where they touched, and the tip is blunt
    assert body.changes.moved < 0.1 * 0.06
    assert 0.06 / 4 <= body.changes.moved_at_walls < 1.5 * 0.06
    assert angles(body.mesh.p, body.mesh.t).min() > 20
    with pytest.warns(UserWarning, match="area lost"):
        outline(points, thickness=0.2, size=0.06, inset=0.1)


def test_parts_smaller_than_an_element_are_left_out_and_named():
    speck = 0.02 * circle() + np.array([[2.0], [1.0]])
    body = outline([circle(), speck], thickness=0.1, size=0.05)
    ((x, y, size),) = body.changes.dropped
    assert (x, y) == pytest.approx((2.0, 1.0), abs=1e-6)
    assert size == pytest.approx(np.pi * 0.02**2, rel=0.03)  # a polygon with 20 corners
    assert body.changes.moved < 1e-4


def test_closed_off_sulci_smaller_than_an_element_are_filled_and_counted():
    with pytest.warns(UserWarning, match="1 of 2 closed curves lies inside another"):
        body = outline([circle(), 0.02 * circle() + 0.3], thickness=0.1, size=0.05)
    assert len(body.pial_paths) == 1
    assert body.changes.filled == 1
    assert body.changes.moved < 1e-4
    assert "1 closed-off sulci filled" in str(body.changes)
    assert "1 closed-off sulci too small for the elements filled" in body.changes.remarks()


def test_of_a_smooth_outline_there_is_nothing_to_remark():
    assert outline([circle(), 0.5 * circle() + 3.0], thickness=0.1, size=0.05).changes.remarks() == ()


def test_a_surface_that_moves_farther_than_elements_explain_is_remarked():
    """A spike of no width goes: its tip is 0.5 away from the circle that is left."""
    points = np.insert(circle(), 1, [1.5, 0.0], axis=1)
    found = outline(points, thickness=0.1, size=0.05).changes
    assert found.moved == pytest.approx(0.5, abs=0.1)
    assert any("pial surface moved by up to" in remark for remark in found.remarks())


def test_what_makes_a_thin_cortex_one_element_thick_is_told_apart():
    """Where pial and white surface are the same, as on the medial wall of FreeSurfer's surfaces."""
    disc = shapely.Polygon(circle().T)
    white = disc & (disc.buffer(-0.2) | shapely.box(-0.3, -1.2, 0.3, 0))
    curve = shapely.get_coordinates(shapely.segmentize(white.exterior, 0.02)).T[:, :-1]
    body = outline(circle(), interface=[curve], size=0.05)
    layer = 0.05 * 2 * np.arcsin(0.3)
    assert body.changes.thickened == pytest.approx(layer / (np.pi - white.area), rel=0.05)
    assert body.changes.cortex == pytest.approx(body.changes.thickened, abs=0.01)


def test_a_curve_does_not_swing_out_where_long_segments_follow_short_ones():
    """A square with its corners cut off, by segments 30 times as short as its sides."""
    cut = 0.03
    corner = np.array([[1.0, 1.0 - cut], [1.0 - cut, 1.0]])
    points = np.concatenate(
        [np.array([[x, -y], [y, x]]) @ corner for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))], 1
    )
    body = outline(points, thickness=0.3, size=0.1)
    square = shapely.Polygon(points.T)
    away = shapely.distance(square.exterior, shapely.points(body.nodes[:, body.pial].T))
    assert away.max() < 0.1 / 8


def test_one_of_several_curves_may_have_few_points():
    """A pixel's diamond, as images of labels have them: of 4 points, with its own area."""
    diamond = np.array([[0.3, 0.0, -0.3, 0.0], [0.0, 0.3, 0.0, -0.3]])
    body = outline([circle(), diamond + 2.0], thickness=0.1, size=0.05)
    island = body.quadrature.weights[:, body.quadrature.points[0].mean(0) > 1.5].sum()
    assert 0.18 <= island <= 0.09 * np.pi  # of the diamond, and of the circle around it
    dot = np.array([[0.0, 0.01, 0.01], [0.0, 0.0, 0.01]]) + 2.0
    without = outline([circle(), dot], thickness=0.1, size=0.05, interface=[0.9 * circle(), dot])
    assert without.changes.notes == (
        "1 curves of points smaller than half an element left out, 5e-05 m²",
        "1 curves of interface smaller than half an element left out, 5e-05 m²",
    )
    with pytest.raises(ValueError, match=r"interface encloses nothing as large as an element"):
        outline(circle(), thickness=0.1, size=0.05, interface=[dot, dot])


def test_gray_matter_that_white_matter_surrounds_is_gray():
    """The bottom of a sulcus that the plane of the section just misses: a ring of white around it."""
    white = [0.9 * circle(), 0.3 * circle()]
    body = outline(circle(), interface=white, size=0.05)
    gray = body.quadrature.weights[:, body.in_cortex].sum()
    assert gray == pytest.approx(np.pi * (1 - 0.9**2 + 0.3**2), rel=1e-3)


def test_a_cut_above_hanging_lobes_is_meshed():
    x = [0, 12, 28, 40, 43, 41, 36, 28, 20, 16, 13, 9]
    y = [42, 44, 38, 24, 8, -8, -20, -25, -21, -12, -4, -2]
    right = CubicSpline(np.arange(12), np.stack([x, y], axis=1))(np.linspace(0, 11, 160))
    right = np.vstack([right, [[9, -8.2]]])
    points = np.vstack([right, right[::-1][:-1] * [-1, 1]]) * 1e-3
    ends = ((-9e-3, -8.2e-3), (9e-3, -8.2e-3))
    body = outline(points, thickness=2.5e-3, elements=3, smooth=1e-3, base="clamped", base_ends=ends)
    assert angles(body.mesh.p, body.mesh.t).min() > 20
    base = body.nodes[:, body.boundary_path("base")[0]]
    assert base[1] == pytest.approx(-8.2e-3, abs=1e-8)
    assert np.ptp(base[0]) == pytest.approx(18e-3, rel=1e-7)


def notched(rng):
    """Return a disc with a slanted notch, the ends of its ground, the cortex's thickness and a size."""
    width, deep, slope, thick, share = rng.uniform((0.15, 0.2, -0.2, 0.12, 1.5), (0.45, 0.6, 0.4, 0.25, 4))
    ends = np.array([[-width, deep - 1], [width, deep - 1]])
    opening = np.array([[width + slope, -1.2], [-width - slope, -1.2]])
    body = shapely.Polygon(circle().T) - shapely.Polygon(np.concatenate([ends, opening]))
    ring = shapely.segmentize(shapely.geometry.polygon.orient(body).exterior, 0.02)
    turned = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    return (shapely.get_coordinates(ring)[:-1] @ turn).T, ends @ turn, thick, thick / share


@pytest.mark.parametrize("seed", range(8))
def test_a_base_in_a_notch_is_meshed_with_any_thickness(seed):
    rng = np.random.default_rng(seed)
    points, ends, thick, size = notched(rng)
    uneven = thick * (1 + rng.uniform(0, 0.6) * np.cos(np.arctan2(points[1], points[0]) + seed))
    body = outline(points, thickness=uneven, size=size, base="clamped", base_ends=ends)
    (base,) = body.boundary_paths("base")
    assert np.hypot(*np.diff(body.nodes[:, base.nodes])).sum() == pytest.approx(
        np.hypot(*(ends[1] - ends[0]))
    )
    assert angles(body.mesh.p, body.mesh.t).min() > 20
    given = shapely.Polygon(points.T).area
    assert body.quadrature.weights.sum() == pytest.approx(given, rel=0.01)


@pytest.mark.parametrize("base", ["free", "roller"])
def test_a_cortex_that_leaves_hardly_any_inside_is_refused(base):
    points, ends = circle(), None  # the deepest point is the centre, at depth 1
    if base == "roller":
        points, ends = half_circle(), ((-1, 0), (1, 0))
        points[0, -1] = 0.5  # the only point within the base is not the deepest
    options = {"size": 0.1, "base": base, "base_ends": ends}
    assert outline(points, thickness=0.66, **options).thickness == 0.66
    with pytest.raises(ValueError, match=r"thickness=0\.67 m .* at most 0\.66[56]\d m.*\((1|0\.99\d*) m"):
        outline(points, thickness=0.67, **options)
    ellipse = circle() * np.array([[1.0], [0.4]])  # the largest circle inside has the radius 0.4
    with pytest.raises(ValueError, match=r"at most 0\.266\d m"):
        outline(ellipse, thickness=0.27, size=0.05)


def test_where_the_surface_is_tighter_than_the_cortex_the_interface_is_rounded():
    ellipse = circle() * np.array([[1.0], [0.4]])  # radius of curvature 0.16 at (±1, 0)
    body = outline(ellipse, thickness=0.2, size=0.04)
    assert angles(body.mesh.p, body.mesh.t).min() > 20
    depth = body.pial_curve.nearest(body.nodes[:, body.interface])[0]
    assert depth.min() > 0.199
    assert np.median(depth) == pytest.approx(0.2, rel=2e-3)
    within = body.quadrature.weights[body.depth < 0.2].sum()
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(within, rel=0.02)


def test_smoothing_removes_noise_and_keeps_the_circle():
    rng = np.random.default_rng(0)
    points = circle(600)
    noisy = points * (1 + 0.001 * rng.standard_normal(600))
    radius = np.hypot(*line(noisy, closed=True, step=0.01, smooth=0.1))
    # the kernel 2g - g*g lets through the share h/(2π) ∫ k̂² dk of the variance of white noise, h the spacing
    share = 2 * np.pi / 600 / (2 * np.pi) * np.sqrt(np.pi) / 0.1 * (4 - 4 / np.sqrt(1.5) + 1 / np.sqrt(2))
    assert radius.std() == pytest.approx(0.001 * np.sqrt(share), rel=0.3)  # about 2 π/0.25 independent values
    exact = line(points, closed=True, step=0.1, smooth=0.5)
    shrunk = 1 - (1 - np.exp(-0.5 * 0.5**2)) ** 2
    assert np.hypot(*exact) == pytest.approx(shrunk, abs=1e-4)


@pytest.mark.parametrize("smooth", [3.0, 10.0, 1000.0])
def test_smoothing_that_leaves_nothing_of_a_circle_is_refused(smooth):
    kept = 1 - (1 - np.exp(-0.5 * smooth**2)) ** 2  # of the radius 1, which is one wave
    assert kept < 0.1
    for unit in (1.0, 1e-3):  # the body is made in units of its width
        with pytest.raises(ValueError, match=r"of that is left.* make it smaller") as told:
            outline(unit * circle(), thickness=0.1 * unit, size=0.05 * unit, smooth=smooth * unit)
        share = float(str(told.value).split("smooth is ")[1].split()[0])
        assert share == pytest.approx(smooth / (2 * np.pi), rel=0.05)


def test_smoothing_keeps_the_ends_of_an_open_curve():
    x = np.linspace(0, 1, 100)
    points = np.stack([x, np.sin(40 * x)])
    smooth = line(points, closed=False, step=0.01, smooth=0.5)
    assert smooth[:, [0, -1]] == pytest.approx(points[:, [0, -1]], abs=1e-9)
    assert np.ptp(smooth[1]) < 0.9 * np.ptp(points[1])


def test_a_closed_outline_is_counter_clockwise_without_repeats():
    points = np.repeat(circle(12), 3, axis=1)[:, ::-1]
    (curve,) = closed_loops("points", points)
    assert curve.shape == (2, 12)
    assert 0.5 * np.sum(curve[0] * np.roll(curve[1], -1) - curve[1] * np.roll(curve[0], -1)) > 0


def test_a_single_disc_is_as_good_as_a_tuple_of_it():
    disc = RefinementDisc(centre=(0.0, 1.0), radius=0.3, share=0.5)
    one, several = (outline(circle(), thickness=0.3, size=0.15, fine=fine) for fine in (disc, [disc]))
    assert np.array_equal(one.nodes, several.nodes)
    assert one.mesh.nelements > outline(circle(), thickness=0.3, size=0.15).mesh.nelements


@pytest.mark.parametrize(
    ("fine", "shown"), [((1,), "1"), (None, "None"), (RefinementDisc, r"RefinementDisc \(a class\)")]
)
def test_what_is_no_disc_is_refused(fine, shown):
    words = rf"fine={shown} must be a RefinementDisc object, such as RefinementDisc\(centre="
    with pytest.raises(ValueError, match=words):
        outline(circle(), thickness=0.3, size=0.15, fine=fine)


def test_elements_are_finer_inside_a_disc_and_the_body_is_the_same():
    points = half_circle()
    options = {"thickness": 0.1, "size": 0.05, "base": "roller", "base_ends": ((-1, 0), (1, 0))}
    plain = outline(points, **options)
    body = outline(points, **options, fine=(RefinementDisc(centre=(0.0, 1.0), radius=0.3, share=0.4),))
    mesh = body.mesh
    assert angles(mesh.p, mesh.t).min() > 20
    ends = mesh.p[:, mesh.facets]
    length, middle = np.hypot(*(ends[:, 0] - ends[:, 1])), ends.mean(1)
    away = np.hypot(middle[0], middle[1] - 1.0)
    gray = np.hypot(*middle) > 0.9
    assert length[gray & (away < 0.25)].mean() == pytest.approx(0.02, rel=0.15)
    assert length[gray & (away > 0.6)].mean() == pytest.approx(0.05, rel=0.15)
    assert body.quadrature.weights.sum() == pytest.approx(plain.quadrature.weights.sum(), rel=1e-5)
    distance = body.pial_curve.nearest(body.nodes[:, body.interface])[0]
    assert distance == pytest.approx(0.1, rel=5e-3)
    with pytest.raises(ValueError, match="share=2"):
        RefinementDisc(centre=(0.0, 1.0), radius=0.3, share=2.0)
