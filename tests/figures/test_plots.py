"""Pictures: what is on the axes, in which units, and that every option draws."""

import io
import warnings
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from small import elastic_scene

from turingfold import (
    AxonalTension,
    OutlineWarning,
    TangentialGrowth,
    animate,
    figures,
    half,
    outline,
    semicircle,
    simulate,
)
from turingfold.figures.style import at_nodes, colour_limits, compact, per_length, round_length, sulci
from turingfold.results.result import Result
from turingfold.state import State


@pytest.fixture
def figure():
    return Figure()


@pytest.fixture(scope="module")
def disc():
    """A free body with a closed pial surface, a circle of radius 1."""
    angle = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    return outline(np.stack([np.cos(angle), np.sin(angle)]), thickness=0.25, size=0.2)


def titles(figure):
    return [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]


def drawn(figure):
    figure.draw_without_rendering()
    return [axes for axes in figure.axes if axes.axison is False]


@pytest.mark.parametrize("field", ["von_mises", "pressure", "jacobian"])
def test_a_section_is_the_deformed_body_in_mm(folded, figure, field):
    axes = figure.add_subplot()
    colors = figures.section(axes, folded, field=field)
    drawn(figure)
    x, _ = 1e3 * (folded.scene.body.nodes + folded.last["displacement"])
    low, high = axes.dataLim.intervalx
    assert low == pytest.approx(x.min(), rel=1e-9)
    assert high == pytest.approx(x.max(), rel=1e-9)
    assert colors.norm.vmin < colors.norm.vmax
    bar = figure.axes[-1]
    assert ("kPa" in bar.get_ylabel()) == (field != "jacobian")


@pytest.mark.parametrize("field", ["von_mises", "pressure"])
def test_stresses_without_unit_are_shown_in_units_of_the_moduli(figure, field):
    scene = elastic_scene()  # μ = 1
    result = simulate(scene)
    colors = figures.section(figure.add_subplot(), result, field=field)
    assert figure.axes[-1].get_ylabel().endswith("stress (in units of the moduli)") == (field == "von_mises")
    assert "Pa" not in figure.axes[-1].get_ylabel()
    values, weights = result.observe()[field], scene.body.quadrature.weights
    limits = colour_limits(values, weights, centred=field == "pressure")
    assert (colors.norm.vmin, colors.norm.vmax) == pytest.approx(limits)
    for _ in figures.section_grid(Figure(), 1, 1, {"one": result}):
        pass
    pull = AxonalTension(strength=0.1, patches=4)
    axes = figure.add_subplot()
    figures.load_arrows(axes, scene, result.last, pull)
    assert "N/m" not in axes.texts[0].get_text()


def test_one_sulcus_is_not_several():
    assert [sulci(count) for count in (0, 1, 2)] == ["0 sulci", "1 sulcus", "2 sulci"]


def test_a_compact_picture_is_a_third_as_large_and_looks_the_same(folded, figure):
    from PIL import Image

    figures.section(figure.add_subplot(), folded)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=200)
    before = file.getvalue()
    after = compact(before)
    assert len(after) < 0.5 * len(before)
    seen = [Image.open(io.BytesIO(picture)) for picture in (before, after)]
    assert seen[0].size == seen[1].size
    assert seen[0].info["dpi"] == pytest.approx(seen[1].info["dpi"])
    one, other = (np.asarray(image.convert("RGB"), dtype=float) for image in seen)
    difference = np.abs(one - other).max(axis=2)
    assert difference.mean() < 1.0  # of 255
    assert np.percentile(difference, 99) < 16.0


def test_an_unknown_field_is_refused(folded, figure):
    with pytest.raises(ValueError, match="field='stress' must be one of 'von_mises'"):
        figures.section(figure.add_subplot(), folded, field="stress")


