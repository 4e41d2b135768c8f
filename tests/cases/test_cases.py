"""Every case: its form, the start of each of its scenes, and, slow, its quick version with its figure."""

import ast
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from regression import differences

from turingfold import BoundaryLoads, TangentialGrowth, half, human, semicircle, simulate
from turingfold.cli.case import find_case, folder_name, load_case
from turingfold.cli.main import main
from turingfold.results.codec import decode
from turingfold.results.document import stored

APART = ("tension_placement",)  # whose numbers are examined as well
# contours as they were published touch themselves here and there, which is told
pytestmark = pytest.mark.filterwarnings("ignore::turingfold.OutlineWarning")
CASES = sorted((Path(__file__).parents[2] / "cases").glob("*.py"))


def data_or_skip(path):
    """Skip the case whose input is the user's own, where it is not there."""
    folder = getattr(load_case(path).module, "FOLDER", path.parent)
    if not folder.is_dir():
        pytest.skip(f"the outlines are not in {folder}")


def slow_if_long(path):
    """Mark the families that take a while to build their scenes, or to start them."""
    long = path.stem.startswith(("ferret", "turing", "human"))
    return pytest.param(path, id=path.stem, marks=pytest.mark.slow if long else ())


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_a_case_says_what_it_is_and_how_to_run_it(path):
    case = load_case(path)
    assert case.title.endswith((" s.", " min.", " h."))  # the run time
    assert f"turingfold run cases/{path.name}" in case.module.__doc__
    assert case.draw is not None


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_a_case_uses_only_what_is_public(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        assert not [name for name in names if name.startswith("turingfold.")]


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_a_case_has_parameters_with_range_and_label(path):
    parameters = load_case(path).parameters
    assert {"thickness", "elements"} <= parameters.keys() | ({"thickness"} if "coat" in parameters else set())
    for one in parameters.values():
        assert one.meaning.label
        assert one.kind in (bool, str) or np.isfinite([one.meaning.low, one.meaning.high]).all()
        assert one.checked(one.default) == one.default


@pytest.mark.parametrize("name", ["figure2", "figure3"])
def test_the_figures_have_the_parameters_of_document_1(name):
    (path,) = [path for path in CASES if path.stem == name]
    shape = {"radius"} if name == "figure3" else {"width", "height"}
    wanted = (
        "thickness elements along young_gray young_white poisson cortex core radial_core swelling growth_law "
        "strength half_waves kinetics tension pattern two_layers loads dynamics duration base layers seed "
        "halved"
    )
    assert load_case(path).parameters.keys() == shape | set(wanted.split())


def test_hypotheses_that_are_off_are_absent():
    (path,) = [path for path in CASES if path.stem == "figure3"]
    given = {"tension": False, "pattern": False, "two_layers": False}
    (scene,) = load_case(path).scenes(given, quick=True).values()
    assert [type(part).__name__ for part in (*scene.processes, *scene.terms)] == [
        "TangentialGrowth", "Swelling", "Elastic", "SelfContact",
    ]  # fmt: skip
    assert scene.terms[0].white is None


def parts(**given):
    (path,) = [path for path in CASES if path.stem == "figure3"]
    (scene,) = load_case(path).scenes(given, quick=True).values()
    return scene, {type(part).__name__: part for part in (*scene.processes, *scene.terms)}


def test_only_the_cortex_grows_where_the_core_is_set_to_one():
    for given in ({"core": 1.0, "radial_core": 1.0, "swelling": 0.0}, {"growth_law": "cortex"}):
        _, found = parts(cortex=1.9, **given)
        assert "Swelling" not in found
        assert found["TangentialGrowth"] == TangentialGrowth(cortex=1.9)


def test_white_matter_grows_by_stress_in_place_of_the_prescribed_growth():
    _, found = parts(growth_law="stress", young_white=1895.0, poisson=0.4583)
    assert found["StressGrowth"].rate == pytest.approx(2 * (1 + 0.4583) / 1895.0)  # 1/μ, in the time 1
    assert found["TangentialGrowth"] == TangentialGrowth(cortex=2.3)
    scene, found = parts(growth_law="stress", dynamics=True, duration=3.0)
    assert (found["StressGrowth"].end, scene.until) == (3.0, 4.0)  # not in the second in which motion dies


def test_figure_1_loads_are_pairs_without_resultant_in_place_of_the_tension():
    _, found = parts(loads="figure1")
    assert "AxonalTension" not in found
    assert found["PeakLoads"].strength == 0.75
    _, found = parts(loads="figure1", pattern=False)
    loads = found["BoundaryLoads"]
    assert len(loads.places) == 24  # two for each of twelve places
    np.testing.assert_allclose(loads.resultant, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.hypot(*np.transpose(loads.forces)), 0.75)
    # on the half circle the first of each pair lies at a smaller angle and is pulled to a larger one
    angles = np.pi * np.array(loads.places[:12])
    pulled = np.stack([-np.sin(angles), np.cos(angles)]) * np.transpose(loads.forces)[:, :12]
    assert (pulled.sum(0) > 0.99 * 0.75).all()
    assert "BoundaryLoads" not in parts(loads="figure1", pattern=False, tension=False)[1]


@pytest.mark.parametrize("count", [24, 60])
def test_pairs_of_half_a_body_are_half_of_the_whole_ones_and_none_leaves_the_surface(count):
    whole = semicircle(radius=0.04, thickness=2.5e-3, elements=2)
    found = []
    for body in (whole, half(whole)):
        scene = human.brain(body, loads="figure1", pattern=False, half_waves=count)
        (loads,) = (term for term in scene.terms if isinstance(term, BoundaryLoads))
        found.append(len(loads.places))
    assert 0 < found[0] <= count
    assert 2 * found[1] == found[0]


def test_dynamics_is_inertia_from_rest_in_seconds_with_a_second_in_which_it_dies():
    scene, found = parts(dynamics=True, duration=3.0)
    assert {"Inertia", "StiffnessDamping"} <= found.keys()
    assert scene.until == 4.0
    history = found["TangentialGrowth"].history
    assert [history.factor(2.0, t) for t in (0.0, 1.5, 3.0, 4.0)] == [1.0, 1.5, 2.0, 2.0]
    assert scene.stepping.local_error == pytest.approx(0.02 * 2.5e-3)


def test_a_body_that_grows_evenly_on_rollers_is_free_of_stress():
    # one material and one factor along and across: the body is 1.2 times as large, F* = 1 in the plane
    scene, found = parts(base="roller", two_layers=False, tension=False, pattern=False)
    even = TangentialGrowth(cortex=1.2, core=1.2, radial_core=1.2, radial_cortex=1.2)
    result = simulate(replace(scene, processes=(even,)))
    body, modulus = scene.body, found["Elastic"].gray.mu
    np.testing.assert_allclose(result.last["displacement"], 0.2 * body.nodes, atol=1e-9 * body.length)
    assert np.abs(result.observe()["von_mises"]).max() < 1e-8 * modulus


def test_hypotheses_differ_by_one_thing_each_and_growth_is_in_all_eight():
    (path,) = [path for path in CASES if path.stem == "hypotheses"]
    case = load_case(path)
    scenes = {name.partition(", seed")[0]: one for name, one in case.scenes({}, quick=True).items()}
    assert len(scenes) == 9
    kinds = {
        name: {type(part).__name__: part for part in (*one.processes, *one.terms)}
        for name, one in scenes.items()
    }
    growths = ("TangentialGrowth", "Swelling", "Imperfection", "SelfContact")
    eight = [found for name, found in kinds.items() if "no growth" not in name]
    assert all(found[name] == eight[0][name] for found in eight for name in growths)
    for name, found in kinds.items():
        assert ("DGH" in name) == (found["Elastic"].white is not None)
        assert ("ATH" in name) == ("AxonalTension" in found)
        assert ("IPH" in name) == ("Turing" in found)
    still = kinds["DGH + ATH + IPH, no growth"]
    assert still["TangentialGrowth"].cortex == 1.0
    same = set(kinds["DGH + ATH + IPH"]) - {"TangentialGrowth", "Swelling"}
    assert all(still[name] == kinds["DGH + ATH + IPH"][name] for name in same)


@pytest.mark.parametrize("path", [slow_if_long(path) for path in CASES])
def test_scenes_start_and_can_be_stored(path):
    data_or_skip(path)
    case = load_case(path)
    name, scene = next(iter(case.scenes({}, quick=True).items()))
    document, arrays = stored(scene)
    again = decode(json.loads(json.dumps(document["scene"], allow_nan=False)), arrays, known=case.known)
    assert again.processes == scene.processes
    assert again.terms == scene.terms
    steps, until = replace(scene.stepping, stops=()), scene.until * scene.stepping.first
    first = replace(scene, until=until, stepping=steps)
    assert simulate(first).summary()["converged"] is True, name


@pytest.mark.slow
@pytest.mark.parametrize("path", [p for p in CASES if p.stem != "ferret_stages"], ids=lambda path: path.stem)
def test_scenes_are_made_in_full_size(path):  # those of ferret_stages are made from results: test_ferret
    data_or_skip(path)
    assert load_case(path).scenes({}, quick=False)


def check_run(path, out):
    """Run and draw a quick case, hold its numbers to the stored ones, and return its scenes' summaries."""
    case = load_case(path)
    assert main(["run", str(path), "--quick", "--out", str(out)]) == 0
    assert (out / case.name / f"{case.name}.png").stat().st_size > 10_000
    summaries = {}
    for name in case.scenes({}, quick=True):
        file = out / case.name / folder_name(name) / "summary.json"
        summaries[name] = json.loads(file.read_text())
        check(summaries[name])
    assert not (moved := differences(case.name, summaries)), "\n".join(moved)
    return summaries


def check(summary):
    assert summary["converged"] is True
    assert summary["self_intersections"] == summary["inverted_elements"] == 0
    assert summary["min_jacobian"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["figure2", "figure3"])
def test_half_of_a_brain_folds_as_the_whole(name):
    case = find_case(name)
    whole, right = (
        simulate(case.scenes({"halved": halved}, quick=True)["three hypotheses"]).summary()
        for halved in (False, True)
    )
    assert whole["folds"] == right["folds"]
    assert right["gyrification_index"] == pytest.approx(whole["gyrification_index"], rel=1e-3)
    assert 2 * right["energy"] == pytest.approx(whole["energy"], rel=1e-3)


@pytest.mark.slow
def test_figure_3_is_within_a_per_cent_of_what_twelve_elements_say():
    """Of half of it, with 12 elements through the cortex, 18 as long along it, and a core as fine as 0.05."""
    energy, index, depth = 0.200149, 1.45413, 1.85354  # J/m, and in thicknesses
    case = find_case("figure3")
    found = simulate(case.scenes({"halved": True}, quick=False)["three hypotheses"]).summary()
    assert found["folds"] == 12
    assert found["energy"] == pytest.approx(energy, rel=0.01)
    assert found["gyrification_index"] == pytest.approx(index, rel=0.01)
    assert found["sulcal_depth"] / 2.5e-3 == pytest.approx(depth, rel=0.01)


def test_figure_3_has_a_gyrus_on_each_peak():
    (path,) = [path for path in CASES if path.stem == "figure3"]
    (scene,) = load_case(path).scenes({}, quick=True).values()
    summary = simulate(scene).summary()
    check(summary)
    # 24 half waves have troughs at 12 places: a sulcus in each
    assert summary["folds"] == 12
    assert summary["registration"] > 0.8
    assert summary["mirror_error"] < 1e-3 * 2.5e-3


@pytest.mark.slow
@pytest.mark.parametrize("path", [p for p in CASES if p.stem not in APART], ids=lambda path: path.stem)
def test_a_quick_case_runs_and_draws(path, tmp_path):
    data_or_skip(path)
    check_run(path, tmp_path)


@pytest.mark.slow
def test_where_the_tension_acts_decides_what_stands_on_the_peaks(tmp_path):
    path = next(path for path in CASES if path.stem == "tension_placement")
    summaries = check_run(path, tmp_path)
    assert summaries["pial, towards peaks, 24 half waves"]["registration"] < -0.5
    assert summaries["pial, between peaks, 24 half waves"]["registration"] > 0.5
    assert summaries["interface, 24 half waves"]["registration"] > 0.8
