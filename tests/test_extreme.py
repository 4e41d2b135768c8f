"""Stiff and extreme scenes: each finishes, or stops with a named reason and a last good state."""
from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshTri1

from turingfold.body import Body
from turingfold.geometry import semiellipse
from turingfold.growth import TangentialGrowth
from turingfold.mechanics.contact import SelfContact
from turingfold.mechanics.elastic import Elastic
from turingfold.mechanics.march import begin, march
from turingfold.mechanics.material import NeoHookean
from turingfold.morphometry.walls import self_intersections
from turingfold.scene import NotConvergedError, Scene, Stepping
from turingfold.tension import AxonalTension

RADIUS, TENSION = 0.0404, 0.5


def scene(
    *, poisson=0.4583, ratio=1.364, share=0.0619, growth=1.9, aspect=1.0, layers=2, tension=TENSION,
    seconds=60.0, unit=1.0,
):
    """Document 1's scene; share: thickness over half the width, ratio: white over gray, unit: m per unit."""
    radius = RADIUS / unit
    thickness = share * radius
    body = semiellipse(
        width=2 * radius, height=aspect * radius, thickness=thickness, size=thickness / layers
    )
    gray, white = (NeoHookean.from_young(young, poisson) for young in (1389.0, 1389.0 * ratio))
    terms = [Elastic(gray=gray, white=white, layers="sharp"), SelfContact()]
    if tension:
        terms.append(AxonalTension(strength=tension / unit, patches=12))
    growing = TangentialGrowth(cortex=growth, layers="sharp")
    return Scene(body=body, terms=tuple(terms), processes=(growing,), stepping=Stepping(seconds=seconds))


def examine(made):
    """March; check every accepted state; return the steps and the error that stopped them, if any."""
    steps, stopped = [], None
    try:
        for step, _ in march(made, begin(made)):
            steps.append(step)
            check(made, step)
    except NotConvergedError as error:
        stopped = error
    if stopped is not None:
        assert stopped.time == (steps[-1].state.time if steps else 0.0)
        assert f"t = {stopped.time:.6g}" in str(stopped)
        assert "Try " in str(stopped)
    return steps, stopped


def check(made, step):
    body, numbers = made.body, step.numbers
    assert all(np.isfinite(values).all() for values in step.state.fields.values())
    assert numbers["min_jacobian"] > 0
    assert numbers["residual"] <= made.stepping.tolerance
    pial = (body.nodes + step.state["displacement"])[:, body.pial]
    assert self_intersections(pial, closed=False) == 0


EASY = {
    "compressible": {"poisson": 0.3},
    "one element": {"layers": 1},
    "thick": {"share": 0.3},
    "no noise, no load": {"tension": 0.0},
    "shrinking to a fifth": {"growth": 0.2},
    "growth of 4": {"growth": 4.0},
    "stiff core": {"ratio": 1e3},
}
HARD = {
    "ten times the tension": {"tension": 10 * TENSION},
    "pushing": {"tension": -TENSION},
    "soft core": {"ratio": 1e-2},
    "very soft core": {"ratio": 1e-3},
    "flat": {"aspect": 0.3, "share": 0.03},
    "steep": {"aspect": 4.0, "share": 0.05},
    "flatter": {"aspect": 0.2, "share": 0.015},
    "steeper": {"aspect": 5.0, "share": 0.05},
    "thin": {"share": 0.01, "layers": 1},
    "hundred times the tension": {"tension": 100 * TENSION},
    "nearly incompressible": {"poisson": 0.499},
    "almost incompressible": {"poisson": 0.499999},
    "twelve elements": {"layers": 12},
}


@pytest.mark.parametrize("name", EASY)
def test_reaches_the_end(name):
    steps, stopped = examine(scene(**EASY[name]))
    assert stopped is None
    assert steps[-1].state.time == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("name", HARD)
def test_finishes_or_says_why_not(name):
    steps, stopped = examine(scene(**HARD[name]))
    assert stopped is not None or steps[-1].state.time == 1.0
    assert steps


def test_time_limit():
    made = replace(scene(), stepping=Stepping(seconds=1e-3))
    steps, stopped = examine(made)
    assert "time limit" in str(stopped)
    assert not steps


def test_binary_units_change_not_one_bit():
    """Lengths in units of 2^-10 m only change exponents, unless some tolerance is an absolute length."""
    metres, _ = examine(scene(layers=1))
    others, _ = examine(scene(layers=1, unit=2.0**-10))
    for one, other in zip(metres, others, strict=True):
        assert one.numbers["newton_iterations"] == other.numbers["newton_iterations"]
        assert np.array_equal(one.state["displacement"], 2.0**-10 * other.state["displacement"])


def test_millimetres_take_the_same_steps_as_metres():
    """The same body in mm, moduli in Pa: line tension and lengths are 1000 times larger, and rounded anew."""
    metres, _ = examine(scene())
    millimetres, _ = examine(scene(unit=1e-3))
    for one, other in zip(metres, millimetres, strict=True):
        assert one.numbers["newton_iterations"] == other.numbers["newton_iterations"]
        assert one.numbers["factorizations"] == other.numbers["factorizations"]
        assert one.state.time == other.state.time
        shift = one.state["displacement"]
        assert 1e-3 * other.state["displacement"] == pytest.approx(shift, abs=1e-7 * RADIUS)


def test_two_runs_give_the_same_bytes():
    one, other = (examine(scene(layers=1))[0][-1] for _ in range(2))
    assert one.state["displacement"].tobytes() == other.state["displacement"].tobytes()


def test_slivers_stretch_as_exactly_as_good_triangles():
    """Triangles 10⁴ times longer than high: growth along them alone stays free of stress."""
    mesh = MeshTri1.init_tensor(np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1e-4, 5))
    sides = {"pial": lambda x: x[1] > 0.99e-4, "base": lambda x: x[1] == 0.0}
    body = Body(mesh.with_boundaries(sides), 0.5e-4, "roller")
    solid = Elastic(gray=NeoHookean(1.0, 5.0))
    growth = TangentialGrowth(cortex=1.3, core=1.3, layers="sharp")
    made = Scene(body=body, terms=(solid,), processes=(growth,))
    for step, _ in march(made, begin(made)):
        assert step.numbers["negative_pivots"] == 0
    stretched = body.nodes[0] + step.state["displacement"][0]
    assert np.ptp(stretched) == pytest.approx(1.3, rel=1e-9)
    assert step.observe()["von_mises"].max() < 1e-7
