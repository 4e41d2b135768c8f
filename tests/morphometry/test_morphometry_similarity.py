"""Similarity, the map between arcs, alignment, Fourier descriptors and comparison."""
import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from morphometry_shapes import angles, comb, ellipse, flower, moved, mushrooms

from turingfold.morphometry.compare import compare, draw_comparison
from turingfold.morphometry.fourier import fourier_descriptors, reconstruction_error
from turingfold.morphometry.polyline import as_polyline
from turingfold.morphometry.similarity import aligned, arc_length_map, similarity

steady = settings(derandomize=True, deadline=None, max_examples=20)
EVERY_P = (1, 2, np.inf)


@pytest.mark.parametrize("p", EVERY_P)
@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_similarity_of_two_circles(p, arc):
    """With T = 1 the index is 1/2 on radius 1 and (2/pi) atan(1/3) on radius 3, everywhere."""
    expected = 1 - abs(0.5 - 2 / np.pi * np.arctan(1 / 3)) / 2
    found = similarity(ellipse(1, 1, arc=arc), ellipse(3, 3, arc=arc), p, thickness=1.0)
    assert found == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("p", [1, 2])
def test_similarity_of_a_wave_and_a_circle(p):
    """A small wave has the index of the circle plus c cos(n t); the mean of |c cos|^p is known."""
    n, a, T = 6, 1e-3, 0.02
    weight = np.sinc(n * T / 4 / np.pi) ** 2  # the triangle of half width T/2 acting on cos(n t)
    c = 2 / np.pi * T / (1 + T**2) * a * (n**2 - 1) * weight
    mean = {1: 2 / np.pi, 2: np.sqrt(0.5)}[p]
    found = similarity(ellipse(1, 1, 3000), flower(n, a, 3000), p, thickness=T)
    assert 1 - found == pytest.approx(c * mean / 2, rel=0.01)


@steady
@given(lobes=st.integers(3, 15), amplitude=st.floats(0.05, 0.3), angle=st.floats(-4, 4), arc=st.booleans(),
       scale=st.floats(1e-3, 1e3), start=st.integers(0, 899), backwards=st.booleans())
def test_a_moved_copy_is_similar(lobes, amplitude, angle, arc, scale, start, backwards):
    points = flower(lobes, amplitude, 900, np.pi if arc else 2 * np.pi)
    copy = moved(points, angle, scale, (scale, 2 * scale))
    copy = copy if arc else np.roll(copy, start, axis=1)
    copy = copy[:, ::-1] if backwards else copy
    for p in EVERY_P:
        assert similarity(points, copy, p) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_resampling_keeps_similarity(arc):
    for p in EVERY_P:
        assert similarity(mushrooms(8, 0.2, 700, arc), mushrooms(8, 0.2, 2300, arc), p) > 0.99


@pytest.mark.parametrize("start", [3, 7, 10])
def test_outlines_are_matched_between_samples(start):
    """Begun a part of a sample later (20 points are one), the same outline is as similar to itself."""
    points = flower(12, 0.1, 4000)
    assert similarity(points, np.roll(points, start, axis=1), np.inf, samples=200) > 0.99


@steady
@given(lobes=st.integers(2, 9), a=st.floats(0, 0.3), b=st.floats(0, 0.3), height=st.floats(0.5, 1))
def test_similarity_lies_in_its_bounds_and_falls_with_p(lobes, a, b, height):
    one, other = flower(lobes, a, 400), flower(lobes + 3, b, 400, height=height)
    s = [similarity(one, other, p) for p in EVERY_P]
    assert 1 >= s[0] >= s[1] - 1e-12
    assert s[1] >= s[2] - 1e-12
    assert s[2] >= 0
    # exchanged, the outlines are compared at the same pairs of points up to half a sample
    assert similarity(other, one, 1) == pytest.approx(s[0], abs=2e-3)


def test_one_landmark_on_an_open_curve_pulls_like_springs_in_parallel():
    """d = weight e / (weight + 1/a + 1/(1 - a)): two springs to the ends against one to the landmark."""
    points = ellipse(1, 1, 101, np.pi)
    s, there = arc_length_map(points, points, [[40, 60]], samples=101)
    stretch = 10 * 0.2 / (10 + 1 / 0.4 + 1 / 0.6)
    np.testing.assert_allclose(there, np.interp(s, [0, 0.4, 1], [0, 0.4 + stretch, 1]), atol=1e-12)


@pytest.mark.parametrize("step", [1, -1])
def test_one_landmark_on_outlines_turns_the_arc(step):
    points = ellipse(1, 1, 100)
    other = points[:, ::step]
    k = 70
    s, there = arc_length_map(points, other, [[20, k]], samples=100)
    shift = (there - s)[0]
    np.testing.assert_allclose(there, s + shift, atol=1e-12)
    matched = (0.2 + shift) * 100
    assert matched == pytest.approx(round(matched), abs=1e-9)
    counter_clockwise = other[:, ::step]
    np.testing.assert_array_equal(counter_clockwise[:, round(matched) % 100], other[:, k])


