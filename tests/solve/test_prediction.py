"""The prediction of the next equilibrium: exact on polynomials, of the degree that the past supports."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle, simulate
from turingfold.parts import TimeStep
from turingfold.solve.inertia import negative_pivots
from turingfold.solve.march import begin, march
from turingfold.solve.prediction import REMEMBERED, Past, extrapolated
from turingfold.solve.problem import Problem, configuration
from turingfold.solve.sparsity import Assembler
from turingfold.terms.dynamics import Drag

TIMES = (0.0, 0.1, 0.23, 0.3, 0.45)
SHAPE = np.array([[1.0, -2.0, 0.5], [0.0, 3.0, 1.0]])


def path(function, times=TIMES):
    return [Past(t, function(t) * SHAPE) for t in times]


@pytest.mark.parametrize("degree", range(REMEMBERED + 1))
def test_a_polynomial_path_is_continued_exactly(degree):
    def function(t):
        return 1 + sum((k + 1) * t**k for k in range(1, degree + 1))

    points = path(function, TIMES[-degree - 1 :] if degree else TIMES)
    assert extrapolated(points, 0.6) == pytest.approx(function(0.6) * SHAPE, rel=1e-12)


def test_two_points_are_continued_straight():
    points = path(lambda t: np.exp(t), (0.2, 0.3))
    expected = np.exp(0.3) + (np.exp(0.3) - np.exp(0.2)) * 2
    assert extrapolated(points, 0.5) == pytest.approx(expected * SHAPE, rel=1e-12)


def test_after_a_jump_the_past_is_not_carried_on():
    points = path(lambda t: t if t < 0.4 else 50.0 + t)
    # every polynomial foretold the last point badly, the one of degree 1 least: it carries half the jump on
    reach = np.abs(extrapolated(points, 0.5) - points[-1].displacement).max()
    worst = np.abs(50.0 / 0.15 * 0.05 * SHAPE).max()
    assert reach <= worst * 1.01


@settings(derandomize=True, max_examples=50)
@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=5), st.floats(0.5, 2.0))
def test_a_prediction_is_finite_and_scales(values, scale):
    points = [Past(0.1 * i, v * SHAPE) for i, v in enumerate(values)]
    found = extrapolated(points, 0.1 * len(values))
    assert np.isfinite(found).all()
    larger = [Past(p.time, 2.0 * p.displacement) for p in points]
    assert np.array_equal(extrapolated(larger, 0.1 * len(values)), 2.0 * found)


@pytest.mark.parametrize("others", [(), (Drag(coefficient=0.05),)], ids=["still", "drag"])
def test_the_number_of_negative_pivots_is_that_of_the_accepted_state(others):
    """Also where the tangent was factorised a little before it: on the way through the buckling at 1.7."""
    body = semicircle(radius=1.0, thickness=0.2, size=0.1, base="roller")
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), *others)
    grow, steps = TangentialGrowth(cortex=1.9), Stepping(first=1 / 40, largest=1 / 40)
    scene = Scene(body=body, terms=terms, processes=(grow,), stepping=steps)
    problem, single = Problem(scene), 0
    assembler = Assembler(problem.n_dofs, problem.held)
    for step, progress in march(scene, begin(scene)):
        again = configuration(problem.potentials(step.state, TimeStep(step.numbers["step"])), step.x)
        count = negative_pivots(*assembler.assemble(again.hessians(0.0)))
        assert step.numbers["negative_pivots"] == count
        single += step.numbers["factorizations"] == 1 and progress.memory.point is not None
    assert single > 5  # states whose tangent was not factorised again


def test_a_smooth_path_needs_hardly_more_than_a_factorisation_a_step():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1, base="roller")
    steps = Stepping(first=1 / 15, largest=1 / 15)
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    scene = Scene(body=body, terms=(solid,), processes=(TangentialGrowth(cortex=1.3),), stepping=steps)
    later = simulate(scene).history[5:]
    assert all(row["negative_pivots"] == 0 for row in later)
    assert sum(row["factorizations"] for row in later) <= 1.2 * len(later)
    assert sum(row["newton_iterations"] for row in later) <= 3 * len(later)
