"""The thickness of smooth layers, and the values of a given pattern: derivatives and fits."""

from dataclasses import replace

import numpy as np
import pytest

from turingfold import (
    AxonalTension,
    Elastic,
    GrowthMap,
    Imperfection,
    NeoHookean,
    PatternMap,
    Scene,
    SelfContact,
    Stepping,
    Swelling,
    TangentialGrowth,
    fit,
    half,
    semicircle,
    sensitivity,
    simulate,
)
from turingfold.geometry.body import by_node
from turingfold.parts import TimeStep
from turingfold.solve.newton import Minimiser
from turingfold.solve.problem import Problem
from turingfold.state import State

SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0), white=NeoHookean(mu=1.3, kappa=6.0))
STEPS = Stepping(first=0.2, largest=0.2, tolerance=1e-10)


def smooth_scene(thickness=0.2, growth=1.6):
    body = semicircle(radius=1.0, thickness=0.2, elements=2, base="roller", layers="sigmoid")
    return Scene(
        body=replace(body, thickness=thickness),
        terms=(SOLID, SelfContact()),
        processes=(TangentialGrowth(cortex=growth), Imperfection(amplitude=0.02)),
        stepping=STEPS,
    )


def pulled_scene(values=(0.2, 1.0, 0.1, 0.7)):
    body = semicircle(radius=1.0, thickness=0.2, elements=2)
    tension = AxonalTension(strength=0.15)
    return Scene(
        body=body, terms=(SOLID, tension, SelfContact()), stepping=STEPS,
        processes=(PatternMap(values=values), TangentialGrowth(cortex=1.3)),
    )  # fmt: skip


def solved_again(scene, result):
    """Return displacement and energy of the nearest equilibrium of a scene that differs a little."""
    problem, old = Problem(scene), result.last
    state = problem.processed(problem.start(), old.time)
    state = state.updated(displacement=old["displacement"], contact_chords=old["contact_chords"])
    minimiser = Minimiser(problem.n_dofs, problem.held, 1e-11, 60)
    found = minimiser.minimise(
        problem.potentials(state, TimeStep(old.time, over=True)), by_node(old["displacement"])
    )
    return found.x.reshape(-1, 2).T, found.energy


@pytest.mark.parametrize(
    ("make", "parameter", "value", "changed"),
    [
        (smooth_scene, "Body.thickness", 0.2, lambda value: smooth_scene(thickness=value)),
        (pulled_scene, "PatternMap.values.1", 1.0, lambda value: pulled_scene((0.2, value, 0.1, 0.7))),
    ],
)
def test_derivatives_are_those_of_equilibria_solved_again(make, parameter, value, changed):
    result = simulate(make())
    found, h = sensitivity(result, to=(parameter,), of=("energy",)), 2e-6 * value
    (up, above), (down, below) = (solved_again(changed(value + s * h), result) for s in (1, -1))
    expected = (up - down) / (2 * h)
    scale = np.abs(expected).max()
    assert scale > 0.01
    assert np.abs(found.displacement[0] - expected).max() < 1e-5 * scale
    assert found.of("energy", parameter) == pytest.approx((above - below) / (2 * h), rel=1e-5)
    assert found.errors[0] < 1e-5


@pytest.mark.parametrize("value", [1e-20, 1e-14, 1e-9])
def test_a_parameter_next_to_zero_has_the_derivative_of_one_at_zero(value):
    names = ("PatternMap.values.0",)
    at, near = (sensitivity(simulate(pulled_scene((v, 1.0, 0.1, 0.7))), to=names) for v in (0.0, value))
    np.testing.assert_allclose(near.derivatives, at.derivatives, rtol=1e-6, atol=1e-15)  # the index is 1


def test_a_hidden_thickness_is_found_from_the_outline():
    hidden = simulate(smooth_scene(thickness=0.23))
    found = fit(smooth_scene(), {1.0: hidden.pial()}, ("Body.thickness",), bounds=(0.15, 0.3))
    assert found.values[0] == pytest.approx(0.23, rel=1e-3)
    assert found.scene.body.thickness == found.values[0]


def test_a_hidden_tension_map_is_found_from_the_outline():
    hidden = simulate(pulled_scene())
    names = [f"PatternMap.values.{k}" for k in range(4)]
    found = fit(pulled_scene((0.5, 0.5, 0.5, 0.5)), {1.0: hidden.pial()}, names, bounds=(0.0, 1.5))
    assert np.abs(found.values - [0.2, 1.0, 0.1, 0.7]).max() < 1e-2


def test_a_thickness_that_the_mesh_has_is_refused():
    sharp = replace(smooth_scene(), body=semicircle(radius=1.0, thickness=0.2, elements=2, base="roller"))
    with pytest.raises(ValueError, match=r'Body\.thickness: .* layers="sigmoid"'):
        sensitivity(simulate(replace(sharp, until=0.2)), to=("Body.thickness",))
    scene = pulled_scene()
    smooth = replace(scene, body=semicircle(radius=1.0, thickness=0.2, elements=2, layers="sigmoid"))
    with pytest.raises(ValueError, match=r"Body\.thickness: PatternMap acts on the cortex that the mesh has"):
        sensitivity(simulate(replace(smooth, until=0.2)), to=("Body.thickness",))


def test_a_thickness_is_refused_where_a_solvent_comes_from_the_interface():
    scene = smooth_scene()
    wet = Swelling(coefficient=0.1, diffusivity=0.1, source="interface")
    result = simulate(replace(scene, processes=(wet, *scene.processes), until=0.2))
    with pytest.raises(ValueError, match=r"Body\.thickness: Swelling"):
        sensitivity(result, to=("Body.thickness",))


def test_a_pattern_has_its_values_at_their_places_and_runs_straight_between_them():
    body = semicircle(radius=1.0, thickness=0.2, elements=2)
    given = PatternMap(values=(0.0, 1.0, 0.5), places=(0.0, 0.5, 1.0))
    pattern = given.on(body).start(State(0.0), 0)["pattern"]
    x, y = body.nodes[:, body.cortex.nodes]
    share = np.arctan2(y, x) / np.pi  # of the surface, from the right end on
    expected = np.interp(share, (0.0, 0.5, 1.0), (0.0, 1.0, 0.5))
    assert np.abs(pattern - expected).max() < 1e-3  # the surface is quadratic, not round
    near = PatternMap(values=(0.0, 1.0), between="nearest").on(body).start(State(0.0), 0)["pattern"]
    assert set(near.tolist()) == {0.0, 1.0}


def test_what_is_no_pattern_is_refused():
    with pytest.raises(ValueError, match="two or more numbers"):
        PatternMap(values=(1.0,))
    with pytest.raises(ValueError, match="values"):
        PatternMap(values=(1.0, float("nan")))
    with pytest.raises(ValueError, match="give one per place"):
        PatternMap(values=(1.0, 0.5), places=(0.1, 0.2, 0.3))
    part = half(semicircle(radius=1.0, thickness=0.2, elements=2))
    with pytest.raises(ValueError, match=r"PatternMap: its 2 values .* places=\(0, 0\.5\)"):
        PatternMap(values=(1.0, 0.5)).on(part)
    for one in (PatternMap, GrowthMap):
        law = one(**{"values" if one is PatternMap else "cortex": (1.0, 1.5)}, places=(0.0, 0.5))
        assert law.on(part)
