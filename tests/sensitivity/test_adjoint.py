"""The adjoint against the columns computed forward, and against an equilibrium with a load, solved again."""

from dataclasses import replace

import numpy as np
import pytest
from small import folding_scene

from turingfold import (
    BoundaryLoads,
    Drag,
    Imperfection,
    adjoint_sensitivity,
    half,
    sensitivity,
    simulate,
)
from turingfold.geometry.body import by_node
from turingfold.parts import TimeStep
from turingfold.sensitivity.measures import perimeter
from turingfold.solve.newton import Minimiser
from turingfold.solve.problem import Problem

PARAMETERS = (
    "TangentialGrowth.cortex", "Elastic.gray.mu", "AxonalTension.strength", "Imperfection.amplitude",
    "SelfContact.stiffness",
)  # fmt: skip


@pytest.fixture(scope="module", params=["whole", "half"])
def result(request):
    made = folding_scene()
    found = simulate(
        replace(
            made,
            body=half(made.body) if request.param == "half" else made.body,
            processes=(*made.processes, Imperfection(amplitude=0.02)),
            stepping=replace(made.stepping, tolerance=1e-10),
        )
    )
    assert found.summary()["folds"] >= 3
    assert found.summary()["min_gap"] < 1e-4, "walls are to touch"
    return found


def test_each_derivative_is_the_one_computed_forward(result):
    forward, adjoint = (made(result, to=PARAMETERS) for made in (sensitivity, adjoint_sensitivity))
    assert adjoint.measures == forward.measures
    np.testing.assert_array_equal(adjoint.numbers, forward.numbers)
    scale = np.abs(forward.derivatives).max(1, keepdims=True)
    assert np.abs(adjoint.derivatives - forward.derivatives).max() > 0  # another way to the same numbers
    np.testing.assert_allclose(adjoint.derivatives / scale, forward.derivatives / scale, rtol=1e-5, atol=1e-7)
    assert adjoint.negative_pivots == forward.negative_pivots == 0


def test_a_force_changes_the_pial_length_as_much_as_it_says(result):
    found = adjoint_sensitivity(result, of=("perimeter", "energy"))
    body, last = result.scene.body, result.last
    load = BoundaryLoads(places=(0.15,), forces=((0.6, -0.8),), width=body.thickness)
    x, step = by_node(last["displacement"]), TimeStep(last.time, over=True)
    vector = -load.on(body).during(last, step).evaluate(x).gradient()[0]  # N/m at the nodes
    assert vector.reshape(-1, 2).sum(0) == pytest.approx([0.6, -0.8])
    expected = float(by_node(found.forces[0]) @ vector)
    small = 1e-5
    lengths = []
    for sign in (1, -1):
        loaded = replace(load, forces=tuple((sign * small * a, sign * small * b) for a, b in load.forces))
        problem = Problem(replace(result.scene, terms=(*result.scene.terms, loaded)))
        state = problem.processed(problem.start(), last.time)
        state = state.updated(displacement=last["displacement"], contact_chords=last["contact_chords"])
        minimiser = Minimiser(problem.n_dofs, problem.held, 1e-11, 60)
        moved = minimiser.minimise(problem.potentials(state, step), x).x
        lengths.append(length_of(result, moved))
    assert (lengths[0] - lengths[1]) / (2 * small) == pytest.approx(expected, rel=1e-4)
    assert not found.forces[1].any()  # forces balance: the energy does not change to first order


def length_of(result, x):
    body = result.scene.body
    points = (body.nodes + x.reshape(-1, 2).T)[:, body.pial]
    return perimeter(points, closed=False) * (2 if body.mirror else 1)


def test_what_depends_on_the_way_is_refused(result):
    scene = replace(result.scene, terms=(*result.scene.terms, Drag(coefficient=1.0)))
    with pytest.raises(ValueError, match="Drag"):
        adjoint_sensitivity(replace(result, scene=scene))
    with pytest.raises(ValueError, match="of='area'"):
        adjoint_sensitivity(result, of=("area",))
