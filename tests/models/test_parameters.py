"""Parameters of a case: what its signature declares, what they accept, and what is said of the rest."""

from typing import Annotated, Literal

import pytest

from turingfold import Parameter, conditions, human, kinetics_named, semicircle, semiellipse
from turingfold import parameters as p
from turingfold.models.declared import declared, find, values_of
from turingfold.turing.kinetics.named import KINETICS


@p.quick(elements=2)
def scenes(
    quick=False,
    *,
    thickness: p.Thickness = 2.5e-3,
    elements: p.Elements = 6,
    cortex: p.Cortex = 1.9,
    young: p.YoungGray = 1389.0,
    half_waves: p.HalfWaves = 24,
    base: p.Base = "clamped",
    tension: p.Tension = True,
    form: Annotated[Literal["first", "second"], Parameter(label="which form")] = "first",
    plain: float = 1,
):
    return {"quick": quick, "thickness": thickness, "elements": elements}


KNOWN = declared(scenes)


def test_a_signature_says_names_kinds_defaults_and_meanings():
    assert list(KNOWN)[:2] == ["thickness", "elements"]
    thick = KNOWN["thickness"]
    assert (thick.kind, thick.default, thick.meaning.unit) == (float, 2.5e-3, "m")
    assert thick.range == "0.0001 to 0.02 m"
    assert KNOWN["tension"].range == "on | off"
    assert KNOWN["base"].range == "clamped | roller | free"
    assert (KNOWN["plain"].kind, KNOWN["plain"].range) == (float, "a number")
    assert KNOWN["form"].range == "first | second"


def test_the_quick_version_has_other_defaults_and_what_is_given_wins():
    assert scenes()["elements"] == 6
    assert scenes(quick=True)["elements"] == 2
    assert scenes(quick=True, elements=6)["elements"] == 6  # the default of the full version, but asked for
    assert values_of(scenes, {"thickness": 3e-3}, quick=True)["elements"] == 2
    assert values_of(scenes, {}, quick=False)["elements"] == 6


@pytest.mark.parametrize(
    ("name", "text", "values"),
    [
        ("thickness", "2e-3:4e-3:3", [2e-3, 3e-3, 4e-3]),
        ("thickness", "2.5e-3", [2.5e-3]),
        ("half_waves", "8:24:3", [8, 16, 24]),
        ("half_waves", "1e1", [10]),
        ("tension", "on,off,true,false", [True, False, True, False]),
        ("base", "roller,free", ["roller", "free"]),
    ],
)
def test_texts_are_read_in_the_kind_of_the_parameter(name, text, values):
    found = KNOWN[name].read_list(text)
    assert found == pytest.approx(values) if name == "thickness" else found == values
    assert {type(value) for value in found} == {KNOWN[name].kind}


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("thickness", "2.5", ("0.0001 to 0.02 m", "thickness of the cortex", "2.5 mm are 0.0025")),
        ("young", "0.5", ("young=0.5", "1 to 1e+06 Pa", "0.5 kPa are 500")),
        ("cortex", "90", ("cortex=90", "0.3 to 5", "1.9 growth by 90 per cent")),
        ("cortex", "0.09", ("cortex=0.09", "0.3 to 5", "1 is no growth")),
        ("thickness", "thin", ("thickness=thin", "a number in m")),
        ("thickness", "nan", ("thickness=nan", "a number")),
        ("half_waves", "8.5", ("half_waves=8.5", "whole number", "24")),
        ("half_waves", "8:9:3", ("half_waves=8.5", "whole number")),
        ("half_waves", "8:9:0", ("half_waves=8:9:0", "lists no value")),
        ("half_waves", "8:24:-3", ("half_waves=8:24:-3", "lists no value")),
        ("thickness", "2e-3:4e-3:20000000000", ("lists 20000000000 values", "at most 100000", "give fewer")),
        ("thickness", "2e-3:inf:3", ("2e-3:inf:3: the last value is inf", "two finite numbers")),
        ("thickness", "-inf:2e-3:3", ("the first value is -inf", "two finite numbers")),
        ("half_waves", "8:9", ("half_waves=8:9", "FIRST:LAST:COUNT")),
        ("tension", "maybe", ("tension=maybe", "on or off")),
        ("base", "rollers", ("base=rollers", "clamped, roller, free", "did you mean roller?")),
        ("form", "third", ("form=third", "first, second")),
    ],
)
def test_what_a_parameter_cannot_be_is_said_with_name_value_bound_and_remedy(name, text, words):
    with pytest.raises(ValueError, match=f"^{name}=") as failure:
        KNOWN[name].read_list(text)
    for word in words:
        assert word in str(failure.value)
    assert "?." not in str(failure.value)


