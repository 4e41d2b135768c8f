"""Landmarks beside outlines, limits of single parameters, and going on from the best so far."""

import json

import numpy as np
import pytest

from turingfold import (
    Elastic,
    GrowthMap,
    NeoHookean,
    Scene,
    Stepping,
    fit,
    half,
    semicircle,
    sensitivity,
    simulate,
)
from turingfold.geometry.body import by_node
from turingfold.results.surface import along_pial
from turingfold.sensitivity.fit_setup import limits
from turingfold.sensitivity.landmarks import landmarks_of

SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
PLACES = (0.0, 0.25, 0.5)
NAMES = [f"GrowthMap.cortex.{k}" for k in range(3)]


def scene(values=(1.1, 1.3, 1.15)):
    body = half(semicircle(radius=1.0, thickness=0.25, elements=2))
    processes = (GrowthMap(cortex=values, places=PLACES),)
    return Scene(body=body, terms=(SOLID,), processes=processes, stepping=Stepping(first=0.25, largest=0.25))


@pytest.fixture(scope="module")
def hidden():
    return simulate(scene())


def test_landmarks_are_points_of_the_tissue_also_on_the_image_of_half_a_body(hidden):
    body = hidden.scene.body
    x = by_node(hidden.last["displacement"])
    surface = along_pial(body, body.nodes[:, body.pial])
    moved = hidden.pial()
    shares = np.concatenate([body.pial_arc, 2 * body.pial_arc[-1] - body.pial_arc[-2::-1]])
    shares /= 2 * body.pial_arc[-1]
    chosen = [3, 8, len(shares) - 5]  # the last one beyond the mirror
    given = [(float(shares[k]), tuple(moved[:, k])) for k in chosen]
    marks = landmarks_of(body, 1.0, given)
    assert marks.mirrored.tolist() == [False, False, True]
    np.testing.assert_allclose(marks.apart(x), 0.0, atol=1e-12)
    np.testing.assert_allclose(marks.apart(0 * x), surface[:, chosen] - moved[:, chosen], atol=1e-12)
    by_point = landmarks_of(body, 1.0, [(tuple(surface[:, k]), tuple(moved[:, k])) for k in chosen[:2]])
    np.testing.assert_allclose(by_point.apart(x), 0.0, atol=1e-6)


def test_landmarks_tell_what_an_outline_does_not(hidden):
    """An outline of the right size at landmarks elsewhere: the fit leaves the outline for them."""
    body = hidden.scene.body
    node = len(body.pial) // 2
    share = body.pial_arc[node] / (2 * body.pial_arc[-1])
    target = hidden.pial()[:, node]
    true = fit(scene((1.2, 1.2, 1.2)), {1.0: hidden.pial()}, NAMES, landmarks={1.0: [(share, target)]})
    np.testing.assert_allclose(true.values, (1.1, 1.3, 1.15), atol=2e-3)
    along = target + 0.05 * np.array([-target[1], target[0]])
    drawn = fit(
        scene((1.2, 1.2, 1.2)), {1.0: hidden.pial()}, NAMES, bounds=(1.0, 1.6),
        landmarks={1.0: 40 * [(share, along)]},
    )  # fmt: skip
    mark = landmarks_of(body, 1.0, [(share, along)])
    ends = [by_node(simulate(one.scene).last["displacement"]) for one in (true, drawn)]
    away = [float(np.hypot(*mark.apart(x)).item()) for x in ends]
    assert away[1] < 0.8 * away[0]


def test_limits_of_one_map_and_of_one_parameter(hidden):
    found = fit(
        scene((1.2, 1.2, 1.2)), {1.0: hidden.pial()}, [*NAMES, "Elastic.gray.kappa"],
        bounds={"GrowthMap.cortex": (1.0, 1.25), "Elastic.gray.kappa": (4.0, 6.0)},
    )  # fmt: skip
    assert found.values[:3].max() <= 1.25
    assert found.values[1] == pytest.approx(1.25, abs=1e-3)  # the hidden value is beyond it
    assert 4.0 <= found.values[3] <= 6.0
    for bounds, words in (({"Elastic.gray.mu": (1, 2)}, "not fitted"), ((1.5, 1.0), "in this order")):
        with pytest.raises(ValueError, match=words):
            fit(scene(), {1.0: hidden.pial()}, NAMES, bounds=bounds)


