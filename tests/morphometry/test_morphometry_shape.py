"""Gyrification, curvature, thickness, walls and registration on curves where they are known."""

import tracemalloc

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from morphometry_shapes import angles, comb, ellipse, flower, moved, mushrooms, polygon

from turingfold.morphometry.polyline import as_polyline, perimeter
from turingfold.morphometry.registration import registration
from turingfold.morphometry.shape import cortical_thickness, gyrification_index, shape_index, signed_curvature
from turingfold.morphometry.walls import mirror_error, self_intersections, wall_contact_length

steady = settings(derandomize=True, deadline=None, max_examples=20)


@pytest.mark.parametrize("height", [1.0, 0.74, 0.3])
@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_convex_bodies_have_index_one(height, arc):
    assert gyrification_index(ellipse(1, height, arc=arc)) == pytest.approx(1, abs=1e-12)


def test_index_of_a_comb():
    fingers, width, slot, depth, base = 5, 0.3, 0.1, 0.8, 1.0
    hull = 2 * (fingers * width + (fingers - 1) * slot + depth + base)
    expected = (hull + (fingers - 1) * 2 * depth) / hull  # each slot adds its two walls
    assert gyrification_index(comb(fingers, width, slot, depth, base)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("cusps", [3, 5, 8])
def test_index_of_an_epicycloid(cusps):
    """Length 8 (k + 1) on a unit rolling circle; its hull has k straight sides between the tops of arches."""
    t = angles(8000)
    points = (cusps + 1) * np.array([np.cos(t), np.sin(t)]) - np.array(
        [np.cos((cusps + 1) * t), np.sin((cusps + 1) * t)]
    )
    assert perimeter(points) == pytest.approx(8 * (cusps + 1), rel=1e-5)
    # A tangent perpendicular to the middle of a cusp touches where r cos(phi) is largest.
    near = np.linspace(0, np.pi / cusps, 200_001)
    x = (cusps + 1) * np.cos(near) - np.cos((cusps + 1) * near)
    top = int(np.argmax(x))
    y = (cusps + 1) * np.sin(near[top]) - np.sin((cusps + 1) * near[top])
    arch = 8 * (cusps + 1) / cusps
    under = 4 * (cusps + 1) / cusps * (1 - np.cos(cusps * near[top] / 2))  # arc from the cusp to the touch
    hull = cusps * (arch - 2 * under + 2 * y)
    assert gyrification_index(points) == pytest.approx(8 * (cusps + 1) / hull, rel=1e-5)


def test_index_over_the_initial_length():
    assert gyrification_index(ellipse(3, 3), initial=ellipse(2, 2)) == pytest.approx(1.5, rel=1e-12)


def test_pial_ends_tucked_under_the_body_keep_the_index_above_one():
    """An arc of 300 degrees: its base is not part of the outer path."""
    assert gyrification_index(ellipse(1, 1, arc=5 * np.pi / 3)) == pytest.approx(1, abs=1e-12)


@steady
@given(
    lobes=st.integers(2, 20),
    amplitude=st.floats(0, 0.4),
    angle=st.floats(-4, 4),
    scale=st.floats(1e-3, 1e3),
    arc=st.sampled_from([np.pi, 2 * np.pi]),
    backwards=st.booleans(),
)
def test_index_is_invariant_and_at_least_one(lobes, amplitude, angle, scale, arc, backwards):
    points = flower(lobes, amplitude, 700, arc)
    other = moved(points, angle, scale, (scale, -3 * scale))[:, :: -1 if backwards else 1]
    index = gyrification_index(points)
    assert index >= 1 - 1e-12
    assert gyrification_index(other) == pytest.approx(index, rel=1e-9)
    assert gyrification_index(flower(lobes, amplitude, 2000, arc)) == pytest.approx(index, rel=0.01)


def test_curvature_of_an_ellipse_converges_with_order_two():
    errors = []
    for n in (200, 400, 800):
        t = angles(n)
        exact = 2 * 1 / ((2 * np.sin(t)) ** 2 + np.cos(t) ** 2) ** 1.5
        errors.append(np.abs(signed_curvature(ellipse(2, 1, n)) - exact).max())
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.05)