def test_a_whole_number_that_the_case_may_choose_is_said_so():
    def scenes(quick=False, *, waves: p.HalfWaves = None):
        return {}

    with pytest.raises(ValueError, match=r"^waves=7\.5 must be a whole number, or auto\.$"):
        declared(scenes)["waves"].read("7.5")


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match=r"thicknes; did you mean thickness\?; it has: thickness, "):
        find(KNOWN, "thicknes")
    with pytest.raises(ValueError, match=r"no parameter radius: its scenes\(\) takes none"):
        find(declared(lambda quick=False: {}), "radius")


def test_what_cannot_be_a_parameter_is_refused():
    def without_default(quick=False, *, radius: float):
        return {}

    def of_no_kind(quick=False, *, sizes: list = ()):
        return {}

    for function in (without_default, of_no_kind):
        with pytest.raises(ValueError, match="a parameter of a case has a default, and is a number"):
            declared(function)
    with pytest.raises(ValueError, match="low=2"):
        Parameter("m", 2, 1)
    with pytest.raises(ValueError, match="choices='ab'"):
        Parameter(choices="ab")
    with pytest.raises(ValueError, match="no parameter element; did you mean elements"):
        p.quick(element=2)(scenes)


@pytest.mark.parametrize("name", KINETICS)
def test_kinetics_have_names(name):
    assert type(kinetics_named(name)).__name__ == name
    assert kinetics_named(name) == KINETICS[name]()


@pytest.mark.parametrize(
    ("radius", "thickness", "count"),
    # π R/T over the figure's π 40.4/2.5/24 = 2.115: 24, 12, 17.8 and 8.9
    [(0.0404, 2.5e-3, 24), (0.0404, 5e-3, 12), (0.03, 2.5e-3, 18), (0.03, 5e-3, 8)],
)
def test_half_waves_keep_their_width_in_thicknesses_of_the_cortex(radius, thickness, count):
    for elements in (1, 2):
        body = semicircle(radius=radius, thickness=thickness, elements=elements)
        assert human.half_waves(body) == count
    ellipse = semiellipse(width=0.0808, height=0.0299, thickness=2.5e-3, elements=1)
    assert human.half_waves(ellipse, width=2.22) == 20  # Figure 2


def test_a_parameter_may_be_chosen_by_the_others():
    def scenes(quick=False, *, half_waves: p.HalfWaves = None):
        return {}

    known = declared(scenes)["half_waves"]
    assert (known.kind, known.shown(None), known.read("auto"), known.read("8")) == (int, "auto", None, 8)
    assert known.checked(None) is None
    with pytest.raises(ValueError, match="must be a whole number"):
        KNOWN["half_waves"].read("auto")


def test_kinetics_by_name_take_parameters():
    # Schnakenberg's steady state is (a + b, b/(a + b)²)
    made = kinetics_named("Schnakenberg", a=0.2, b=1.0)
    assert conditions(made, 1.0, 30.0).steady_state == pytest.approx((1.2, 1 / 1.44))
    with pytest.raises(ValueError, match="no parameter 'c'; it has a, b"):
        kinetics_named("Schnakenberg", c=1.0)