@steady
@given(data=st.data(), weight=st.floats(0.1, 1e6), closed=st.booleans())
def test_the_map_increases_and_meets_heavy_landmarks(data, weight, closed):
    points = ellipse(1, 1, 200, 2 * np.pi if closed else np.pi)
    pick = st.lists(st.integers(1, 198), min_size=4, max_size=4, unique=True).map(sorted)
    marks = np.transpose([data.draw(pick), data.draw(pick)])
    s, there = arc_length_map(points, points, marks, weight=weight, samples=997)
    assert (np.diff(there) > 0).all()
    if closed:
        assert there[-1] < there[0] + 1
    s, there = arc_length_map(points, points, marks, weight=1e9, samples=997)
    whole = 200 if closed else 199
    # between landmarks the map is linear: at a landmark the nearest sample is half a step of it away
    steepest = np.diff(there).max()
    at = np.interp(marks[:, 0] / whole, s, there) - marks[:, 1] / whole
    np.testing.assert_allclose(at - np.round(at), 0, atol=steepest + 1e-4)


@pytest.mark.parametrize("landmarks", [
    [[20, 10], [40, 30], [60, 20]], [[20, 30], [20, 40]], [[20, 30], [40, 30]],
])
def test_landmarks_out_of_order_are_refused(landmarks):
    with pytest.raises(ValueError, match="repeated or not in the same order"):
        similarity(ellipse(1, 1, 100), ellipse(1, 1, 100), landmarks=landmarks)


@pytest.mark.parametrize(("landmarks", "message"), [
    ([20, 30], "it must be .k, 2."),
    ([[0.5, 1.0]], "pairs of point indices"),
    ([[0, 30]], "landmark 0 on points_a must be between 1 and 98; the ends correspond anyway"),
    ([[20, 99]], "landmark 99 on points_b must be between 1 and 98"),
])
def test_landmarks_outside_are_refused(landmarks, message):
    arc = ellipse(1, 1, 100, np.pi)
    with pytest.raises(ValueError, match=message):
        arc_length_map(arc, arc, landmarks)


def test_landmarks_make_a_displaced_fold_match():
    """One fold at a third and at half of the arc: alike when the folds are matched."""
    def folded(at):
        theta = angles(1500, np.pi)
        return (1 - 0.2 * np.exp(-(((theta - at) / 0.1) ** 2))) * np.array([np.cos(theta), np.sin(theta)])

    a, b = folded(np.pi / 3), folded(np.pi / 2)
    matched = similarity(a, b, 2, landmarks=[[500, 750]], weight=1e6)
    assert 1 - matched < 0.5 * (1 - similarity(a, b, 2))


@steady
@given(angle=st.floats(-3, 3), scale=st.floats(0.1, 10), start=st.integers(0, 899), closed=st.booleans())
def test_alignment_undoes_a_motion(angle, scale, start, closed):
    points = comb(3, 0.4, 0.2, 0.8, step=0.02) if closed else mushrooms(6, 0.2, 900, 3.0)
    copy = moved(points, angle, scale, (3.0, -7.0))
    other = np.roll(copy, start, axis=1) if closed else copy[:, ::-1]
    a, b = aligned(points, other, scale=True, samples=2000)
    assert np.hypot(*(a - b)).max() < 0.01
    a, b = aligned(points, moved(points, angle), scale=False)
    np.testing.assert_allclose(a, b, atol=1e-6)


def test_descriptors_of_a_circle():
    found = fourier_descriptors(moved(ellipse(2, 2, 2000), shift=(3, -1)), 6)
    np.testing.assert_allclose(found.centre, [3, -1], atol=1e-12)
    np.testing.assert_allclose(found.matrices[0], [[2, 0], [0, 2]], atol=1e-5)
    np.testing.assert_allclose(found.amplitudes[1:], 0, atol=1e-12)


def test_descriptors_are_the_integrals_over_the_polyline():
    points = moved(flower(5, 0.3, 200, height=0.7), shift=(0.4, 0.1))
    curve = as_polyline(points)
    s = (np.arange(400_000) + 0.5) / 400_000
    ring = np.hstack((points, points[:, :1]))
    x = np.array([np.interp(s * curve.length, np.append(curve.arc, curve.length), row) for row in ring])
    found = fourier_descriptors(points, 7)
    np.testing.assert_allclose(found.centre, x.mean(axis=1), atol=1e-9)
    for k, matrix in enumerate(found.matrices, start=1):
        expected = [[2 * np.mean(row * wave(2 * np.pi * k * s)) for wave in (np.cos, np.sin)] for row in x]
        np.testing.assert_allclose(matrix, expected, atol=1e-9)