@pytest.mark.parametrize("step", [1, -1])
def test_curvature_turns_once_around_and_is_positive_outwards(step):
    points = mushrooms(7, 0.2)[:, ::step]
    curvature = signed_curvature(points)
    assert np.sum(curvature * as_polyline(points).weights) == pytest.approx(2 * np.pi, rel=1e-12)
    arc = signed_curvature(ellipse(2, 2, 300, arc=np.pi)[:, ::step])
    np.testing.assert_allclose(arc, 0.5, rtol=1e-4)


def test_shape_index_of_a_circle_and_a_hollow():
    np.testing.assert_allclose(shape_index(ellipse(2, 2, 3000), 2.0), 0.5, rtol=1e-6)
    hollow = signed_curvature(flower(3, 0.3, 3000))
    at = 500  # theta = pi/3: r = 1 - a, r'' = a n^2, kappa = (r - r'') / r^2
    assert hollow[at] == pytest.approx((0.7 - 2.7) / 0.49, rel=1e-3)
    assert shape_index(flower(3, 0.3, 3000), 0.49)[at] == pytest.approx(2 / np.pi * np.arctan(-2.0), rel=1e-3)


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_thickness_in_gyri_and_sulci(arc):
    thickness = cortical_thickness(flower(12, 0.05, arc=arc), ellipse(0.8, 0.8, arc=arc))
    np.testing.assert_allclose(thickness.all, 0.2 + 0.05 * np.cos(12 * angles(1200, arc)), atol=2e-5)
    np.testing.assert_allclose(thickness.gyri, 0.25, atol=1e-4)
    np.testing.assert_allclose(thickness.sulci, 0.15, atol=1e-4)
    assert thickness.ratio == pytest.approx(0.25 / 0.15, rel=1e-3)
    assert cortical_thickness(ellipse(1, 1), ellipse(0.8, 0.8)).ratio == 1.0


@pytest.mark.parametrize(("gap", "walls"), [(0.11, 2 * 0.8 * 4), (0.09, 0.0)])
def test_walls_touch_within_the_gap(gap, walls):
    touching = wall_contact_length(comb(5, 0.3, 0.1, 0.8, step=0.01), gap)
    assert touching == pytest.approx(walls, rel=1e-9)


def test_only_the_parts_of_walls_that_face_each_other_touch():
    """A notch whose walls are 1 and 0.5 high: 0.5 of each is in contact, and the step between two samples."""
    notch = [(0, 0), (3, 0), (3, 1.5), (1.1, 1.5), (1.1, 1.0), (1.0, 1.0), (1.0, 2.0), (0, 2.0)]
    assert wall_contact_length(polygon(notch, 0.01), 0.12) == pytest.approx(1.0, abs=0.011)


def test_the_two_sides_of_a_thin_gyrus_do_not_touch():
    assert wall_contact_length(comb(5, 0.05, 0.2, 0.8), 0.1) == 0.0


def test_wall_contact_does_not_depend_on_where_the_points_are():
    walls = [wall_contact_length(comb(4, 0.3, 1e-5, 0.8, step=step), 1e-4) for step in (0.05, 0.013)]
    np.testing.assert_allclose(walls, 2 * 0.8 * 3, rtol=0.01)


@pytest.mark.parametrize("points", [ellipse(1, 0.2), mushrooms(12, 0.15), comb(9, 0.3, 1e-6, 2.0)])
def test_simple_curves_do_not_cross_themselves(points):
    assert self_intersections(points) == 0


@pytest.mark.parametrize(("a", "b"), [(1, 2), (2, 3), (3, 4), (5, 3), (7, 6)])
@pytest.mark.parametrize("n", [997, 1000])
def test_crossings_of_lissajous_figures(a, b, n):
    """x = sin(a t + 1/5), y = sin b t crosses itself 2 a b - a - b times if no phase makes it degenerate."""
    t = angles(n)
    points = np.array([np.sin(a * t + 0.2), np.sin(b * t)])
    assert self_intersections(points) == 2 * a * b - a - b


@pytest.mark.parametrize("n", [200, 201, 203])
def test_a_crossing_through_vertices_counts_once(n):
    t = angles(n)
    assert self_intersections(np.array([np.sin(t), np.sin(t) * np.cos(t)])) == 1


