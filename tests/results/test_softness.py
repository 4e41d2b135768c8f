"""Softness against a dense solver, a buckling growth that was found by other means, and finer meshes."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from small import elastic_scene

from turingfold import (
    Drag,
    Imperfection,
    Scene,
    SelfContact,
    TangentialGrowth,
    buckling,
    human,
    load,
    outline,
    semicircle,
    simulate,
)
from turingfold.results.carried import NoEstimateError, at_rest
from turingfold.results.softness import SOFT, soft_words, softness
from turingfold.solve.problem import Problem
from turingfold.solve.sparsity import Assembler

ROUND = np.linspace(0, 2 * np.pi, 160, endpoint=False)


def smooth(cortex):
    """Return a half disc without contact, which grows evenly until it buckles."""
    body = semicircle(radius=0.02, thickness=2.5e-3, elements=2)
    return Scene(body=body, terms=(human.tissue(),), processes=(TangentialGrowth(cortex=cortex),))


def rough(elements):
    """Return a half disc whose growth is uneven; it has a fold or none."""
    body = semicircle(radius=0.02, thickness=2.5e-3, elements=elements)
    uneven = TangentialGrowth(cortex=1.8), Imperfection(amplitude=0.05)
    return Scene(body=body, terms=(human.tissue(), SelfContact()), processes=uneven)


def bumpy(elements):
    """Return an ellipse with five bumps."""
    radii = np.array([[0.02], [0.014]]) + 0.002 * np.cos(5 * ROUND)
    body = outline(radii * [np.cos(ROUND), np.sin(ROUND)], thickness=2.5e-3, elements=elements)
    growth = TangentialGrowth(cortex=1.8)
    return Scene(body=body, terms=(human.tissue(poisson=0.45), SelfContact()), processes=(growth,))


def matrix(assembler, at, convexity):
    sparsity, values = assembler.assemble(at.hessians(convexity))
    return np.stack([sparsity.product(values)(row) for row in np.eye(len(assembler.free))])


def test_it_is_the_least_eigenvalue_of_the_tangent_by_its_convex_part():
    scene = elastic_scene(TangentialGrowth(cortex=1.6))
    result, problem = simulate(scene), Problem(scene)
    at, assembler = at_rest(problem, result.last), Assembler(problem.n_dofs, problem.held)
    least = scipy.linalg.eigh(*(matrix(assembler, at, c) for c in (0.0, 1.0)), eigvals_only=True)[0]
    assert 0 < least < 0.9
    assert softness(problem, result.last) == pytest.approx(least, rel=0.01)


def test_it_is_negative_where_the_tangent_is_not_positive_definite():
    scene = elastic_scene(TangentialGrowth(cortex=2.3))
    last, problem = simulate(scene).last, Problem(scene)
    state = last.updated(displacement=np.zeros_like(last["displacement"]))  # far from any equilibrium
    at, assembler = at_rest(problem, state), Assembler(problem.n_dofs, problem.held)
    values = scipy.linalg.eigh(*(matrix(assembler, at, c) for c in (0.0, 1.0)), eigvals_only=True)
    assert values[0] < 0 < values[-1]
    nearest = values[values < 0].max()
    assert softness(problem, state) == pytest.approx(nearest, rel=0.02)
    assert "no minimum" in soft_words(nearest)


def test_nothing_is_softer_where_nothing_presses():
    scene = elastic_scene(TangentialGrowth(cortex=1 + 1e-9))
    assert softness(Problem(scene), simulate(scene).last) == pytest.approx(1.0, abs=1e-6)


def test_it_vanishes_at_the_growth_at_which_the_body_buckles(tmp_path):
    critical = buckling(smooth(2.3)).growth
    near, early = (smooth(1 + share * (critical - 1)) for share in (0.99, 0.6))
    result = simulate(near, tmp_path)
    assert 0 < result.softness < SOFT
    assert "near a limit of stability" in soft_words(result.softness)
    assert load(tmp_path).softness == result.summary()["softness"] == result.softness
    assert simulate(early, errors=True).softness > 2 * SOFT
    assert simulate(early).softness is None


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "coarse", "fine"), [(rough, (2, 3), (4, 6)), (bumpy, (4, 4.5), (5, 6))])
def test_a_mesh_that_ends_before_a_snap_is_told(scene, coarse, fine):
    """Errors estimated on the coarse ones, below 4 %, leave out that fine ones fold otherwise.

    Not all are: with 3 and 3.5 elements the bumpy one has 0.062 and 0.082. These were 3 and 4 elements, until
    closed outlines were meshed in another way.
    """
    before, after = ([simulate(scene(n), errors=True) for n in meshes] for meshes in (coarse, fine))
    indices = [[result.summary()["gyrification_index"] for result in results] for results in (before, after)]
    assert max(indices[0]) + 0.015 < min(indices[1])
    assert all(soft_words(result.softness) for result in before)
    assert not any(soft_words(result.softness) for result in after)


def test_motions_have_none():
    scene = elastic_scene()
    moving = replace(scene, terms=(*scene.terms, Drag(coefficient=1.0)))
    with pytest.raises(NoEstimateError, match="motion"):
        softness(Problem(moving), simulate(moving).last)
