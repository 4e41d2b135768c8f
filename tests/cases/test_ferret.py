"""The ferret family: retracing, panels, and the directions in which malformations change the folds."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    figures,
    semicircle,
    simulate,
)
from turingfold.cli.case import load_case
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import RateGrowth
from turingfold.morphometry.folds import find_folds, fold_count
from turingfold.morphometry.shape import gyrification_index
from turingfold.morphometry.walls import self_intersections
from turingfold.outlines import outline
from turingfold.outlines.remesh import remeshed
from turingfold.results.result import Result, pial_closed
from turingfold.state import State

CASES = Path(__file__).parents[2] / "cases"
SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))


def brain(thickness, elements):
    return semicircle(radius=1.0, thickness=thickness, elements=elements, base="roller", layers="sigmoid")


def run(case, parameters=None, **changes):
    scenes = load_case(CASES / f"{case}.py").scenes(parameters or {}, quick=False)
    return {name: simulate(replace(scene, **changes)) for name, scene in scenes.items()}


def folds(result):
    body = result.scene.body
    return find_folds(result.pial(), thickness=body.thickness, closed=pial_closed(body))


def index(result):
    return gyrification_index(result.pial(), closed=pial_closed(result.scene.body))


def sulci_at(result):
    """Return the sulci's places as shares of the undeformed surface's length."""
    body = result.scene.body
    return body.pial_arc[folds(result).sulci] / body.pial_curve.length


def area(result):
    body = result.scene.body
    moved = replace(body.mesh, doflocs=body.nodes + result.last["displacement"])
    corners = moved.p[:, moved.t]
    (ux, uy), (vx, vy) = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return 0.5 * float((ux * vy - uy * vx).sum())


def whole(points):
    """Return a half disc's surface with its image in the base, closed."""
    image = points[:, -2:0:-1] * np.array([[1.0], [-1.0]])
    return np.concatenate([points, image], axis=1)


def test_a_quarter_of_the_growth_leaves_the_brain_smooth():
    stepping = Stepping(first=0.1, largest=0.1)
    results = [
        simulate(
            Scene(
                body=brain(0.1, 2),
                terms=(SOLID, SelfContact()),
                processes=(RateGrowth(rate=rate), Imperfection(amplitude=0.02)),
                until=0.4,
                stepping=stepping,
            )
        )
        for rate in (1.9, 1.9 / 4)
    ]
    assert folds(results[0]).count >= 4
    assert folds(results[1]).count == 0
    assert index(results[1]) < 1.001
    assert area(results[1]) < area(results[0])


def test_a_traced_section_keeps_its_shape_but_for_the_inset():
    at = 2 * np.pi * np.arange(200) / 200
    body = outline(np.stack([np.cos(at), np.sin(at)]), thickness=0.1, size=0.05)
    x, y = body.nodes
    moved = State(1.0, {"displacement": np.stack([0.2 * x, 0.1 * x * y])})
    new = remeshed(body, moved, size=0.05, inset=0.01)
    # the map (1.2 x, y + 0.1 x y) has the area 1.2 ∫ (1 + 0.1 x); the inset takes its perimeter times 0.01
    fine = np.linspace(0, 2 * np.pi, 20_001)
    around = np.stack([1.2 * np.cos(fine), np.sin(fine) * (1 + 0.1 * np.cos(fine))])
    length = np.hypot(*np.diff(around)).sum()
    exact = 1.2 * np.pi - 0.01 * length + 0.01**2 * np.pi
    assert new.quadrature.weights.sum() == pytest.approx(exact, rel=1e-4)
    distance = [np.hypot(*(around - p[:, None])).min() for p in new.nodes[:, new.pial].T]
    assert distance == pytest.approx(np.full(len(distance), 0.01), rel=0.05)
    assert new.thickness == 0.1
    assert new.depth.max() > 0.5  # the tangents and depths are those of the new shape


