"""Checks of input, arc length, outer path, distances."""

import numpy as np
import pytest
from morphometry_shapes import angles, ellipse, flower, polygon
from scipy.special import ellipe

from turingfold.morphometry.compare import compare
from turingfold.morphometry.folds import find_folds, fold_count
from turingfold.morphometry.fourier import fourier_descriptors
from turingfold.morphometry.polyline import as_polyline, perimeter, signed_distance
from turingfold.morphometry.registration import registration, registration_null
from turingfold.morphometry.resampling import resample
from turingfold.morphometry.shape import cortical_thickness, gyrification_index, shape_index
from turingfold.morphometry.similarity import similarity
from turingfold.morphometry.walls import self_intersections, wall_contact_length


def with_nan(points):
    points = points.copy()
    points[1, 5] = np.nan
    return points


CIRCLE, ARC = ellipse(1, 1, 100), ellipse(1, 1, 100, arc=np.pi)
BAD = {
    "rows and columns swapped": (CIRCLE.T, None, r"shape \(100, 2\); it must be \(2, n\)"),
    "not a number": (with_nan(CIRCLE), None, r"nan at index \(1, 5\)"),
    "seven points": (CIRCLE[:, :7], None, "7 points; at least 8"),
    "two equal points": (np.insert(CIRCLE, 31, CIRCLE[:, 30], axis=1), None, "30 and 31 coincide"),
    "an open outline": (ARC, True, "at most 5 times the longest segment"),
    "a closed pial surface": (np.hstack((CIRCLE, CIRCLE[:, :1])), False, "pass closed=True"),
    "a straight line": (np.linspace(0, 1, 20) * [[1.0], [2.0]], None, "one straight line"),
    "seven points and the first again": (np.hstack((ellipse(1, 1, 7),) * 2)[:, :8], None, "7 points"),
}


@pytest.mark.parametrize("measure", [gyrification_index, fold_count, self_intersections, perimeter])
@pytest.mark.parametrize("case", BAD)
def test_bad_points_are_refused(measure, case):
    points, closed, message = BAD[case]
    with pytest.raises(ValueError, match=message):
        measure(points, closed=closed)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: find_folds(CIRCLE, prominence=-1.0), "prominence=-1 must be positive"),
        (
            lambda: find_folds(CIRCLE, thickness=2.5),
            "thickness=2.5 must be between 0.00099.* and 1.99.*one unit",
        ),
        (lambda: find_folds(CIRCLE, thickness=1e-4), "thickness=0.0001 must be between .*radius of 0.99"),
        (lambda: find_folds(CIRCLE, smoothing=-0.1), "smoothing=-0.1 must be between 0 and 0.99"),
        (lambda: gyrification_index(CIRCLE, smoothing=np.nan), "smoothing=nan must be a finite number"),
        (lambda: find_folds(CIRCLE, reference=ARC), "reference: the gap"),
        (lambda: shape_index(CIRCLE, 0.0), "thickness=0 must be between 0.00099"),
        (lambda: cortical_thickness(CIRCLE, CIRCLE[:, :5]), "interface has 5 points"),
        (
            lambda: similarity(1e3 * CIRCLE, CIRCLE, thickness=0.1),
            "thickness=0.1 must be between 0.99.*of 999",
        ),
        (lambda: compare(1e3 * CIRCLE, CIRCLE, thickness=0.1), "give both in one unit"),
        (lambda: wall_contact_length(CIRCLE, np.inf), "gap=inf must be a finite number"),
        (lambda: fourier_descriptors(CIRCLE, 51), "order=51 must be at most half the points, 50"),
        (lambda: fourier_descriptors(CIRCLE, 2.5), "order=2.5 must be a whole number"),
        (lambda: similarity(CIRCLE, ARC), "both must be of one kind"),
        (lambda: similarity(CIRCLE, CIRCLE, 0.5), "p=0.5 must be between 1 and inf; use 1, 2 or inf"),
        (lambda: similarity(CIRCLE, CIRCLE, np.nan), "p=nan must be a finite number; use 1, 2 or inf"),
        (lambda: similarity(CIRCLE, CIRCLE, "1"), "p='1' must be a finite number; use 1, 2 or inf"),
        (lambda: similarity(CIRCLE, CIRCLE, -np.inf), "p=-inf must be a finite number"),
        (lambda: registration(np.ones(100), CIRCLE, CIRCLE), "pattern is constant"),
        (
            lambda: registration_null(np.arange(100), CIRCLE, CIRCLE, phases=1),
            "phases=1 must be a whole number",
        ),
        (lambda: registration_null(np.ones(100), CIRCLE, CIRCLE), "pattern is constant"),
        (lambda: registration(np.ones(99), CIRCLE, CIRCLE), "pattern has 99 values"),
        (lambda: registration(np.ones(100), CIRCLE[:, :-1], CIRCLE), "must be the same nodes"),
        (lambda: resample(CIRCLE, 7), "count=7 must be a whole number of at least 8"),
    ],
)
def test_bad_options_are_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_open_or_closed_is_seen():
    assert as_polyline(CIRCLE).closed
    assert not as_polyline(ARC).closed
    repeated = as_polyline(np.hstack((CIRCLE, CIRCLE[:, :1])))
    assert repeated.closed
    np.testing.assert_array_equal(repeated.points, CIRCLE)