@pytest.mark.parametrize("first", [1, -1])
@pytest.mark.parametrize("second", [1, -1])
def test_a_crossing_in_a_common_vertex_counts_once(first, second):
    """Both diagonals of a square, through (0, 0), with exact coordinates, in every direction."""
    up = np.arange(-4, 5)
    points = np.hstack((np.array([up, -up])[:, ::first], np.array([up, up])[:, ::second]))
    for turned in (points, -points, points[::-1] * [[1], [-1]], points[::-1] * [[-1], [1]]):
        assert self_intersections(turned, closed=True) == 1


@pytest.mark.parametrize(("h", "crossings"), [(0.081, 0), (0.079, 2), (0.05, 2)])
def test_crossings_of_quadratic_segments_are_those_of_the_curves(h, crossings):
    """Parabolas y = 0.04 (1 - x²) and y = h - 0.04 (1 - x²) meet twice if h < 0.08; their chords if h < 0."""
    lower, upper = [(-1, 0), (0, 0.04), (1, 0)], [(1, h), (0, h - 0.04), (-1, h)]
    path = np.array([(-3, -1), *lower, (3, h / 2), *upper], dtype=float).T
    path = np.hstack((ellipse(1, 1, 9, np.pi) - np.array([[5.0], [0.0]]), path))
    assert self_intersections(path, closed=False, quadratic=True) == crossings


@pytest.mark.parametrize(("a", "b"), [(1, 2), (2, 3), (5, 3)])
def test_crossings_of_quadratic_lissajous_figures(a, b):
    t = angles(800)
    points = np.array([np.sin(a * t + 0.2), np.sin(b * t)])
    assert self_intersections(points, closed=True, quadratic=True) == 2 * a * b - a - b
    with pytest.raises(ValueError, match="799 points; the nodes of quadratic segments are an even number"):
        self_intersections(points[:, :-1], closed=True, quadratic=True)


@pytest.mark.parametrize("angle", [0.0, 22.5, 45.0, 90.0, 120.0])
def test_crossings_of_quadratic_segments_are_those_of_another_library(angle):
    """Straight quadratic segments of a random walk along a wall, counted by GEOS as pairs that cross."""
    turn = np.exp(1j * np.radians(angle))
    corners = np.random.default_rng(3).normal(size=(2, 300)).T @ [1, 1j] * turn + np.arange(300) * 0.05 * turn
    path = np.insert(corners, range(1, 300), 0.5 * (corners[1:] + corners[:-1]))
    lines = shapely.linestrings(np.stack([corners[:-1], corners[1:]], axis=1).view(float).reshape(-1, 2, 2))
    i, j = shapely.STRtree(lines).query(lines, predicate="crosses")
    found = self_intersections(np.stack([path.real, path.imag]), closed=False, quadratic=True)
    assert found == np.sum(i < j) > 1000


