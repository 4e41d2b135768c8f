"""Folds of curves whose folds are known, and what must not change them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from morphometry_shapes import angles, comb, ellipse, flower, moved, mushrooms, voxels

from turingfold.morphometry.folds import (
    find_folds,
    fold_count,
    fold_height,
    sulcal_depth,
    wavelength_spectrum,
)
from turingfold.morphometry.polyline import as_polyline
from turingfold.morphometry.shape import gyrification_index
from turingfold.morphometry.walls import self_intersections

steady = settings(derandomize=True, deadline=None, max_examples=20)


@pytest.mark.parametrize("height", [1.0, 0.74, 0.3])
@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_convex_bodies_have_no_folds(height, arc):
    folds = find_folds(ellipse(1, height, arc=arc))
    assert (folds.count, folds.depth) == (0, 0.0)
    assert np.isnan(folds.width)  # there is no gyrus to measure
    assert folds.gyri.size == 0


@pytest.mark.parametrize("height", [1.0, 0.74, 0.5])
@pytest.mark.parametrize(("lobes", "amplitude"), [(3, 0.3), (5, 0.1), (12, 0.04), (12, 0.3), (40, 0.1)])
def test_lobes_are_counted_on_circle_and_ellipse(lobes, amplitude, height):
    assert fold_count(flower(lobes, amplitude, height=height)) == lobes


@pytest.mark.parametrize("height", [1.0, 0.74])
@pytest.mark.parametrize("lobes", [8, 22, 40])
def test_half_body_with_crests_at_both_ends(lobes, height):
    folds = find_folds(flower(lobes, 0.05, arc=np.pi, height=height))
    assert folds.count == lobes // 2
    assert folds.gyri.size == lobes // 2 + 1
    assert folds.widths.size == lobes // 2 - 1  # the gyri at the base have one wall each


@pytest.mark.parametrize(("lobes", "amplitude"), [(5, 0.1), (12, 0.05), (12, 0.4)])
def test_depth_is_that_below_the_common_tangent_of_two_crests(lobes, amplitude):
    psi = np.linspace(0, np.pi / lobes, 100_001)  # from the sulcus to the crest
    tangent = ((1 - amplitude * np.cos(lobes * psi)) * np.cos(psi)).max()
    expected = tangent - (1 - amplitude)
    assert sulcal_depth(flower(lobes, amplitude, 4000)) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("lobes", "amplitude"), [(3, 0.05), (12, 0.004), (12, 0.05), (12, 0.4)])
def test_depth_and_width_about_a_reference(lobes, amplitude):
    """Against the circle they undulate about, lobes are 2a deep and 2 sin(pi/2n) wide half way down."""
    folds = find_folds(flower(lobes, amplitude, 2400), reference=ellipse(1, 1), prominence=0.005)
    assert folds.count == lobes
    np.testing.assert_allclose(folds.depths, 2 * amplitude, rtol=1e-3)
    np.testing.assert_allclose(folds.widths, 2 * np.sin(np.pi / (2 * lobes)), rtol=2e-3)


def test_positions_of_gyri_and_sulci():
    folds = find_folds(flower(6, 0.2, 1200))
    np.testing.assert_array_equal(np.sort(folds.sulci), np.arange(100, 1200, 200))
    np.testing.assert_allclose(np.sort(folds.gyri), np.arange(0, 1200, 200), atol=1)


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_overhanging_folds(arc):
    points = mushrooms(12, 0.15, arc=arc)
    assert self_intersections(points) == 0
    angle = np.unwrap(np.arctan2(points[1], points[0]))
    assert (np.diff(angle) < 0).sum() > 100  # not a function of the angle
    count = 12 if arc > 6 else 6
    assert fold_count(points) == count
    folds = find_folds(points, reference=ellipse(1, 1, arc=arc))
    assert folds.count == count
    np.testing.assert_allclose(folds.depths, 0.3, rtol=1e-3)


@pytest.mark.parametrize("slot", [0.2, 1e-4])
def test_rectangular_fingers_with_open_and_touching_walls(slot):
    points = comb(8, 0.3, slot, 0.7)
    folds = find_folds(points)
    assert folds.count == 7
    np.testing.assert_allclose(folds.depths, 0.7, rtol=1e-9)
    floors = 0.3 + slot / 2 + (0.3 + slot) * np.arange(7)
    np.testing.assert_allclose(np.sort(points[0, folds.sulci]), floors, atol=0.01)  # in their middle
    inner = np.sort(folds.widths)[:6]  # the gyrus between the last and the first slot is the body itself
    np.testing.assert_allclose(inner, 0.3, rtol=1e-9)


@pytest.mark.parametrize("shape", [flower(1, 0.0), flower(12, 0.1), mushrooms(12, 0.15)])
def test_noise_makes_no_folds(shape):
    noise = np.random.default_rng(1).normal(0, 5e-4, shape.shape)
    assert fold_count(shape + noise) == fold_count(shape)


def test_prominence_is_the_least_depth():
    points, circle = flower(9, 0.03, 1800), ellipse(1, 1)
    assert fold_count(points, reference=circle, prominence=0.0599) == 9
    assert fold_count(points, reference=circle, prominence=0.0601) == 0


@pytest.mark.parametrize("options", [{}, {"smoothing": 0.0}])
def test_the_default_least_depth_is_a_fifth_of_the_thickness(options):
    points, circle = flower(9, 0.03, 1800), ellipse(1, 1, 1800)
    below = find_folds(points, reference=circle, thickness=0.0599 / 0.2, **options)
    above = find_folds(points, reference=circle, thickness=0.0601 / 0.2, **options)
    assert (below.count, above.count) == (9, 0)
    assert above.prominence == pytest.approx(0.0601)
    assert above.smoothing == pytest.approx(0.0601 / 0.2 / 4 if not options else 0.0)


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_ripples_that_do_not_show_in_the_index_are_no_folds(arc):
    """Ten ripples along a half circle, r = 1 + a cos(20 t), concave for a > 1/400, index below 1.005."""
    for amplitude in (0.003, 0.006, 0.01):
        points = flower(20, amplitude, 4000, arc)
        assert gyrification_index(points) < 1.005
        assert fold_count(points) == fold_count(points, thickness=1 / 16) == 0
    # deeper ones, at the same places, are
    assert fold_count(flower(20, 0.03, 4000, arc)) == (20 if arc > 6 else 10)


def test_sulci_shorter_than_the_smoothing_are_not_counted():
    """Slots 0.02 wide and 0.3 deep in a slab, 0.6 of arc each: an average over 0.3 levels them."""
    points = comb(8, 0.3, 0.02, 0.3)
    kept = find_folds(points, smoothing=0.05)
    assert kept.count == 7
    np.testing.assert_allclose(kept.depths, 0.3, rtol=1e-9)  # measured on the curve as given
    assert find_folds(points, smoothing=0.5).count == 0


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("height", [1.0, 0.6])
@pytest.mark.parametrize("size", [1 / 10.3, 1 / 24, 1 / 40, 1 / 50.3])
def test_stairs_of_voxels_are_no_folds(size, height, diagonal):
    """A disc or an ellipse of voxels has none; waves deeper than two voxels are all found."""
    smooth = voxels(lambda x, y: np.hypot(x, y / height) < 1, size, 1.2, diagonal)
    assert fold_count(smooth) == 0
    assert fold_count(smooth, thickness=1 / 16) == 0
    turned = moved(smooth, 0.7, 0.04, (0.1, 0.3)).astype(np.float32)  # as a scanner stores it
    assert fold_count(turned) == 0
    assert gyrification_index(smooth) > 1.02
    assert gyrification_index(smooth, smoothing=2 * size) < 1.005
    folded = voxels(
        lambda x, y: np.hypot(x, y / height) < 1 + 0.2 * np.cos(5 * np.arctan2(y, x)), size, 1.5, diagonal
    )
    if size < 0.05:
        assert fold_count(folded) == 5


@pytest.mark.parametrize("slot", [0.3, 0.05])
def test_the_depth_below_the_hull_is_that_of_the_slots_floor(slot):
    """The floors of a comb's slots lie 0.7 below its top; the middle finger is 0.2 shorter."""
    points = comb(3, 0.4, slot, 0.7, step=0.02)
    short = np.abs(points[0] - (0.6 + slot)) < 0.2 + slot / 4
    points[1, short & (points[1] > 0.5)] = 0.5
    points = np.delete(points, np.flatnonzero(np.hypot(*np.diff(points, axis=1)) < 1e-9), axis=1)
    folds = find_folds(points)
    assert folds.count == 2
    np.testing.assert_allclose(folds.hull_depths, 0.7, atol=1e-9)
    np.testing.assert_allclose(folds.depths, 0.7 - 0.2 / 2, atol=1e-9)  # below the mean of 0.7 and 0.5


