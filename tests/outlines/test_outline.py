"""Outlines: repairing, offsetting, meshing."""

import numpy as np
import pytest

from turingfold.geometry.polygon import inside
from turingfold.outlines import Fine, outline
from turingfold.outlines.fill import angles
from turingfold.outlines.line import line
from turingfold.outlines.repair import closed_outline


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
    assert (body.nodes[1, base] == 0).all()
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
    assert distance == pytest.approx(0.15, rel=5e-3)


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
        ({"thickness": 1.2}, "no white matter"),
        ({"base": "roller"}, "needs base_ends"),
        ({"base": "clamped", "base_ends": ((1, 0), (1, 0))}, "same point"),
        ({"tight": "maybe"}, "tight='maybe'"),
        ({"smooth": -1.0}, "smooth=-1"),
    ],
)
def test_bad_input_is_refused_by_name(change, message):
    with pytest.raises(ValueError, match=message):
        outline(**({"points": circle(), "thickness": 0.1, "size": 0.05} | change))


def test_a_crossing_is_refused_with_its_place():
    at = 2 * np.pi * (np.arange(101) + 0.3) / 101
    eight = np.stack([0.5 + np.sin(2 * at), 0.25 + np.sin(at)])
    with pytest.raises(ValueError, match=r"crosses .* near \(0\.5, 0\.25\)"):
        outline(eight, thickness=0.05, size=0.05)


def test_a_thickness_beyond_the_radius_of_curvature_is_refused_with_its_place():
    ellipse = circle() * np.array([[1.0], [0.4]])  # radius of curvature 0.16 at (±1, 0)
    with pytest.raises(ValueError, match=r"near \(-?1, .*radius of curvature is 0\.16"):
        outline(ellipse, thickness=0.2, size=0.05)
    assert outline(ellipse, thickness=0.15, size=0.05).thickness == 0.15


@pytest.mark.parametrize("base", ["free", "roller"])
def test_a_cortex_that_leaves_hardly_any_inside_is_refused(base):
    points, ends = circle(), None  # the deepest point is the centre, at depth 1
    if base == "roller":
        points, ends = half_circle(), ((-1, 0), (1, 0))
        points[0, -1] = 0.5  # the only point within the base is not the deepest
    options = {"size": 0.1, "base": base, "base_ends": ends}
    assert outline(points, thickness=0.66, **options).thickness == 0.66
    with pytest.raises(ValueError, match=r"thickness=0\.67 m must be at most 0\.6667 m.*\(1 m, at \("):
        outline(points, thickness=0.67, **options)


def test_a_cortex_two_thirds_as_thick_as_an_ellipse_is_deep_is_refused_when_trimming():
    ellipse = circle() * np.array([[1.0], [0.4]])  # the largest circle inside has the radius 0.4
    with pytest.raises(ValueError, match=r"at most 0\.2667 m.*\(0\.4 m, at"):
        outline(ellipse, thickness=0.27, size=0.05, tight="trim")


def test_a_neck_thinner_than_two_cortices_is_refused():
    at = 2 * np.pi * np.arange(300) / 300
    peanut = (0.6 + 0.5 * np.cos(2 * at)) * np.stack([np.cos(at), np.sin(at)])  # 0.2 wide at the neck
    with pytest.raises(ValueError, match="opposite sides"):
        outline(peanut, thickness=0.12, size=0.05)
    with pytest.raises(ValueError, match="in two"):
        outline(peanut, thickness=0.12, size=0.05, tight="trim")


def test_a_small_pocket_of_white_matter_is_cut_off_when_trimming():
    large = np.linspace(np.arcsin(0.15), 2 * np.pi - np.arcsin(0.15), 200)
    knob = np.linspace(-5 / 6 * np.pi, 5 / 6 * np.pi, 60)  # of radius 0.3 around (1.45, 0), neck 0.3 wide
    start, end = np.cos(large[0]), 1.45 + 0.3 * np.cos(knob[0])
    neck = np.linspace(start, end, 8)[1:-1]
    x = np.concatenate([np.cos(large), neck, 1.45 + 0.3 * np.cos(knob), neck[::-1]])
    y = np.concatenate([np.sin(large), np.full(6, -0.15), 0.3 * np.sin(knob), np.full(6, 0.15)])
    body = outline(np.stack([x, y]), thickness=0.12, size=0.05, smooth=0.02, tight="trim")
    assert body.nodes[0, body.interface].max() < 1.2
    corners = body.mesh.p[:, body.mesh.t].mean(1)
    assert body.in_cortex[corners[0] > 1.2].all()
    assert angles(body.mesh.p, body.mesh.t).min() > 20