@pytest.mark.parametrize("angle", [0.0, 45.0, 90.0, 135.0])
def test_a_straight_wall_costs_no_pairs_of_all_its_segments(angle):
    """Of 4000 segments there are 8 million pairs, of 64 MB for each of their numbers; neighbours are few."""
    along = np.linspace(-1.0, 1.0, 8001) + 0j
    along[-2:] += [0.5e-3j, 1e-3j]  # a curve cannot be straight from end to end
    along *= np.exp(1j * np.radians(angle))
    tracemalloc.start()
    found = self_intersections(np.stack([along.real, along.imag]), closed=False, quadratic=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found == 0
    assert peak < 30e6


def test_crossing_of_two_long_segments_counts_once():
    arc = 0.1 * ellipse(1, 1, 100, np.pi)
    path = np.hstack((arc, [[-3, 3, 3, -3], [-1, -2, -1, -2]]))
    assert self_intersections(path, closed=False) == 1


def test_crossings_with_one_long_segment():
    """A chord through the lobes of a half flower: in at one side of a lobe, out at the other."""
    arc = flower(12, 0.3, 600, arc=np.pi)
    assert self_intersections(arc, closed=False) == 0
    chord = np.array([[-2.0, 2.0], [0.9, 0.9]])
    path = np.hstack((arc, [[-2.0], [0.0]], chord))
    side = np.sign(arc[1] - 0.9)
    inside = int(np.sum(side[1:] != side[:-1]))
    assert inside > 0
    assert self_intersections(path, closed=False) == inside


def test_mirror_error():
    points = flower(12, 0.3, 601, arc=np.pi)
    assert mirror_error(points) < 1e-14
    points[:, 200] += [3e-3, 4e-3]
    assert mirror_error(points) == pytest.approx(5e-3, rel=1e-9)
    aside = moved(ellipse(1, 1, 100, arc=np.pi), shift=(0.25, 0.0))
    assert mirror_error(aside) == pytest.approx(0.5, rel=1e-9)
    with pytest.raises(ValueError, match=r"points has shape \(3,\)"):
        mirror_error([1, 2, 3])


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
@pytest.mark.parametrize("height", [1.0, 0.74])
def test_gyri_on_the_peaks_register_with_one(arc, height):
    rest, peaks = ellipse(1, height, 2400, arc), np.cos(20 * angles(2400, arc))
    folded = rest + 0.05 * peaks * as_polyline(rest).normals
    assert registration(peaks, folded, rest) > 0.999
    assert registration(0.5 - 3 * peaks, folded, rest) < -0.999


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_overhanging_gyri_on_the_peaks_register_with_one(arc):
    rest, peaks = ellipse(1, 1, 2400, arc), np.cos(20 * angles(2400, arc))
    assert registration(peaks, mushrooms(20, 0.1, 2400, arc), rest) > 0.999


@pytest.mark.parametrize("shift", [0.3, 1.0, np.pi / 2, 2.5])
def test_shifted_peaks_register_with_the_cosine_of_the_shift(shift):
    found = registration(np.cos(11 * angles(1000) + shift), flower(11, 0.1, 1000), ellipse(1, 1, 1000))
    assert found == pytest.approx(np.cos(shift), abs=1e-4)


def test_registration_of_other_wave_numbers_and_of_an_unfolded_body():
    circle, folded = ellipse(1, 1, 1000), flower(11, 0.1, 1000)
    assert abs(registration(np.cos(10 * angles(1000)), folded, circle)) < 1e-3
    assert registration(np.cos(10 * angles(1000)), circle, circle) == 0.0
    assert registration(np.cos(10 * angles(1000)), 1.3 * circle, circle) == 0.0


def test_a_trend_of_the_body_is_not_a_fold():
    """Folds on a half disc that bulges: uncorrelated with the peaks, the bulge hides them."""
    theta, rest = angles(1501, np.pi), ellipse(1, 1, 1501, np.pi)
    peaks = np.cos(22 * theta)
    bulged = rest * (1 + 0.3 * np.sin(theta) ** 2 + 0.05 * peaks)
    assert registration(peaks, bulged, rest) > 0.99
    folds, bulge = 0.05 / np.sqrt(2), 0.3 / np.sqrt(8)  # standard deviations of cos and of sin^2
    plain = registration(peaks, bulged, rest, trend=0)
    assert plain == pytest.approx(folds / np.hypot(folds, bulge), rel=0.01)


def test_registration_weighs_nodes_by_their_length():
    """Nodes crowded on one half of the circle do not count more than those on the other."""
    uneven = angles(1000) + 0.8 * np.sin(angles(1000))
    rest = np.array([np.cos(uneven), np.sin(uneven)])
    height = 1 + 0.1 * np.cos(11 * uneven)
    found = registration(np.cos(11 * uneven + 1.0), height * rest, rest)
    assert found == pytest.approx(np.cos(1.0), abs=2e-3)


def test_the_trend_does_not_depend_on_the_spacing_of_the_nodes():
    def found(theta):
        rest = np.array([np.cos(theta), np.sin(theta)])
        height = 1 + 0.1 * np.exp(theta) * np.cos(4 * theta + 0.3)
        return registration(np.cos(4 * theta), rest * height, rest)

    even = angles(2001, np.pi)
    assert found(even + 0.45 * np.sin(2 * even)) == pytest.approx(found(even), abs=1e-5)