def test_shallow_and_deep_folds_side_by_side():
    """A fold of half the depth and half the length between two deep ones is one more fold."""
    theta = angles(2400)
    r = 1 + 0.1 * np.cos(6 * theta) + 0.1 * np.cos(12 * theta)
    # r has crests at cos 6t = 1 (1.2) and -1 (1.0), and floors where cos 6t = -1/4 (0.8875)
    points = r * np.stack((np.cos(theta), np.sin(theta)))
    circle = ellipse(1, 1)
    folds = find_folds(points, reference=circle)
    assert folds.count == 12
    np.testing.assert_allclose(folds.depths, (1.2 + 1.0) / 2 - 0.8875, rtol=1e-3)
    assert fold_count(points, reference=circle, prominence=0.12) == 6


def test_fold_height_is_the_radial_position():
    np.testing.assert_allclose(
        fold_height(flower(9, 0.2), reference=ellipse(1, 1, 5000)), 0.2 * np.cos(9 * angles(1200)), atol=1e-6
    )


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
@pytest.mark.parametrize("amplitude", [0.02, 0.1])
def test_spectrum_has_one_line_at_the_spacing_of_the_crests(arc, amplitude):
    points = flower(20, amplitude, arc=arc)
    waves, part = wavelength_spectrum(points, reference=ellipse(1, 1, arc=arc))
    assert part.sum() == pytest.approx(1, rel=1e-9)
    k = int(part.argmax())
    assert k + 1 == 20
    assert part[k] > 0.95
    assert waves[k] == pytest.approx(as_polyline(points).outer.length / (20 if arc > 6 else 10))
    assert not wavelength_spectrum(ellipse(1, 1), reference=ellipse(1, 1))[1].any()