def test_tracing_opens_sulci_that_touch():
    at = 2 * np.pi * np.arange(400) / 400
    radius = 1.0 - 0.4 * np.exp(-(((at - np.pi) / 0.1) ** 2))
    body = outline(radius * np.stack([np.cos(at), np.sin(at)]), thickness=0.1, size=0.05)
    x, y = body.nodes
    # press the two walls of the notch at (-1, 0) together to a tenth of their distance
    near = np.clip((-x - 0.55) / 0.1, 0.0, 1.0) * np.clip(1.5 - np.abs(y) / 0.2, 0.0, 1.0)
    inward = -0.6 * np.sign(y) * np.minimum(np.abs(y), 0.08)
    pressed = State(1.0, {"displacement": np.stack([0 * x, inward * near])})
    before = (body.nodes + pressed["displacement"])[:, body.pial]
    assert self_intersections(before, closed=True, quadratic=True) == 0
    new = remeshed(body, pressed, size=0.05, inset=0.02)
    surface = new.nodes[:, new.pial]
    assert self_intersections(surface, closed=True, quadratic=True) == 0
    notch = surface[:, (surface[0] < -0.7) & (np.abs(surface[1]) < 0.3)]
    gap = [notch[1, notch[1] > 0].min(), -notch[1, notch[1] < 0].max()]
    assert min(gap) > 0.015


def test_tracing_is_refused_for_open_surfaces_and_large_insets():
    body = brain(0.2, 2)
    still = State(0.0, {"displacement": np.zeros_like(body.nodes)})
    with pytest.raises(ValueError, match="closed pial surface"):
        remeshed(body, still, size=0.1, inset=0.01)
    with pytest.raises(ValueError, match=r"inset=0\.2"):
        remeshed(body, still, size=0.1, inset=0.2)


def test_panels_show_name_numbers_and_note_on_one_scale():
    terms, growth = (SOLID,), TangentialGrowth(cortex=1.2)
    stepping = Stepping(first=0.5, largest=0.5)
    result = simulate(Scene(body=brain(0.2, 2), terms=terms, processes=(growth,), stepping=stepping))
    figure = Figure()
    shown = {"start": (result, figures.nearest_step(result, 0.1)), "end": (result, -1)}
    drawn = figures.grid(figure, shown, columns=2, notes={"end": "a note"})
    assert [axes.get_title(loc="left") for axes in drawn] == ["$\\bf{a}$  start", "$\\bf{b}$  end"]
    assert [axes.texts[0].get_text() for axes in drawn] == [
        "0 sulci, GI 1.00 ± ?", "0 sulci, GI 1.00 ± ?\na note"
    ]  # fmt: skip
    assert drawn[0].get_xlim() == drawn[1].get_xlim()
    surfaces = [axes.lines[0].get_xydata() for axes in drawn]
    assert np.hypot(*surfaces[0].T) == pytest.approx(1.0)
    assert np.hypot(*surfaces[1].T).min() > 1.005
    figures.before(drawn[1], result)
    assert np.array_equal(drawn[1].lines[1].get_xydata(), surfaces[0])


def test_panels_count_sulci_and_measure_them_in_thicknesses():
    body = brain(0.1, 2)
    x, y = body.nodes
    angle = np.arctan2(y, x)
    wavy = 0.06 * np.cos(10 * angle) * np.hypot(x, y)  # crests at the ends, fundi at π/10, 3π/10, ...
    moved = State(1.0, {"displacement": wavy * np.stack([np.cos(angle), np.sin(angle)])})
    result = Result(Scene(body=body, terms=(SOLID,)), (moved,), ())
    found = figures.numbers(result)
    assert found.startswith("5 sulci, GI 1.0")
    depth = float(found.split()[-2])
    # the taut path over the fundus at π/10 is the tangent at right angles to that direction
    fine = np.linspace(0.0, np.pi / 10, 2001)
    tangent = ((1 + 0.06 * np.cos(10 * fine)) * np.cos(np.pi / 10 - fine)).max()
    assert depth == pytest.approx((tangent - 0.94) / 0.1, abs=0.051)  # one digit is shown


