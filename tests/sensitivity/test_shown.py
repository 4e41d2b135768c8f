"""What is printed of results of analyses: short lines, and no arrays."""

import subprocess
import sys

import numpy as np
import pytest

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    Stepping,
    TangentialGrowth,
    adjoint_sensitivity,
    buckling,
    equilibria,
    fit,
    semicircle,
    sensitivity,
    simulate,
)


def test_the_function_is_found_whatever_was_imported_before_it():
    """It has the name of a folder, which was found in its place once anything of it had been imported."""
    lines = "import turingfold.sensitivity.fit, turingfold as tf", "tf.sensitivity(1)"
    done = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True)
    assert "sensitivity() missing 1 required keyword-only argument: 'to'" in done.stderr


@pytest.fixture(scope="module")
def scene():
    body = semicircle(radius=1.0, thickness=0.2, elements=1, base="roller", layers="sigmoid")
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    steps = Stepping(first=0.2, largest=0.2)
    return Scene(body=body, terms=(solid,), processes=(TangentialGrowth(cortex=1.9),), stepping=steps)


@pytest.fixture(scope="module")
def result(scene):
    with pytest.warns(UserWarning, match="through the cortex"):
        return simulate(Scene(body=scene.body, terms=scene.terms, processes=(TangentialGrowth(cortex=1.2),)))


def test_a_result_of_each_analysis_is_printed_in_short_lines(scene, result):
    found = fit(result.scene, {1.0: result.pial()}, ["TangentialGrowth.cortex"])
    path = equilibria(result.scene, steps=3)
    shown = {
        "Buckling(bifurcation at growth 1.8": buckling(scene),
        "Sensitivity(of perimeter to Elastic.gray.mu)": sensitivity(
            result, to=["Elastic.gray.mu"], of=["perimeter"]
        ),
        "AdjointSensitivity(of perimeter to forces)": adjoint_sensitivity(result, of=["perimeter"]),
        "Fit(1 of 1 combinations told, misfit up to ": found,
        "EquilibriumPath(4 points, to t = ": path,
        "PathPoint(t = 0, growth 1.0000, stable)": path.points[0],
        "State(t = 1, with displacement, ": result.last,
    }
    for words, one in shown.items():
        assert repr(one).startswith(words)
        assert len(repr(one)) < 200
        assert "array" not in repr(one)
    assert "TangentialGrowth.cortex          1.2 ± " in repr(found)


def test_a_parameter_that_is_not_told_has_no_standard_error(result):
    moduli = ["Elastic.gray.mu", "Elastic.gray.kappa"]  # in proportion they change no shape
    found = fit(result.scene, {1.0: result.pial()}, moduli)
    assert np.isinf(found.deviations).any()
    assert "± ? (the outlines do not tell it)" in repr(found)