@steady
@given(
    lobes=st.integers(4, 20),
    amplitude=st.floats(0.1, 0.3),
    angle=st.floats(-4, 4),
    scale=st.floats(1e-3, 1e3),
    x=st.floats(-10, 10),
    start=st.integers(0, 899),
    backwards=st.booleans(),
)
def test_place_turn_scale_start_and_direction_do_not_matter(
    lobes, amplitude, angle, scale, x, start, backwards
):
    points = flower(lobes, amplitude, 900)
    other = np.roll(moved(points, angle, scale, (x * scale, -x * scale)), start, axis=1)
    other = other[:, ::-1] if backwards else other
    a, b = find_folds(points), find_folds(other)
    assert a.count == b.count == lobes
    np.testing.assert_allclose(np.sort(b.depths), scale * np.sort(a.depths), rtol=1e-6)
    np.testing.assert_allclose(b.width, scale * a.width, rtol=1e-6)


@pytest.mark.parametrize("shape", [lambda n: flower(12, 0.1, n), lambda n: mushrooms(8, 0.2, n)])
def test_resampling_changes_less_than_one_per_cent(shape):
    coarse, fine = find_folds(shape(700)), find_folds(shape(2300))
    assert coarse.count == fine.count
    assert coarse.depth == pytest.approx(fine.depth, rel=0.01)
    assert coarse.width == pytest.approx(fine.width, rel=0.01)