def test_the_scale_bar_is_as_long_as_it_says(folded, figure):
    axes = figure.add_subplot()
    figures.scale_bar(axes, folded.scene.body)
    (line,), (text,) = axes.lines, axes.texts
    assert np.ptp(line.get_xdata()) == pytest.approx(float(text.get_text().removesuffix(" mm")))


def test_the_scale_bar_of_a_body_in_units_of_its_own_is_in_thicknesses(figure):
    # a fifth of the width 2 is 1.6 thicknesses of 0.25: the bar has one
    axes = figure.add_subplot()
    figures.scale_bar(axes, semicircle(radius=1.0, thickness=0.25, size=0.25))
    (line,), (text,) = axes.lines, axes.texts
    assert text.get_text() == "1 T"
    assert np.ptp(line.get_xdata()) == pytest.approx(1e3 * 0.25)


@pytest.mark.parametrize(("length", "rounded"), [(16.16, 10), (0.2, 0.2), (7.0, 5), (99.0, 50), (3e-3, 2e-3)])
def test_lengths_are_rounded_down(length, rounded):
    assert round_length(length) == pytest.approx(rounded)


def test_peaks_stand_where_the_activator_is_largest(folded, figure):
    axes = figure.add_subplot()
    figures.peaks(axes, folded)
    (line,) = axes.lines
    # eight half waves with a peak in the middle: three peaks, and half a peak at each end
    assert len(line.get_xdata()) == 5
    pattern, points = folded.pattern(), 1e3 * folded.pial()
    at = [int(np.argmin(np.hypot(*(points.T - peak).T))) for peak in np.transpose(line.get_data())]
    assert pattern[at].min() > 0.9
    figures.peaks(axes, simulate(elastic_scene()))
    assert len(axes.lines) == 1  # nothing without a pattern


@pytest.mark.parametrize("term", [AxonalTension(strength=0.5), None], ids=["given", "of the scene"])
def test_the_whole_story_has_four_panels(folded, figure, term):
    figures.folding(figure, folded, term=term)
    story = titles(figure)
    assert [title[5] for title in story] == list("abcd")
    summary = folded.summary()
    assert f"{summary['folds']} sulci" in story[3]
    assert f"registration {summary['registration']:+.2f}" in story[3]


@pytest.mark.parametrize(
    ("term", "panels"),
    [
        (None, ["pial surface", "growth"]),
        (AxonalTension(strength=0.1), ["pial surface", "growth"]),  # follows a pattern that is not there
        (AxonalTension(strength=0.1, patches=4), ["load of the tension", "pial surface", "growth"]),
    ],
)
@pytest.mark.parametrize("closed", [False, True])
def test_a_story_without_pattern_has_the_panels_there_is_something_for(figure, disc, term, panels, closed):
    result = simulate(elastic_scene(body=disc if closed else None))
    figures.folding(figure, result, term=term)
    drawn(figure)
    starts = [f"$\\bf{{{letter}}}$   {panel}" for letter, panel in zip("abc", panels, strict=False)]
    assert [title[: len(start)] for title, start in zip(titles(figure), starts, strict=True)] == starts
    rows = figure.axes[0].get_subplotspec().get_gridspec().nrows
    assert rows == len(panels) - 1  # no room is left empty


def test_a_story_without_load_keeps_the_pattern(folded, figure):
    terms = tuple(term for term in folded.scene.terms if not isinstance(term, AxonalTension))
    figures.folding(figure, replace(folded, scene=replace(folded.scene, terms=terms)))
    assert [title[5:7] for title in titles(figure)] == ["a}", "b}", "c}"]
    assert "activator" in titles(figure)[0]
    assert "load" not in "".join(titles(figure))


def test_load_arrows_show_the_force_per_length():
    # a path of length 2 with the force 3 per length along x, as nodes of quadratic edges carry it
    edges = 40
    points = np.stack([np.linspace(0, 2, 2 * edges + 1), np.zeros(2 * edges + 1)])
    forces = np.zeros_like(points)
    for k in range(edges):
        forces[0, 2 * k : 2 * k + 3] += 3 * (2 / edges) * np.array([1, 4, 1]) / 6
    at, load = per_length(points, forces, count=10)
    assert at.shape == load.shape == (2, 10)
    np.testing.assert_allclose(load[0, 1:-1], 3.0, rtol=1e-12)
    np.testing.assert_allclose(at[0], np.linspace(0.1, 1.9, 10), rtol=1e-12)


