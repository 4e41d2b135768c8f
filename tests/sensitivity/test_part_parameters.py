"""All parts pass the examination of their parameters, and those that are wrong do not."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from small import folding_scene

from turingfold import (
    AxonalTension,
    BoundaryLoads,
    Elastic,
    GrowthMap,
    Imperfection,
    NeoHookean,
    PatternMap,
    RateGrowth,
    Scene,
    Stepping,
    TangentialGrowth,
    Window,
    Zone,
    half,
    semicircle,
    simulate,
)
from turingfold.extend import Evaluation, Operator, Potential, Term
from turingfold.geometry.body import by_node
from turingfold.testing import check_parameters

SOFT = NeoHookean(mu=1.0, kappa=5.0)
PLACES = (0.0, 0.25, 0.5)
ZONE = Zone(region=Window(start=0.35, end=0.65, edge=0.05), growth=1.3, thickness=0.6)


def body(layers="sharp"):
    return half(semicircle(radius=1.0, thickness=0.25, elements=2, layers=layers))


SOLID = Elastic(gray=SOFT)


def scene(*processes, terms=(SOLID,), layers="sharp"):
    steps = Stepping(first=0.25, largest=0.25)
    return Scene(body=body(layers), terms=terms, processes=processes, stepping=steps)


NEARLY = Elastic(gray=NeoHookean(mu=1.0, kappa=100.0), white=NeoHookean(mu=2.0, kappa=9.0), element="mixed")
LOADS = BoundaryLoads(places=(0.2,), forces=((0.01, -0.02),), width=0.25)
FOLDING = folding_scene()
CASES = {
    "everything": replace(FOLDING, processes=(*FOLDING.processes, Imperfection(amplitude=0.02))),
    "maps": scene(
        GrowthMap(cortex=(1.2, 1.4, 1.1), places=PLACES), Imperfection(of="moduli"), terms=(NEARLY, LOADS)
    ),
    "pattern": scene(
        PatternMap(values=(0.2, 1.0, 0.4), places=PLACES), TangentialGrowth(cortex=1.3, core=1.1),
        terms=(SOLID, AxonalTension(strength=0.1)),
    ),
    "zones": scene(RateGrowth(rate=0.5, radial_rate=0.1, zones=(ZONE,)), layers="sigmoid"),
}  # fmt: skip
NAMES = {
    "everything": (
        "Elastic.white.kappa", "SelfContact.stiffness", "SelfContact.gap", "Imperfection.amplitude",
        "AxonalTension.strength",
    ),
    "maps": ("GrowthMap.cortex.1", "GrowthMap.places.1", "BoundaryLoads.forces.0.1"),
    "pattern": ("PatternMap.values.0", "PatternMap.values.1", "TangentialGrowth.core"),
    "zones": (),  # all
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_energy_and_forces_change_alike_with_each_parameter(name):
    made, names = CASES[name], NAMES[name]
    end = simulate(made).last
    found = check_parameters(made, by_node(end["displacement"]), step=1e-4 * made.body.length, names=names)
    zones = {"RateGrowth.rate", "RateGrowth.zones.0.growth", "RateGrowth.zones.0.thickness", "Body.thickness"}
    assert found == names or zones <= set(found)


@dataclass(frozen=True)
class Pull(Term):
    """An energy a u·u/2 of the nodes, and forces of one's choice."""

    amount: float = 1.0
    power: float = 1.0  # of the amount, in the forces; 1 is right
    grain: float = 0.0
    reads = ()

    def on(self, body):
        return PullOnBody(self)


class PullOnBody(Operator):
    reads = ()

    def __init__(self, term):
        self.term = term

    def during(self, state, step):
        return PullPotential(self.term)


class PullPotential(Potential):
    def __init__(self, term):
        self.term = term

    def evaluate(self, x):
        return PullEvaluation(self.term, x)


class PullEvaluation(Evaluation):
    def __init__(self, term, x):
        self.term, self.x = term, x

    @property
    def energy(self):
        return 0.5 * self._of(1.0) * float(self.x @ self.x)

    has_hessian = False

    def hessian(self, convexity):
        raise NotImplementedError

    def _of(self, power):
        term = self.term
        return term.amount**power + term.grain * abs(term.amount - 1.0004)

    def gradient(self):
        return self._of(self.term.power) * self.x, np.abs(self.x)


def examined(pull):
    made = scene(TangentialGrowth(cortex=1.2), terms=(Elastic(gray=SOFT), pull))
    x = 1e-3 * np.random.default_rng(0).standard_normal(made.body.nodes.size)
    return check_parameters(made, x, step=1e-3, names=("Pull.amount",))


def test_parts_that_are_wrong_do_not_pass():
    assert examined(Pull()) == ("Pull.amount",)
    with pytest.raises(AssertionError, match=r"Pull\.amount changes forces otherwise than the energy"):
        examined(Pull(power=2.0))
    with pytest.raises(AssertionError, match=r"Pull\.amount changes no force"):
        examined(Pull(power=0.0))
    with pytest.raises(AssertionError, match=r"Pull\.amount does not act smoothly"):
        examined(Pull(grain=1.0, power=1.0 + 1e-12))
