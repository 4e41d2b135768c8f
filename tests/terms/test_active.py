"""Active tangential stress of a layer."""

import numpy as np
import pytest

from turingfold.errors import MissingFieldError
from turingfold.geometry.shapes import semicircle
from turingfold.parts import TimeStep
from turingfold.scene import Scene
from turingfold.solve.march import begin, march
from turingfold.state import State
from turingfold.terms.active import ActiveStress
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import check_term, dense


def body(size=0.1, **options):
    return semicircle(radius=1.0, thickness=0.2, size=size, **options)


def samples(made, count=2):
    random = np.random.default_rng(4)
    return [0.01 * random.standard_normal(2 * made.nodes.shape[1]) for _ in range(count)]


def test_examination():
    made = body()
    pattern = np.linspace(0.2, 1.0, len(made.cortex.nodes))
    check_term(
        ActiveStress(stress=3.0, follows_pattern=True), made, State(0.3, {"pattern": pattern}), samples(made),
        step=0.05, other=ActiveStress(stress=4.0),
    )  # fmt: skip


def test_pushing_is_made_convex_on_request():
    made = body(0.2)
    potential = ActiveStress(stress=-2.0).on(made).during(State(1.0), TimeStep(1.0))
    here = potential.evaluate(samples(made, 1)[0])
    assert np.linalg.eigvalsh(dense(here.hessian(0.0), 2 * made.nodes.shape[1]))[0] < -1e-3
    assert not here.hessian(1.0).values.any()


def test_energy_of_a_uniform_stretch():
    """x = (1+e) X stretches every tangent by 1+e: σ/2 ((1+e)² - 1) times the area of half an annulus."""
    made, e, stress = body(0.02), 0.1, 5.0
    potential = ActiveStress(stress=stress, depth=(0.0, 1.0)).on(made).during(State(1.0), TimeStep(1.0))
    area = 0.5 * np.pi * (1.0 - 0.8**2)
    energy = potential.evaluate(e * made.nodes.T.ravel()).energy
    assert energy == pytest.approx(0.5 * stress * ((1 + e) ** 2 - 1) * area, rel=1e-6)


def test_a_pulling_layer_shortens():
    made = body(base="roller")
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    scene = Scene(body=made, terms=(solid, ActiveStress(stress=2.0, depth=(0.0, 1.0))))
    for step, _ in march(scene, begin(scene)):
        x = made.nodes + step.state["displacement"]
    line = x[:, made.pial]
    length = np.hypot(*np.diff(line)).sum()
    rest = np.hypot(*np.diff(made.nodes[:, made.pial])).sum()
    assert length < 0.98 * rest


def test_needs_a_pattern_only_if_it_follows_one():
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    with pytest.raises(MissingFieldError, match="pattern"):
        Scene(body=body(), terms=(solid, ActiveStress(stress=1.0, follows_pattern=True)))
    assert ActiveStress(stress=1.0).reads == ()


@pytest.mark.parametrize("depth", [(1.0, 1.0), (-0.5, 1.0), (2.0, 1.0), (0.0, float("nan")), (1.0, 2.0, 3.0)])
def test_bad_depths(depth):
    with pytest.raises(ValueError, match="depth"):
        ActiveStress(stress=1.0, depth=depth)


def test_a_layer_below_the_body():
    with pytest.raises(ValueError, match="thicker"):
        ActiveStress(stress=1.0, depth=(20.0, 21.0)).on(body())