def test_a_fit_goes_on_from_the_best_so_far(hidden, tmp_path):
    first = fit(scene((1.2, 1.2, 1.2)), {1.0: hidden.pial()}, NAMES, out=tmp_path)
    told = []
    again = fit(
        scene((1.2, 1.2, 1.2)), {1.0: hidden.pial()}, NAMES, out=tmp_path, resume=True, progress=told.append
    )
    assert told[0] == pytest.approx(json.loads((tmp_path / "fit.json").read_text())["misfit"], abs=1e-9)
    np.testing.assert_allclose(again.values, first.values, atol=1e-6)
    with pytest.raises(ValueError, match="other parameters"):
        fit(scene(), {1.0: hidden.pial()}, ["Elastic.gray.kappa"], out=tmp_path, resume=True)
    (tmp_path / "fit.json").write_text("{")
    with pytest.raises(ValueError, match="damaged"):
        fit(scene(), {1.0: hidden.pial()}, NAMES, out=tmp_path, resume=True)


@pytest.mark.parametrize(
    ("marks", "words"),
    [
        ({0.5: [(0.1, (1.0, 0.0))]}, "no outline of it"),
        ({1.0: [(0.1, (1.0, 0.0, 0.0))]}, r"landmarks\[1\]"),
        ({1.0: [0.1]}, "pairs of place and point"),
        ({1.0: [((5.0, 5.0), (1.0, 0.0))]}, "from the pial surface"),
        ({1.0: [(0.3, (500.0, 1000.0))]}, "are both in m"),
        ([(0.3, (0.5, 1.0))], "give them by age"),
    ],
)
def test_what_are_no_landmarks_is_refused(hidden, marks, words):
    with pytest.raises(ValueError, match=words):
        fit(scene(), {1.0: hidden.pial()}, NAMES, landmarks=marks)


@pytest.mark.parametrize(
    ("names", "options", "words"),
    [
        ([*NAMES, NAMES[0]], {}, r"GrowthMap\.cortex\.0 twice"),
        ([], {}, "one parameter or more"),
        (NAMES[0], {}, "one parameter or more"),
        (NAMES, {"bounds": (1.2, 1.5)}, r"cortex\.0 begins at 1\.1, outside its bounds 1\.2 to 1\.5"),
        (NAMES, {"noise": float("nan")}, "noise=nan"),
        (NAMES, {"noise": -1e-3}, "noise=-0.001"),
        (NAMES, {"smoothness": -1.0}, "smoothness=-1"),
        (NAMES, {"smoothness": float("nan")}, "smoothness=nan"),
        (NAMES, {"tolerance": 0.0}, "tolerance=0"),
    ],
)
def test_what_cannot_be_fitted_is_refused(hidden, names, options, words):
    with pytest.raises(ValueError, match=words):
        fit(scene(), {1.0: hidden.pial()}, names, **options)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"bounds": (1, 2, 3)}, "give two numbers"),
        ({"bounds": "1,2"}, "give two numbers"),
        ({"smoothness": "auot"}, 'or "auto"'),
        ({"resume": True}, "give that folder"),
    ],
)
def test_options_that_are_none_are_refused(hidden, options, words):
    with pytest.raises(ValueError, match=words):
        fit(scene(), {1.0: hidden.pial()}, NAMES, **options)


def test_the_limits_of_a_parameter_go_before_those_of_its_map():
    bounds = {"GrowthMap.cortex.0": (1.0, 1.1), "GrowthMap.cortex": (0.9, 2.0)}
    low, high = limits(bounds, NAMES)
    assert low.tolist() == [1.0, 0.9, 0.9]
    assert high.tolist() == [1.1, 2.0, 2.0]


def test_the_start_has_no_sensitivities(hidden):
    with pytest.raises(ValueError, match="step=0 is the start"):
        sensitivity(hidden, to=NAMES, step=0)