def test_reconstruction_error_of_a_small_wave():
    """r = 1 + a cos(n t) is lost below order n - 1: a along r and a/n along the arc, times sqrt(1/2)."""
    n, a = 12, 1e-3
    points = flower(n, a, 4000)
    expected = a / np.sqrt(2) * np.sqrt(1 + 1 / n**2)
    assert reconstruction_error(points, 5) == pytest.approx(expected, rel=0.01)
    assert reconstruction_error(points, 15) < 0.02 * expected


@pytest.mark.parametrize("points", [
    mushrooms(6, 0.2, 2000), mushrooms(6, 0.2, 1000, np.pi), comb(4, 0.3, 0.2, 0.5),
])
def test_reconstruction_improves_with_order(points):
    errors = [reconstruction_error(points, order) for order in (5, 15, 25, 200)]
    assert (np.diff(errors) < 0).all()
    assert errors[-1] < 0.01


@steady
@given(angle=st.floats(-4, 4), scale=st.floats(0.01, 99), start=st.integers(0, 999), n=st.integers(700, 2000))
def test_amplitudes_do_not_depend_on_placing_or_sampling(angle, scale, start, n):
    points = flower(5, 0.3, 1000, height=0.8)
    other = moved(flower(5, 0.3, n, height=0.8), angle, scale, (scale, 0))
    other = np.roll(other, start, axis=1)[:, ::-1]
    expected = fourier_descriptors(points, 15).amplitudes
    np.testing.assert_allclose(fourier_descriptors(other, 15).amplitudes, expected, atol=1e-4)
    assert reconstruction_error(other, 15) == pytest.approx(reconstruction_error(points, 15), rel=0.01)


def test_comparison_holds_the_measures_of_both():
    a, b = flower(6, 0.2), 2 * flower(12, 0.2)
    both = compare(a, b, names=("six", "twelve"), unit="mm")
    assert (both["folds"].a, both["folds"].b, both["folds"].ratio) == (6, 12, 2)
    assert both["length of the outer path"].ratio == pytest.approx(2, rel=0.05)
    assert both["self-intersections"].a == 0
    assert np.isnan(both["self-intersections"].ratio)
    assert both.similarity["1"] == similarity(a, b, 1)
    lines = both.text().splitlines()
    assert len({len(line) for line in lines[:-1]}) == 1
    assert lines[0].split() == ["six", "twelve", "twelve", "/", "six"]
    assert any(line.split() == ["folds", "6", "12", "2.000"] for line in lines)
    assert lines[-1].startswith("similarity")
    with pytest.raises(KeyError, match="known are 'length'"):
        both["sulci"]


@pytest.mark.parametrize("other", [flower(6, 0.2), ellipse(2, 1)])
def test_a_curve_without_gyri_has_no_gyral_width(other):
    both = compare(ellipse(1, 1), other)
    widths = both["mean gyral width"]
    assert np.isnan([widths.a, widths.ratio]).all()
    assert np.isnan(widths.b) == (both["folds"].b == 0)
    (row,) = (line.split() for line in both.text().splitlines() if line.startswith("mean gyral width"))
    assert (row[-3], row[-1]) == ("-", "-")
    assert (row[-2] == "-") == (both["folds"].b == 0)


def test_comparison_of_pial_surfaces_and_of_coarse_outlines():
    pial = compare(ellipse(1, 1, arc=np.pi), flower(20, 0.1, arc=np.pi))
    assert (pial["folds"].a, pial["folds"].b) == (0, 10)
    assert np.isnan(pial["mean sulcal depth"].ratio)
    assert "nan" not in pial.text()
    (waves,) = (line.split() for line in pial.text().splitlines() if line.startswith("main wave length"))
    assert (waves[-3], waves[-1]) == ("-", "-")  # a smooth arc has no waves, and nothing is a multiple of it
    coarse = compare(ellipse(1, 1, 20), ellipse(1, 1, 200))
    names = [measure.name for measure in coarse.measures]
    assert "Fourier error at order 5" in names
    assert "Fourier error at order 15" not in names


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_drawing_lays_one_on_the_other(arc):
    a = mushrooms(8, 0.2, arc=arc)
    figure, axes = plt.subplots()
    draw_comparison(a, moved(a, 1.0, 3.0, (5, 5)), axes, names=("left", "right"), scale=True)
    left, right = (line.get_xydata() for line in axes.lines)
    np.testing.assert_allclose(left, right, atol=1e-6)
    closed = np.allclose(left[0], left[-1])
    assert closed == (arc > 6)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    count = 8 if arc > 6 else 4
    assert labels[1].startswith("right")
    assert labels[1].endswith(f"{count} folds")
    figure.canvas.draw()