def test_trimming_keeps_the_cortex_one_thickness_deep():
    ellipse = circle() * np.array([[1.0], [0.4]])
    body = outline(ellipse, thickness=0.2, size=0.04, tight="trim")
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
    smooth = line(noisy, closed=True, smooth=0.1)
    radius = np.hypot(*smooth.at(smooth.spaced(0.01)))
    # the kernel 2g - g*g lets through the share h/(2π) ∫ k̂² dk of the variance of white noise, h the spacing
    share = 2 * np.pi / 600 / (2 * np.pi) * np.sqrt(np.pi) / 0.1 * (4 - 4 / np.sqrt(1.5) + 1 / np.sqrt(2))
    assert radius.std() == pytest.approx(0.001 * np.sqrt(share), rel=0.3)  # about 2 π/0.25 independent values
    exact = line(points, closed=True, smooth=0.5)
    shrunk = 1 - (1 - np.exp(-0.5 * 0.5**2)) ** 2
    assert np.hypot(*exact.at(exact.spaced(0.1))) == pytest.approx(shrunk, abs=1e-4)


@pytest.mark.parametrize("smooth", [3.0, 10.0, 1000.0])
def test_smoothing_that_leaves_nothing_of_a_circle_is_refused(smooth):
    kept = 1 - (1 - np.exp(-0.5 * smooth**2)) ** 2  # of the radius 1, which is one wave
    assert kept < 0.1
    with pytest.raises(ValueError, match=rf"smooth={smooth:g} m leaves .* make it smaller"):
        line(circle(), True, smooth)


def test_smoothing_keeps_the_ends_of_an_open_curve():
    x = np.linspace(0, 1, 100)
    points = np.stack([x, np.sin(40 * x)])
    smooth = line(points, closed=False, smooth=0.5)
    assert smooth.at(np.array([0.0, smooth.length])) == pytest.approx(points[:, [0, -1]], abs=1e-9)
    assert np.ptp(smooth.at(smooth.spaced(0.01))[1]) < 0.9 * np.ptp(points[1])


def test_points_are_told_inside_from_outside():
    square = np.array([[0, 1, 1, 0], [0, 0, 1, 1.0]])
    points = np.array([[0.5, 1.5, -0.1, 0.9, 0.5], [0.5, 0.5, 0.5, 0.1, -1e-9]])
    assert inside(points, square).tolist() == [True, False, False, True, False]


def test_a_closed_outline_is_counter_clockwise_without_repeats():
    points = np.repeat(circle(12), 3, axis=1)[:, ::-1]
    curve = closed_outline(points)
    assert curve.shape == (2, 12)
    assert 0.5 * np.sum(curve[0] * np.roll(curve[1], -1) - curve[1] * np.roll(curve[0], -1)) > 0


def test_a_single_disc_is_as_good_as_a_tuple_of_it():
    disc = Fine(centre=(0.0, 1.0), radius=0.3, share=0.5)
    one, several = (outline(circle(), thickness=0.3, size=0.15, fine=fine) for fine in (disc, [disc]))
    assert np.array_equal(one.nodes, several.nodes)
    assert one.mesh.nelements > outline(circle(), thickness=0.3, size=0.15).mesh.nelements


@pytest.mark.parametrize(("fine", "shown"), [((1,), "1"), (None, "None"), (Fine, r"Fine \(a class\)")])
def test_what_is_no_disc_is_refused(fine, shown):
    with pytest.raises(ValueError, match=rf"fine={shown} must be a Fine object, such as Fine\(centre="):
        outline(circle(), thickness=0.3, size=0.15, fine=fine)


def test_elements_are_finer_inside_a_disc_and_the_body_is_the_same():
    points = half_circle()
    options = {"thickness": 0.1, "size": 0.05, "base": "roller", "base_ends": ((-1, 0), (1, 0))}
    plain = outline(points, **options)
    body = outline(points, **options, fine=(Fine(centre=(0.0, 1.0), radius=0.3, share=0.4),))
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
        Fine(centre=(0.0, 1.0), radius=0.3, share=2.0)
