"""Inertia and drag: energy and momentum balances, and the quasi-static limit."""

from itertools import pairwise

import numpy as np
import pytest

from turingfold.geometry.shapes import semicircle
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import TimeStep
from turingfold.scene import Scene
from turingfold.solve.march import Progress, begin, march
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.dynamics import Drag, Inertia, mass
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic


def free_body():
    return semicircle(radius=1.0, thickness=0.3, size=0.3, base="free")


def motion(scheme, dt, until=2.0, body=None):
    """March a free body that starts to spin and to stretch; return the body, its steps and the mass."""
    body = body or free_body()
    x, y = body.nodes
    velocity = np.stack([0.3 * x - 0.2 * y, 0.2 * x - 0.3 * y + 0.1])
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    scene = Scene(
        body=body,
        terms=(solid, Inertia(density=1.0)),
        until=until,
        stepping=Stepping(first=dt / until, largest=dt / until, tolerance=1e-12, scheme=scheme),
    )
    start = begin(scene)
    start = Progress(start.state.updated(velocity=velocity), start.dt)
    steps = [step for step, _ in march(scene, start)]
    assert all(abs(step.numbers["step"] - dt) < 1e-12 for step in steps)
    return body, steps, mass(body, 1.0).whole, velocity


def energies(steps, M, velocity):
    """Elastic plus kinetic energy at the start (no strain) and after each step."""
    start = velocity.T.ravel()
    total = [0.5 * start @ (M @ start)]
    for step in steps:
        total.append(step.at.evaluations[0].energy + step.numbers["kinetic_energy"])
    return np.array(total)


def test_mass_of_a_half_disc():
    body = semicircle(radius=2.0, thickness=0.5, size=0.25)
    M = mass(body, 3.0).whole
    ones = np.zeros(2 * body.nodes.shape[1])
    ones[0::2] = 1.0
    # the isoparametric half circle of this mesh has its area to 5e-7: quadratic sides
    assert ones @ M @ ones == pytest.approx(3.0 * np.pi * 2.0, rel=1e-6)


def test_midpoint_energy_error_falls_fourfold():
    errors = []
    for dt in (0.05, 0.025, 0.0125):
        _, steps, M, velocity = motion("midpoint", dt, until=1.0)
        total = energies(steps, M, velocity)
        errors.append(np.abs(total - total[0]).max() / total[0])
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (ratios > 3.4).all(), errors
    assert (ratios < 4.8).all(), errors


def test_backward_euler_never_gains_energy():
    _, steps, M, velocity = motion("euler", 0.1)
    total = energies(steps, M, velocity)
    assert (np.diff(total) < 0).all()


@pytest.mark.parametrize("scheme", ["midpoint", "euler"])
def test_momentum_of_a_free_body(scheme):
    _, steps, M, velocity = motion(scheme, 0.1)
    first = velocity.T.ravel()
    scale = np.abs(M @ first).sum()
    for step in steps:
        now = step.state["velocity"].T.ravel()
        change = (M @ (now - first)).reshape(-1, 2).sum(0)
        assert np.abs(change).max() < 1e-12 * scale


def test_midpoint_angular_momentum_of_a_free_body():
    body, steps, M, velocity = motion("midpoint", 0.1)

    def spin(positions, velocity):
        px, py = (M @ velocity.T.ravel()).reshape(-1, 2).T
        return float(positions[0] @ py - positions[1] @ px)

    start = spin(body.nodes, velocity)
    for step in steps:
        now = spin(body.nodes + step.state["displacement"], step.state["velocity"])
        assert now == pytest.approx(start, rel=1e-10)


def test_drag_slows_towards_the_static_state():
    """u' = -(K/c) u: the step of backward Euler divides each mode by 1 + dt K/c."""
    body = semicircle(radius=1.0, thickness=0.3, size=0.3)
    solid, drag = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), Drag(coefficient=2.0)
    n = body.nodes.shape[1]
    rng = np.random.default_rng(1)
    x, old = 1e-6 * rng.standard_normal((2, 2 * n))
    dt = 0.3
    potential = drag.on(body).during(State(dt, {"displacement": old.reshape(-1, 2).T}), TimeStep(dt))
    force, _ = potential.evaluate(x).gradient()
    assert force == pytest.approx(mass(body, 2.0).whole @ (x - old) / dt, rel=1e-12)
    scene = Scene(body=body, terms=(solid, drag), until=50.0)
    start = begin(scene)
    bump = np.zeros((2, n))
    middle = int(np.argmin(np.hypot(body.nodes[0], body.nodes[1] - 0.5)))
    bump[1, middle] = 0.02
    steps = [s for s, _ in march(scene, Progress(start.state.updated(displacement=bump), start.dt))]
    assert np.abs(steps[-1].state["displacement"]).max() < 1e-6
    assert steps[0].numbers["energy"] > steps[-1].numbers["energy"]


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf"), "heavy", None])
def test_bad_density(bad):
    with pytest.raises(ValueError, match="density"):
        Inertia(density=bad)
    with pytest.raises(ValueError, match="coefficient"):
        Drag(coefficient=bad)


def test_unknown_scheme():
    with pytest.raises(ValueError, match="'euler', 'midpoint'"):
        Stepping(scheme="leapfrog")


@pytest.mark.parametrize(
    "terms",
    [
        (Inertia(density=1.0), Drag(coefficient=0.2)),
        pytest.param((Drag(coefficient=1.0),), marks=pytest.mark.slow),
    ],
)
def test_midpoint_is_of_second_order_with_growth(terms):
    """Growth, like every load, is that of the time at which forces balance."""
    ends = []
    body = semicircle(radius=1.0, thickness=0.3, size=0.3, layers="sigmoid")
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    for steps in (40, 80, 160):  # waves through an element take 0.1
        made = Scene(
            body=body,
            terms=(solid, *terms),
            processes=(TangentialGrowth(cortex=1.3),),
            until=0.4,
            stepping=Stepping(first=1 / steps, largest=1 / steps, tolerance=1e-12, scheme="midpoint"),
        )
        ends.append(list(march(made, begin(made)))[-1][0].x)
    errors = [np.abs(one - other).max() for one, other in pairwise(ends)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)