# whole cases


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_malformations_change_folds_in_the_published_direction(seed):
    """Eight brains: no walls that cross; number, width, depth and size of folds, and where they are."""
    results = {name.partition(":")[0]: one for name, one in run("ferret_malformations", seed=seed).items()}
    for result in results.values():
        assert result.converged
        assert self_intersections(result.pial(), closed=False, quadratic=True) == 0
    found = {name: folds(result) for name, result in results.items()}
    normal, smaller = found["normal"], found["TMEM161B"]
    assert found["PMG"].count >= 3 * normal.count
    assert found["PMG"].width < normal.width / 3
    assert found["thick"].count < normal.count
    assert smaller.count < 0.7 * normal.count
    assert index(results["TMEM161B"]) < index(results["normal"]) - 0.2
    assert found["Cdk5"].depth < 0.75 * normal.depth
    assert abs(found["Cdk5"].count - normal.count) <= 1
    assert found["ASPM"].count == 0
    assert area(results["ASPM"]) < area(results["normal"]) < area(results["ARHGAP11B"])
    # two published directions are not those of the plane: two thirds of the excess length in half as many
    # folds is as deep, and folds of a cortex 1.5 times as thick are that much farther apart
    assert smaller.hull_depths.mean() >= 0.9 * normal.hull_depths.mean()
    assert smaller.width >= normal.width
    # a cortex that is thin in the middle folds finely there, and there only
    thick, thin = (sulci_at(results[name]) for name in ("normal", "SCN3A"))
    inside, usual = (np.sum((places > 0.35) & (places < 0.65)) for places in (thin, thick))
    assert inside >= 2 * usual
    assert abs((len(thin) - inside) - (len(thick) - usual)) <= 1


@pytest.mark.slow
def test_after_folding_the_fold_number_is_inverse_to_the_thickness():
    products = []
    for thickness, elements in ((0.2, 4), (0.1, 3), (0.05, 2.5)):
        processes = (TangentialGrowth(cortex=2.2), Imperfection(amplitude=0.02))
        scene = Scene(body=brain(thickness, elements), terms=(SOLID, SelfContact()), processes=processes)
        products.append(thickness * fold_count(whole(simulate(scene).pial()), closed=True))
    assert products == pytest.approx(np.full(3, np.mean(products)), rel=0.15)


@pytest.mark.slow
def test_meshes_of_the_family_have_as_many_triangles_as_they_say():
    scenes = load_case(CASES / "ferret_mesh.py").scenes({}, quick=False)
    cortex = [int(scene.body.in_cortex.sum()) for scene in scenes.values()]
    # whole layers: 3, 6, 8, 10 instead of 3 times 1, 2, 2.83, 3.46
    assert np.array(cortex) / cortex[0] == pytest.approx([1, 4, 8, 12], rel=0.08)


@pytest.mark.slow
def test_folds_deepen_from_stage_to_stage():
    results = run("ferret_stages")
    indices = [index(result) for result in results.values()]
    assert (np.diff(indices) > 0.05).all()
    for result in results.values():
        assert self_intersections(result.pial(), closed=True, quadratic=True) == 0
        assert np.abs(result.observe(0)["von_mises"]).max() < 1e-9  # a fresh start without stress


@pytest.mark.slow
def test_thicker_coats_fold_less():
    # a coat of 0.04 and not 0.025 of the radius, in two elements: half a minute in place of ten
    results = run("ferret_gel", {"coat": 0.04, "elements": 2.0}).values()
    assert all(result.converged for result in results)
    counts = [folds(result).count for result in results]
    assert counts[0] > counts[1] > counts[2] > 0


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:outline. .*(lie|crosses):turingfold.geometry.changes.OutlineWarning")
def test_a_folded_brain_with_a_thin_cortex_folds_finely_over_its_gyri():
    if not load_case(CASES / "ferret_outlines.py").module.FOLDER.is_dir():
        pytest.skip("the published outlines are not here")
    results = run("ferret_folded", {"elements": 2.0})
    counts = {name.partition(":")[0]: folds(result).count for name, result in results.items()}
    assert counts["PMG"] > 3 * counts["normal"]
    assert counts["normal"] < counts["SCN3A"] < counts["PMG"]
    assert max(counts["ASPM"], counts["thick"], counts["TMEM161B"]) <= counts["normal"]
    for result in results.values():
        assert self_intersections(result.pial(), closed=True, quadratic=True) == 0


@pytest.mark.slow
def test_real_outlines_fold_without_crossing_themselves():
    case = load_case(CASES / "ferret_outlines.py").module
    if not case.FOLDER.is_dir():
        pytest.skip(f"the outlines are not in {case.FOLDER}")
    for (side, result), published in zip(run("ferret_outlines").items(), (1.551, 1.354), strict=True):
        pial = result.pial()
        grown = case.perimeter(pial) / result.scene.body.pial_curve.length
        assert grown == pytest.approx(published, rel=0.01)
        assert self_intersections(pial, closed=True, quadratic=True) == 0
        assert index(result) == pytest.approx(case.PUBLISHED[side], abs=0.1)
