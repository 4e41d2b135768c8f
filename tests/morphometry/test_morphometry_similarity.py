"""Similarity, the map between arcs, alignment, Fourier descriptors and comparison."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from morphometry_shapes import angles, comb, ellipse, flower, moved, mushrooms

from turingfold.morphometry.compare import compare, draw_comparison
from turingfold.morphometry.fourier import fourier_descriptors, reconstruction_error
from turingfold.morphometry.landmarks import read_landmarks
from turingfold.morphometry.polyline import InnerWall, as_polyline
from turingfold.morphometry.shape import signed_curvature
from turingfold.morphometry.similarity import aligned, arc_length_map, similarity, similarity_null

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
@given(
    lobes=st.integers(3, 15),
    amplitude=st.floats(0.05, 0.3),
    angle=st.floats(-4, 4),
    arc=st.booleans(),
    scale=st.floats(1e-3, 1e3),
    start=st.integers(0, 899),
    backwards=st.booleans(),
)
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


@pytest.mark.parametrize(
    "landmarks",
    [
        [[20, 10], [40, 30], [60, 20]],
        [[20, 30], [20, 40]],
        [[20, 30], [40, 30]],
    ],
)
def test_landmarks_out_of_order_are_refused(landmarks):
    with pytest.raises(ValueError, match="repeated or not in the same order"):
        similarity(ellipse(1, 1, 100), ellipse(1, 1, 100), landmarks=landmarks)


@pytest.mark.parametrize(
    ("landmarks", "message"),
    [
        ([20, 30], "it must be .k, 2."),
        ([[0.5, 1.0]], "pairs of point indices"),
        ([[0, 30]], "landmark 0 on points_a must be between 1 and 98; the ends correspond anyway"),
        ([[20, 99]], "landmark 99 on points_b must be between 1 and 98"),
    ],
)
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


@pytest.mark.parametrize(
    "points",
    [
        mushrooms(6, 0.2, 2000),
        mushrooms(6, 0.2, 1000, np.pi),
        comb(4, 0.3, 0.2, 0.5),
    ],
)
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
    lines, words = lines[:-2], " ".join(lines[-2:])
    assert "p: which mean of the differences counts (1: mean, 2: root mean square, inf: largest)" in words
    assert len({len(line) for line in lines[:-3]}) == 1
    assert lines[0].split() == ["six", "twelve", "twelve", "/", "six"]
    assert any(line.split() == ["folds", "6", "12", "2.000"] for line in lines)
    for line, p in zip(lines[-3:], (1, 2, np.inf), strict=True):
        assert line == f"similarity, p = {p}  {similarity_null(a, b, p)}"
    long = compare(a, b, names=("six", "a/folder/of/twelve"), unit="mm").text().splitlines()
    assert long[:2] == ["A: six", "B: a/folder/of/twelve"]
    assert long[2].split() == ["A", "B", "B", "/", "A"]
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
    assert names.count("mean sulcal depth") == 1
    relative = compare(flower(6, 0.2), flower(12, 0.2), thickness=0.1).measures
    depths = [measure for measure in relative if measure.name == "mean sulcal depth"]
    assert [measure.unit for measure in depths] == ["m", "thickness"]
    assert depths[0].a == pytest.approx(0.1 * depths[1].a)
    assert "Fourier error at order 5" in names
    assert "Fourier error at order 15" not in names


def test_walls_with_the_body_outside_are_compared_without_a_closing():
    both = compare(flower(6, 0.2).view(InnerWall), flower(8, 0.2).view(InnerWall))
    assert np.isnan(both["gyrification index, closing"].a)
    assert (both["folds"].a, both["folds"].b) == (6, 8)


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


def irregular(seed, n=3000):
    """Twelve folds of different depth at different distances round a circle."""
    rng = np.random.default_rng(seed)
    t = angles(n)
    bends = t + sum(0.25 / k * np.cos(k * t + rng.uniform(0, 7)) for k in (1, 2, 3))
    depth = 0.12 + 0.06 * np.cos(2 * t + rng.uniform(0, 7))
    return (1 + depth * np.cos(12 * bends)) * np.array([np.cos(t), np.sin(t)])


def test_irregular_folds_are_like_themselves_and_not_by_chance():
    a = irregular(1)
    null = similarity_null(a, moved(a, 1.0, 2.0), 1)
    assert null.value == pytest.approx(1, abs=1e-3)
    assert null.foldings.p == 0
    assert max(null.circle, null.foldings.quantile(1.0)) < 0.95
    assert null.value == similarity(a, moved(a, 1.0, 2.0), 1)


def test_foldings_that_know_nothing_of_each_other_are_alike_by_chance():
    found = [similarity_null(irregular(k), irregular(100 + k), 1, count=39).foldings.p for k in range(8)]
    assert np.mean(found) > 0.1
    assert max(found) > 0.5


def test_regular_folds_of_one_wave_length_can_always_be_matched():
    null = similarity_null(flower(12, 0.1, 2400), flower(12, 0.1, 2400), 2)
    assert null.foldings.quantile(0.5) > 0.98


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
def test_the_best_circle_has_the_mean_the_median_or_the_middle_of_the_shape_index(arc):
    """Of a wave with curvature (far from the average's width): the constants nearest to it are known."""
    a, T = flower(5, 0.15, 6000, arc), 0.05
    index = 2 / np.pi * np.arctan(T * signed_curvature(a))
    at = as_polyline(a).arc / as_polyline(a).length
    even = np.interp(np.linspace(0, 1, 5000, endpoint=arc < 6), at, index)
    nearest = {1: np.median(even), 2: even.mean(), np.inf: (even.max() + even.min()) / 2}
    for p, constant in nearest.items():
        away = np.abs(even - max(constant, 0.0))
        norm = away.max() if p == np.inf else np.mean(away**p) ** (1 / p)
        found = similarity_null(a, ellipse(1, 1, 500, arc), p, thickness=T, count=19).circle
        assert found == pytest.approx(1 - norm / 2, abs=2e-3)


def test_the_better_of_two_starts_counts_and_the_verdict_is_told():
    a, b, circle = irregular(3), irregular(7), ellipse(1, 1)
    null = similarity_null(a, b, 1, starts=(None, circle))
    assert null.start == similarity(a, circle, 1)
    both = similarity_null(a, b, 1, starts=(ellipse(1, 0.8), circle))
    assert both.start == max(similarity(b, ellipse(1, 0.8), 1), similarity(a, circle, 1))
    assert null.value < null.start  # folds at the wrong places are less like a than none
    assert "less than before it grew" in str(null)
    assert str(similarity_null(a, a)).endswith(")")


LANDMARKS = "name,x_a,y_a,x_b,y_b\n"


def test_landmarks_are_read_and_told(tmp_path):
    a, b = flower(6, 0.2, 600), moved(flower(6, 0.2, 900), 0.0, 2.0)
    file = tmp_path / "marks.csv"
    file.write_text(LANDMARKS + f"first,{a[0, 100]},{a[1, 100]},{b[0, 150]},{b[1, 150]}\n"
                    f"second, {a[0, 300] + 1e-3},{a[1, 300]},{b[0, 460]},{b[1, 460]}\n")  # fmt: skip
    marks = read_landmarks(file, a, b)
    np.testing.assert_array_equal(marks.indices, [[100, 150], [300, 460]])
    both = compare(a, b, landmarks=marks)
    assert both.similarity["2"] == similarity(a, b, 2, landmarks=[[100, 150], [300, 460]])
    assert both.landmarks[0] == ("first", pytest.approx(1 / 6, abs=1e-6), pytest.approx(1 / 6, abs=1e-6))
    assert "landmark second: at 0.500 and 0.51" in both.text()


@pytest.mark.parametrize("unit", [" (mm)", " [mm]", "_mm", "/mm", " (cm)"])
def test_the_header_of_landmarks_may_state_their_unit(tmp_path, unit):
    a, b = flower(6, 0.2, 600), moved(flower(6, 0.2, 900), 0.0, 2.0)  # m
    per_m = 100 if "cm" in unit else 1000
    file = tmp_path / "marks.csv"
    header = ",".join(["name", *(f"{name}{unit}" for name in ("x_a", "y_a", "x_b", "y_b"))])
    places = ",".join(repr(per_m * float(x)) for x in (*a[:, 100], *b[:, 150]))
    file.write_text(f"{header}\nfirst,{places}\n")
    np.testing.assert_array_equal(read_landmarks(file, a, b).indices, [[100, 150]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LANDMARKS.replace("x_b", "x_b (ell)"), "column x_a has no unit, others have one; give all four"),
        ("name,x_a (mm),y_a (mm),x_b (ell),y_b (mm)\n", "column x_b has unit 'ell'; give all four one of m"),
        ("name,x_a,y_a,x_b,y_b,z_b\n", "first line is 'name,x_a,y_a,x_b,y_b,z_b'"),
        ("name;x_a\n", "first line is 'name;x_a'; it must be 'name,x_a,y_a,x_b,y_b'"),
        (LANDMARKS, "has no landmarks"),
        (LANDMARKS + "one,1,0,1,0\none,0,1,0,1\n", "line 2: the name 'one' must be there, and only once"),
        (LANDMARKS + "one,1,0,1\n", r"line 2: x_b, y_b are \('1', ''\); give two numbers"),
        (LANDMARKS + "one,1,5,0,5,1,5,0,5\n", "line 2: 9 fields, where the header has 5; if commas are"),
        (LANDMARKS + "zero,1,0,1,0,,\none,1,0,1,0,2\n", "line 3: 6 fields"),
        (LANDMARKS + "one,1,0,nan,0\n", "line 2: x_b, y_b are nan from the nearest"),
        (LANDMARKS + "one,1000,0,1,0\n", "x_a, y_a are 999 from the nearest point of curve a.*in its unit"),
    ],
)
def test_bad_landmarks_are_refused(tmp_path, text, message):
    file = tmp_path / "marks.csv"
    file.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_landmarks(file, ellipse(1, 1), ellipse(1, 1))
