"""What a scene accepts beside each other, and its unit of stress."""

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from checks import message_names
from small import GRAY, elastic_scene

from turingfold import (
    AxonalTension,
    Drag,
    Elastic,
    Inertia,
    MissingFieldError,
    NeoHookean,
    Scene,
    Schnakenberg,
    SelfContact,
    TangentialGrowth,
    Turing,
    buckling,
    half,
    semicircle,
    simulate,
)
from turingfold.extend import Body, Evolution, GrowthLaw, Load, Operator, Process, State
from turingfold.scene import stress_scale
from turingfold.terms.active import ActiveStress

SOLID = Elastic(gray=GRAY)


@dataclass(frozen=True)
class Gel(Elastic):
    """Another elastic solid."""


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=1.0, thickness=0.25, size=0.5)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (SOLID, Elastic(gray=NeoHookean(mu=2.0, kappa=9.0))),
        (SOLID, Gel(gray=GRAY)),
        (Gel(gray=GRAY), SOLID),
        (SelfContact(), SelfContact(gap=0.2)),
        (Inertia(density=1.0), Inertia(density=2.0)),
        (Drag(coefficient=1.0), Drag(coefficient=2.0)),
        (AxonalTension(strength=1.0, patches=4), AxonalTension(strength=1.0, patches=4)),
        (ActiveStress(stress=1.0), ActiveStress(stress=1.0)),
    ],
    ids=lambda term: type(term).__name__,
)
def test_two_terms_of_a_kind_are_refused(body, one, other):
    with pytest.raises(ValueError, match="terms holds two") as failure:
        Scene(body=body, terms=(one, Drag(coefficient=9.0), other) if type(one) is not Drag else (one, other))
    message_names(failure.value, type(other).__name__, "leave one of the two out")


@dataclass(frozen=True)
class Grows(GrowthLaw):
    """A law by the name of the field that it writes."""

    writes: tuple[str, ...] = ("growth",)
    out_of_plane = "fixed"

    def factors(self, body, state, time):
        return np.ones(body.quadrature.weights.shape), np.ones(body.quadrature.weights.shape)


def test_a_field_that_nobody_reads_is_refused_with_the_nearest_name(body):
    Scene(body=body, terms=(SOLID,), processes=(Grows(),))
    with pytest.raises(ValueError, match="Grows writes the field 'growht'") as failure:
        Scene(body=body, terms=(SOLID,), processes=(Grows(("growht",)),))
    message_names(failure.value, "no other part of the scene reads", "did you mean 'growth'?")
    with pytest.raises(ValueError, match="TangentialGrowth writes the field 'growth'") as failure:
        Scene(body=body, terms=(SelfContact(),), processes=(TangentialGrowth(),))
    message_names(failure.value, "(read: contact_chords, stress_scale)", "keeps")


def test_a_field_that_nobody_writes_is_refused_with_the_nearest_name(body):
    with pytest.raises(MissingFieldError, match="reads the field 'patern'") as failure:
        Scene(body=body, terms=(SOLID, Reads("patern")), processes=(Turing(Schnakenberg()),))
    message_names(failure.value, "did you mean 'pattern'?")


@dataclass(frozen=True)
class Own(Process, Evolution):
    """A process of a user's own, with mistakes that are given to it."""

    start_with: Callable[[Body], Any]
    advance_by: Callable[[State, State], Any] = lambda before, now: {}
    reads: tuple[str, ...] | str = ()
    writes = ("growth",)

    def on(self, body):
        return replace(self, start_with=lambda: self.start_with(body))

    def start(self, state, seed):
        return self.start_with()

    def advance(self, before, now, dt):
        return self.advance_by(before, now)


def ones(body):
    return {"growth": np.ones((3, *body.quadrature.weights.shape))}


def spoilt(before, now):
    before["growth"][:] = 1.3
    return {}


