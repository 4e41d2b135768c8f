"""Estimated errors of the integration points against what equilibria with a rule of order 12 show."""

import json
from dataclasses import fields, replace

import pytest
from small import elastic_scene, folding_scene

from turingfold import Body, Elastic, NeoHookean, StressGrowth, TangentialGrowth, load, simulate
from turingfold.results.carried import NoEstimateError
from turingfold.results.measures import shape_numbers
from turingfold.results.quadrature_error import quadrature_errors
from turingfold.solve.problem import Problem


class Exact(Body):
    order = 12


def numbers(result):
    found = shape_numbers(result.scene.body, result.last["displacement"])
    return found | {"energy": result.history[-1]["energy"]}


def errors_and_truth(scene, result):
    """Return the estimated errors, and those that are there."""
    exact = Exact(**{field.name: getattr(scene.body, field.name) for field in fields(Body)})
    found, true = numbers(result), numbers(simulate(replace(scene, body=exact)))
    return quadrature_errors(Problem(scene), result.last), {
        name: abs(true[name] - found[name]) for name in found
    }


def test_of_a_smooth_body_they_are_the_true_ones():
    scene = elastic_scene()
    estimated, true = errors_and_truth(scene, simulate(scene))
    for name in ("energy", "perimeter"):
        assert estimated[name] == pytest.approx(true[name], rel=0.02), name


@pytest.mark.slow
def test_of_a_folded_body_they_are_within_a_factor_of_three(folded):
    estimated, true = errors_and_truth(folding_scene(), folded)
    for name in ("energy", "perimeter", "sulcal_depth"):  # those of length and hull cancel in the index
        assert 1 / 3 < estimated[name] / true[name] < 3, name


def test_they_are_a_part_of_the_mesh_and_kept_in_the_folder(tmp_path):
    result = simulate(elastic_scene(), tmp_path)
    assert 0 < result.quadrature_errors["energy"] < result.errors["energy"]
    assert load(tmp_path).quadrature_errors == result.quadrature_errors
    kept = json.loads((tmp_path / "summary.json").read_text())
    assert kept["quadrature_errors"] == result.quadrature_errors


@pytest.mark.parametrize(("changes", "why"), [
    ({"processes": (TangentialGrowth(cortex=1.1), StressGrowth(rate=1.0))}, "remembers"),
    ({"terms": (Elastic(gray=NeoHookean.from_young(3.0, 0.499)),)}, "mixed elements"),
])  # fmt: skip
def test_some_have_none(changes, why):
    scene = replace(elastic_scene(), **changes)
    result = simulate(scene, errors=True)
    assert result.quadrature_errors == {}
    assert result.summary()["quadrature_errors"] is None
    with pytest.raises(NoEstimateError, match=why):
        quadrature_errors(Problem(scene), result.last)