def test_load_arrows_on_a_closed_path_have_no_ends():
    # around a square with sides of 1, the force (3, 2) per length on every edge
    edges, side = 40, np.arange(20) / 20
    zero, one = np.zeros(20), np.ones(20)
    points = np.stack(
        [np.concatenate([side, one, 1 - side, zero]), np.concatenate([zero, side, one, 1 - side])]
    )
    forces = np.zeros_like(points)
    for k in range(edges):
        at = np.arange(2 * k, 2 * k + 3) % (2 * edges)
        forces[:, at] += (4 / edges) * np.array([[3.0], [2.0]]) * np.array([1, 4, 1]) / 6
    at, load = per_length(points, forces, count=10)
    np.testing.assert_allclose(load, np.array([[3.0], [2.0]]) * np.ones(10), rtol=1e-12)
    assert len(at.T) == 10
    np.testing.assert_allclose(at[:, [0, -1]], [[0.2, 0.0], [0.0, 0.2]], atol=1e-12)


@pytest.mark.parametrize("surface", ["interface", "pial"])
def test_load_arrows_go_all_round_a_closed_body(figure, disc, surface):
    scene, pull = elastic_scene(body=disc), AxonalTension(strength=0.1, surface=surface, patches=3)
    axes = figure.add_subplot()
    figures.load_arrows(axes, scene, State(1.0), pull, count=1000)  # an arrow on each edge
    (arrows,) = axes.collections
    nodes = disc.interface if surface == "interface" else disc.pial
    at, load = arrows.XY.T / 1e3, np.stack([arrows.U, arrows.V])
    assert at.shape == (2, len(nodes) // 2)
    path = disc.nodes[:, np.append(nodes, nodes[0])]
    np.testing.assert_allclose(at, 0.5 * (path[:, :-2:2] + path[:, 2::2]), atol=0.01)
    if surface == "interface":  # no net force
        lengths = np.hypot(*np.diff(path)).reshape(-1, 2).sum(1)
        assert np.abs(load @ lengths).max() < 1e-12 * (np.hypot(*load) @ lengths)
    else:  # along the circle, to and from each of the three patches
        along = (at[0] * load[1] - at[1] * load[0]) / np.hypot(*at)
        across = (at * load).sum(0) / np.hypot(*at)
        assert np.abs(across).max() < 0.05 * np.abs(along).max()
        assert np.count_nonzero(along * np.roll(along, 1) < 0) == 6


def test_closed_surfaces_are_drawn_closed_and_have_no_peak_at_a_seam(figure, disc):
    scene = elastic_scene(body=disc)
    band = disc.nodes[:, disc.cortex.nodes]
    first = disc.nodes[:, disc.pial[0]]
    angle = np.arctan2(band[1], band[0]) - np.arctan2(first[1], first[0])
    pattern = 0.5 + 0.5 * np.cos(5 * angle)  # a peak where the pial nodes begin and end
    rest = {"displacement": np.zeros_like(disc.nodes), "growth": np.ones((2, *disc.quadrature.weights.shape))}
    result = Result(scene, (State(0.0, rest), State(1.0, rest | {"pattern": pattern})), ())
    axes = figure.add_subplot()
    figures.peaks(axes, result)
    assert len(axes.lines[0].get_xdata()) == 5
    figures.outline(axes, disc)
    figures.pial_history(axes, result)
    figures.activator(axes, result)
    assert len(axes.lines) > 3
    for line in axes.lines[1:]:
        x, y = line.get_data()
        assert (x[0], y[0]) == (x[-1], y[-1])


@pytest.mark.parametrize("pull", [AxonalTension(strength=0.0), AxonalTension(strength=0.5, ramp=0.0)])
def test_a_load_that_is_not_there_is_refused(folded, figure, pull):
    # one without strength, and one that follows a pattern the state lacks
    state = folded.last if pull.strength == 0 else State(1.0)
    with pytest.raises(ValueError, match="AxonalTension has no load"):
        figures.load_arrows(figure.add_subplot(), folded.scene, state, pull)


def test_values_that_are_linear_come_out_at_the_nodes(folded):
    body = folded.scene.body
    straight = ~body.in_cortex
    x = body.quadrature.points[0]
    nodes = np.unique(body.triangles[:, straight])
    inner = nodes[np.hypot(*body.nodes[:, nodes]) < 0.6 * body.length]  # sides along the cortex are curved
    np.testing.assert_allclose(at_nodes(body, x, straight)[inner], body.nodes[0, inner], atol=1e-12)


def test_limits_leave_out_one_percent_of_the_area():
    values, weights = np.linspace(0, 100, 10_001), np.ones(10_001)
    assert colour_limits(values, weights, centred=True) == pytest.approx((1.0, 99.0), abs=0.02)
    assert colour_limits(values, weights, centred=False)[0] == 0.0
    low, high = colour_limits(np.ones(5), np.ones(5), centred=True)
    assert low < high


def test_half_a_body_is_drawn_whole(figure):
    body = half(semicircle(radius=1.0, thickness=0.25, size=0.25))
    result = simulate(elastic_scene(body=body))
    axes = figure.add_subplot()
    figures.section(axes, result)
    low, high = axes.dataLim.intervalx
    assert low == pytest.approx(-high)
    figures.pial_history(figure.add_subplot(), result)
    drawn(figure)


def test_panels_share_their_colours(folded, figure):
    seen = []
    for axes, name, result in figures.section_grid(figure, 1, 2, {"one": folded, "two": folded}):
        axes.set_title(name)
        seen.append(result)
    assert seen == [folded, folded]
    drawn(figure)
    assert sum(bool(axes.get_ylabel()) for axes in figure.axes) == 1


@pytest.fixture(scope="module")
def parts():
    """Two discs, one of them with a closed-off sulcus, which grow."""
    angle = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    disc = np.stack([np.cos(angle), np.sin(angle)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutlineWarning)  # of the closed-off sulcus
        body = outline([disc, 0.3 * disc, disc + np.array([[3.0], [0.0]])], thickness=0.25, size=0.2)
    return simulate(elastic_scene(TangentialGrowth(cortex=1.05), body=body))


@pytest.mark.parametrize("draw", [
    figures.before, figures.layers, figures.outline, figures.pial_history, figures.section, figures.tissue,
])  # fmt: skip
def test_every_picture_shows_each_part_of_a_body(parts, figure, draw):
    axes, body = figure.add_subplot(), parts.scene.body
    draw(axes, body if draw in (figures.outline, figures.tissue) else parts)
    unit = 1.0 if draw in (figures.before, figures.layers) else 1e3
    ends = [(line.get_xdata().min() / unit, line.get_xdata().max() / unit) for line in axes.lines]
    for path in body.pial_paths:
        low, high = body.nodes[0, path.nodes].min(), body.nodes[0, path.nodes].max()
        assert any(abs(a - low) < 0.1 and abs(b - high) < 0.1 for a, b in ends), path


def test_panels_and_films_of_several_parts_say_what_the_summary_says(parts, figure, tmp_path):
    told = parts.summary()
    assert figures.numbers(parts).startswith(f"{sulci(told['folds'])}, GI {told['gyrification_index']:.2f}")
    figures.grid(figure, {"parts": (parts, -1)}, columns=1)
    assert animate(replace(parts, states=parts.states[-2:]), tmp_path / "film.gif").stat().st_size > 1000
    figures.folding(figure, parts)