def careless(before, now):
    return {"growth": before["growth"] * (1 + 0 * before["cauchy_stress"][:3])}


@pytest.mark.parametrize(
    ("process", "message"),
    [
        (Own(lambda body: {}), "Own.start made no 'growth'; it makes every field that it declares"),
        (Own(lambda body: {"growth": [1.0, 2.0]}), "Own.start made 'growth' of list; it must be a numpy"),
        (Own(ones, lambda before, now: {"growth": 1.0}), "Own.advance made 'growth' of float; it must be"),
        (Own(ones, careless), r"the state has no field 'cauchy_stress' \(it has: .*\); .* in `reads`"),
        (Own(ones, spoilt), "read-only"),
        (Own(ones, reads="displacement"), r"Own.reads='displacement' must be a tuple of names"),
    ],
)  # fmt: skip
def test_mistakes_in_a_process_are_said_and_change_nothing(process, message):
    with pytest.raises(ValueError, match=message):
        simulate(elastic_scene(process))


@dataclass(frozen=True)
class Law(GrowthLaw):
    """A growth law of a user's own, with mistakes that are given to it."""

    found: Any = None
    out_of_plane: str = "fixed"

    def factors(self, body, state, time):
        return self.found


@dataclass(frozen=True)
class Nowhere(Load):
    """A load that is nothing on a body."""

    def on(self, body):
        return None


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (Law(1.0), r"Law.factors returned 1.0; it must be two arrays"),
        (Law((1.0, 1.0), out_of_plane="tangental"), "out_of_plane='tangental' must be one of"),
        (Law((1.0, 1.0)), r"the field 'growth' has shape \(3,\)"),
    ],
)
def test_mistakes_in_a_growth_law_are_said(law, message):
    with pytest.raises(ValueError, match=message):
        simulate(elastic_scene(law))


def test_a_part_that_is_nothing_on_a_body_is_named(body):
    with pytest.raises(ValueError, match=r"Nowhere.on returned None; .*turingfold.extend.Operator"):
        simulate(Scene(body=body, terms=(SOLID, Nowhere())))


def test_a_state_keeps_its_fields_whatever_is_done_with_the_array():
    array = np.ones((2, 3))
    state = State(0.0, {"displacement": array})
    for kept in (array, state["displacement"], copy.deepcopy(state)["displacement"]):
        with pytest.raises(ValueError, match="read-only"):
            kept[0, 0] = 2.0


@dataclass(frozen=True)
class Reads(Load, Operator):
    """A load without energy that reads one field."""

    field: str

    @property
    def reads(self):
        return (self.field,)

    def on(self, body):
        return self

    def during(self, state, step):
        return None


def test_different_loads_of_a_kind_act_side_by_side(body):
    pulls = AxonalTension(strength=1.0, patches=4), AxonalTension(strength=1.0, patches=4, surface="pial")
    layers = ActiveStress(stress=1.0), ActiveStress(stress=1.0, depth=(0.0, 1.0))
    assert Scene(body=body, terms=(SOLID, *pulls, *layers)).terms == (SOLID, *pulls, *layers)


def test_the_unit_of_stress_is_the_largest_shear_modulus_not_a_load():
    white = NeoHookean(mu=3.0, kappa=5.0)
    assert stress_scale((ActiveStress(stress=50.0), Elastic(gray=GRAY, white=white))) == 3.0
    assert stress_scale((Drag(coefficient=2.0),)) == 1.0


@pytest.mark.parametrize(("call", "name"), [(half, "body"), (buckling, "scene"), (simulate, "scene")])
@pytest.mark.parametrize("given", [None, 3.0, Scene])
def test_what_is_no_body_or_scene_is_refused_by_name(call, name, given):
    with pytest.raises(ValueError, match=f"^{name}="):
        call(given)


def test_half_a_body_cannot_be_halved(body):
    with pytest.raises(ValueError, match="body has a mirror: it is half of a body already"):
        half(half(body))