def test_perimeter_of_an_ellipse_converges_with_order_two():
    exact = 4 * 2.0 * ellipe(1 - (1 / 2.0) ** 2)
    errors = [exact - perimeter(ellipse(2, 1, n)) for n in (100, 200, 400)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 2, atol=0.01)


@pytest.mark.parametrize("closed", [True, False])
def test_weights_share_out_the_length(closed):
    curve = as_polyline(CIRCLE if closed else ARC, closed)
    assert curve.weights.sum() == pytest.approx(curve.length, rel=1e-14)
    np.testing.assert_allclose(curve.arc, np.arange(100) * curve.lengths[0], rtol=1e-13)


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
@pytest.mark.parametrize("step", [1, -1])
def test_normals_point_out_whichever_way_the_curve_runs(arc, step):
    points = ellipse(1, 1, 101, arc)[:, ::step]
    normals = as_polyline(points).normals
    inner = slice(None) if arc > 6 else slice(1, -1)
    np.testing.assert_allclose(normals[:, inner], points[:, inner], atol=1e-12)


def test_radius_is_that_of_the_disc_and_of_the_half_disc():
    for points in (ellipse(3, 3, 2000), ellipse(3, 3, 2000, arc=np.pi)):
        assert as_polyline(points).radius == pytest.approx(3, rel=1e-5)


def test_smoothing_a_circle_with_a_wave_damps_both_as_a_gaussian_does():
    """Of exp(i k t) the part exp(-(k w)^2/2) stays: k = 1 for the circle, 1 + n and 1 - n for its wave."""
    n, a, width = 9, 1e-3, 0.1
    theta = angles(4000)
    smooth = as_polyline(flower(n, a, 4000)).smoothed(width).points
    damped = [np.exp(-((k * width) ** 2) / 2) for k in (1, 1 + n, 1 - n)]
    expected = damped[0] * np.exp(1j * theta) + a / 2 * (
        damped[1] * np.exp(1j * (1 + n) * theta) + damped[2] * np.exp(1j * (1 - n) * theta)
    )
    # along the arc instead of the angle: the speed differs by terms of order a^2 n^2
    np.testing.assert_allclose((1, 1j) @ smooth, expected, atol=20 * a**2 * n**2)


def test_smoothing_a_half_disc_is_smoothing_the_disc():
    whole, half = (as_polyline(flower(8, 0.1, n, arc)) for n, arc in ((2000, 2 * np.pi), (1001, np.pi)))
    smooth = half.smoothed(0.1).points
    np.testing.assert_allclose(smooth, whole.smoothed(0.1).points[:, :1001], atol=1e-5)
    np.testing.assert_array_equal(half.smoothed(0.0).points, half.points)


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_resampling_stays_on_the_curve_at_equal_steps(arc):
    uneven = np.linspace(0, 1, 90, endpoint=arc < 6)
    theta = arc * (uneven + 0.1 * np.sin(2 * np.pi * uneven) / np.pi)
    points = resample(np.stack((np.cos(theta), np.sin(theta))), 333)
    expected = ellipse(1, 1, 333, arc)
    np.testing.assert_allclose(points, expected, atol=2e-5)


def test_distance_to_a_square_is_signed_and_exact():
    square = polygon([(0, 0), (2, 0), (2, 2), (0, 2)], 0.4)
    points = np.array([[1, 0.25], [1.1, 1], [5, 6], [-1, 1.3], [2, 1.3], [-3, -4]]).T
    expected = [-0.25, -0.9, 5, 1, 0, 5]
    for outline in (square, square[:, ::-1]):
        np.testing.assert_allclose(signed_distance(points, as_polyline(outline)), expected, atol=1e-14)


@pytest.mark.parametrize("step", [1, -1])
def test_all_around_a_sharp_corner_is_outside(step):
    """Beyond a corner of 11 degrees most points lie behind one of its two sides."""
    spike = polygon([(0, 0), (-5, 0.5), (-5, -0.5)], 0.1)[:, ::step]
    turn = np.radians(np.linspace(-84, 84, 41))  # between the normals of the two sides
    around = 0.05 * np.array([np.cos(turn), np.sin(turn)])
    np.testing.assert_allclose(signed_distance(around, as_polyline(spike)), 0.05, rtol=1e-12)


def test_distance_to_a_concave_outline_agrees_with_all_segments():
    curve = as_polyline(flower(7, 0.3, 300))
    points = np.random.default_rng(3).uniform(-1.5, 1.5, (2, 200))
    offset = points[:, :, None] - curve.points[:, None, :]
    along = np.clip((offset * curve.segments[:, None, :]).sum(0) / curve.lengths**2, 0, 1)
    brute = np.hypot(*(offset - along * curve.segments[:, None, :])).min(axis=1)
    found = signed_distance(points, curve)
    np.testing.assert_allclose(np.abs(found), brute, rtol=1e-5, atol=1e-6)
    theta, r = np.arctan2(points[1], points[0]), np.hypot(*points)
    outside = r > 1 + 0.3 * np.cos(7 * theta)
    np.testing.assert_array_equal((found > 0)[brute > 1e-3], outside[brute > 1e-3])
