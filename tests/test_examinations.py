"""Every process and every kinetics of the package, and damping, pass the examinations for parts of one's own.

The other terms do so beside their own tests, at displacements in which they act.
"""

import numpy as np
import pytest

import turingfold
from turingfold import (
    Elastic,
    EvolvingTuring,
    GrowthMap,
    GrowthTable,
    Imperfection,
    NeoHookean,
    PatternMap,
    RateGrowth,
    SeededPattern,
    StiffnessDamping,
    StressGrowth,
    Swelling,
    TangentialGrowth,
    Turing,
    VolumeGrowth,
    semicircle,
)
from turingfold.extend import GrowthLaw, Kinetics, Process, State
from turingfold.testing import check_kinetics, check_process, check_term, taylor_order
from turingfold.turing.kinetics.named import KINETICS

PATTERN = Turing(KINETICS["Schnakenberg"](), half_waves=4)
PROCESSES = [
    PATTERN,
    EvolvingTuring(PATTERN, pace=10.0),
    SeededPattern(
        KINETICS["GrayScott"](F=0.04, k=0.06),
        d_u=2e-6,
        d_v=1e-6,
        disturbed=(0.5, 0.25),
        places=(0.5,),
        width=0.02,
    ),
    TangentialGrowth(cortex=1.5, core=1.1, radial_core=1.2, swelling_core=1.1, modulation=0.5, thinning=0.2),
    GrowthMap(cortex=(1.2, 1.6, 1.3)),
    PatternMap(values=(0.2, 1.0, 0.4)),
    GrowthTable(at=(28.0, 40.0), cortex=((1.0, 1.0), (1.5, 1.8)), places=(0.2, 0.7), of="area"),
    RateGrowth(out_of_plane="tangential"),
    Swelling(coefficient=0.5, diffusivity=1e-4, source="pial"),
    StressGrowth(rate=1e-3),
    VolumeGrowth(rate=0.5),
    Imperfection(of="growth"),
    Imperfection(of="moduli"),
]


def public(kind):
    """Return the parts of a kind among the public names."""
    named = [getattr(turingfold, name) for name in turingfold.__all__]
    return {one for one in named if isinstance(one, type) and issubclass(one, kind)}


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=0.04, thickness=0.008, elements=3, layers="sigmoid")


def test_all_are_examined():
    assert {type(process) for process in PROCESSES} == public(Process) - {GrowthLaw}
    assert set(KINETICS.values()) == public(Kinetics) - {turingfold.UserKinetics, Kinetics}


@pytest.mark.parametrize("process", PROCESSES, ids=lambda process: type(process).__name__)
def test_processes(body, process):
    rng, points = np.random.default_rng(0), body.quadrature.weights.shape
    fields = {
        "displacement": 0.02 * body.nodes,
        "pattern": rng.uniform(0, 1, len(body.cortex.nodes)),
        "growth": rng.uniform(0.9, 1.4, (3, *points)),
        "cauchy_stress": 50 * rng.standard_normal((4, *points)),
        "moduli": rng.uniform(100, 900, (2, *points)),
        "elastic_volume": rng.uniform(0.9, 1.1, points),
    }
    state = State(0.1, {name: fields[name] for name in (*process.reads, *process.optional)})
    check_process(process, body, state, 0.1, seed=3)


@pytest.mark.parametrize("kinetics", KINETICS.values(), ids=lambda kind: kind.__name__)
def test_kinetics(kinetics):
    u, v = np.random.default_rng(1).uniform(0.2, 2.0, (2, 40))
    check_kinetics(kinetics(), u, v)


def test_damping(body):
    elastic = Elastic(gray=NeoHookean(mu=476.0, kappa=5551.0))
    old = 1e-4 * np.random.default_rng(2).standard_normal(body.nodes.shape)
    samples = 1e-4 * np.random.default_rng(3).standard_normal((2, body.nodes.size))
    # forces that do not turn with the body have a moment about the deformed one, and are those of a way
    check_term(
        StiffnessDamping(elastic=elastic, time=0.1), body, State(0.1, {"displacement": old}), samples,
        step=1e-3, moment=False, objective=False, other=StiffnessDamping(elastic=elastic, time=0.2),
    )  # fmt: skip


def test_an_order_is_taken_above_round_off_and_a_jump_is_none():
    noise = np.random.default_rng(0)
    rounded = taylor_order(lambda h: 3.0 * h**2 + 3e-13 * noise.uniform(-1, 1), size=1.0, step=1e-3)
    assert rounded == pytest.approx(2.0, abs=0.02)
    wrong = taylor_order(lambda h: 3.0 * h**2 + 1e-4 * h, size=1.0, step=1e-3)
    assert wrong < 1.5
    with pytest.raises(AssertionError, match="it jumps by 1e-08 of 1"):
        taylor_order(lambda h: h**2 + 1e-8, size=1.0, step=1e-3)
