"""Kinetics: exact derivatives, steady states, published sets; one examination for all."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from turingfold.turing.kinetics.activator_inhibitor import FitzHughNagumo, GiererMeinhardt, KochMeinhardt
from turingfold.turing.kinetics.base import real_roots
from turingfold.turing.kinetics.bvam import BVAM, BVAM2012
from turingfold.turing.kinetics.chemical import Brusselator, GrayScott, LengyelEpstein, Schnakenberg, Thomas
from turingfold.turing.kinetics.user import UserKinetics
from turingfold.turing.stability import conditions, dispersion, hopf_boundary, turing_unstable_at

ORACLE = json.loads((Path(__file__).parents[1] / "data" / "turing_oracle.json").read_text())

ALL = (
    Schnakenberg(),
    GiererMeinhardt(),
    GiererMeinhardt(a=0.1, b=1.0, c=1.0, K=0.12),
    KochMeinhardt(),
    Brusselator(),
    Thomas(),
    GrayScott(),
    LengyelEpstein(),
    BVAM(),
    BVAM(r1=0.02, r2=0.2),
    BVAM2012(),
    BVAM2012(C=0.4),
    FitzHughNagumo(),
    FitzHughNagumo(e_v=1.0, a_v=2.0, a_z=0.1),  # bistable, not Turing-unstable
)


def name_of(kinetics):
    return f"{type(kinetics).__name__}-{'-'.join(f'{value:g}' for value in kinetics.parameters.values())}"


every = pytest.mark.parametrize("kinetics", ALL, ids=name_of)


def some_states(kinetics, count=7):
    """Return states about the steady one, none of them special."""
    u, v = np.array(conditions(kinetics, 1.0, 1.0).steady_state)
    spread = np.random.default_rng(1).uniform(0.6, 1.4, (2, count))
    away = 0.3 * (u == 0)
    return u * spread[0] + away * (spread[0] - 0.9), v * spread[1] + away * (spread[1] - 1.1)


@every
def test_derivatives_are_those_of_the_rates(kinetics):
    # Taylor: the remainder of the linearisation falls with order 2
    u, v = some_states(kinetics)
    du, dv = 0.1 * (np.abs(u) + 0.1), -0.07 * (np.abs(v) + 0.1)
    p_u, p_v, q_u, q_v = kinetics.derivatives(u, v)
    remainders = []
    for h in (1e-2, 1e-3):
        p, q = np.subtract(kinetics.rates(u + h * du, v + h * dv), kinetics.rates(u, v))
        remainders.append(np.abs([p - h * (p_u * du + p_v * dv), q - h * (q_u * du + q_v * dv)]).max())
    assert np.log10(remainders[0] / remainders[1]) == pytest.approx(2.0, abs=0.05)


@every
def test_rates_vanish_at_every_steady_state(kinetics):
    states = kinetics.steady_states()
    assert len(set(states)) == len(states) >= 1
    for u, v in states:
        at = np.array([u]), np.array([v])
        scale = 1e-30 + sum(np.abs(d).max() for d in kinetics.derivatives(*at)) * (1 + abs(u) + abs(v))
        assert np.abs(kinetics.rates(*at)).max() < 1e-13 * scale


@every
def test_no_steady_state_is_missed(kinetics):
    # Newton's method from a grid of starts finds no other one
    known = kinetics.steady_states()
    reach = 3 * max(max(abs(u), abs(v)) for u, v in known) + 1
    low = 0.01 * reach if kinetics.non_negative else -reach
    starts = [(u, v) for u in np.linspace(low, reach, 7) for v in np.linspace(low, reach, 7)]
    with np.errstate(all="ignore"):
        search = UserKinetics(
            p=lambda u, v: kinetics.rates(u, v)[0], q=lambda u, v: kinetics.rates(u, v)[1],
            partial_derivatives=kinetics.derivatives, guesses=tuple(starts),
        )  # fmt: skip
        found = search.steady_states()
    inside = [s for s in found if not kinetics.non_negative or min(s) > 0]
    assert len(inside) >= 1
    for u, v in inside:
        assert min(np.hypot(u - a, v - b) for a, b in known) < 1e-6 * reach


@every
def test_the_wrong_sign_and_nan_are_refused(kinetics):
    for name in kinetics.parameters:
        values = {**kinetics.parameters, name: float("nan")}
        with pytest.raises(ValueError, match=rf"{type(kinetics).__name__}: {name}=nan must be"):
            type(kinetics)(**values)
        if name not in kinetics.any_sign:
            with pytest.raises(ValueError, match=rf"{name}=-1 must be positive"):
                type(kinetics)(**{**kinetics.parameters, name: -1.0})


ORACLE_CLASSES = {
    "schnakenberg": Schnakenberg,
    "gierer_meinhardt": GiererMeinhardt,
    "brusselator": Brusselator,
    "bvam": BVAM,
    "gray_scott": GrayScott,
    "lengyel_epstein": LengyelEpstein,
    "fitzhugh_nagumo": lambda a, b, tau, k: FitzHughNagumo(e_v=1 / tau, a_v=1.0, a_z=0.0, kappa=k),
}


def oracle_kinetics(case):
    family = case["name"].split("/")[0]
    drop = {"bvam": ("D", "delta"), "lengyel_epstein": ("c",)}.get(family, ())
    return ORACLE_CLASSES[family](**{k: float(v) for k, v in case["params"].items() if k not in drop})


@pytest.mark.parametrize("case", ORACLE["cases"], ids=lambda case: case["name"])
def test_conditions_agree_with_the_oracle(case):
    found = conditions(oracle_kinetics(case), float(case["Du"]), float(case["Dv"]))
    assert found.unstable is case["turing_unstable"]
    assert found.activator == case["activator"]
    expected = {
        "steady_state": [case["u0"], case["v0"]], "jacobian": case["J"], "ratio": case["d"],
        "critical_ratio": case["d_c"], "critical_k2": case["k_c2_at_d_c"],
        "band": [case["k2_minus"], case["k2_plus"]], "fastest_k2": case["k2_fastest"],
        "fastest_rate": case["lambda_max"],
    }  # fmt: skip
    for name, value in expected.items():
        wanted = np.array(value, dtype=float)
        assert np.allclose(getattr(found, name), wanted, rtol=1e-10, atol=1e-10), name
    assert found.checks[0].value == pytest.approx(float(case["trace"]), abs=1e-10)
    assert found.checks[1].value == pytest.approx(float(case["det"]), abs=1e-10)
    direction = found.fastest_direction
    slope = direction[1] / direction[0]
    assert slope == pytest.approx(float(case["dv_over_du_fastest"]), rel=1e-10)


def test_published_thresholds():
    # Murray's Thomas set; VisualPDE's Brusselator page: A²/(√B − 1)²; Leppänen's wave numbers 0.45 and 0.84
    assert conditions(Thomas(), 1.0, 30.0).critical_ratio == pytest.approx(27.015, abs=5e-4)
    assert conditions(Brusselator(A=2, B=3), 1.0, 8.0).critical_ratio == pytest.approx(4 / (3**0.5 - 1) ** 2)
    first = conditions(BVAM(), 2 * 0.516, 2.0)
    second = conditions(BVAM(alpha=0.398, beta=-0.4, gamma=-0.398, r1=0.02, r2=0.2), 2 * 0.122, 2.0)
    assert first.fastest_k2**0.5 == pytest.approx(0.45, abs=0.006)
    assert second.fastest_k2**0.5 == pytest.approx(0.84, abs=0.006)


@every
def test_dispersion_is_the_largest_eigenvalue(kinetics):
    d_u, d_v = 0.7, 9.0
    found = conditions(kinetics, d_u, d_v)
    k2 = np.linspace(0.0, 3.0, 13)
    eigen = [np.linalg.eigvals(found.jacobian - q * np.diag([d_u, d_v])).real.max() for q in k2]
    assert np.allclose(dispersion(kinetics, d_u, d_v, k2), eigen, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kinetics", ALL[:-1], ids=name_of)
def test_the_growing_band_and_its_fastest_mode(kinetics):
    assert turing_unstable_at(kinetics).unstable  # at the published ratio
    found = turing_unstable_at(kinetics, 1.3 * turing_unstable_at(kinetics).critical_ratio)
    assert found.unstable
    low, high = found.band
    around = dispersion(kinetics, found.d_u, found.d_v, [0.99 * low, 1.01 * low, 0.99 * high, 1.01 * high])
    assert (np.sign(around) == [-1, 1, 1, -1]).all()
    peak = dispersion(kinetics, found.d_u, found.d_v, found.fastest_k2 * np.array([0.999, 1.0, 1.001]))
    assert peak[1] == pytest.approx(found.fastest_rate)
    assert peak[1] > peak[[0, 2]].max()


def test_at_the_critical_ratio_the_band_closes_on_the_critical_wave_number():
    ratio = conditions(Schnakenberg(), 1.0, 10.0).critical_ratio
    found = conditions(Schnakenberg(), 1.0, ratio * (1 + 1e-10))
    assert found.band[1] / found.band[0] == pytest.approx(1.0, abs=1e-4)
    assert found.fastest_k2 == pytest.approx(found.critical_k2, rel=1e-4)
    assert not conditions(Schnakenberg(), 1.0, ratio * (1 - 1e-10)).unstable


def test_functions_that_do_not_take_arrays_are_refused_with_the_remedy():
    good = {"p": lambda u, v: 0.1 - u + u * u * v, "q": lambda u, v: 0.9 - u * u * v}
    guesses = ((1.0, 0.9),)
    with pytest.raises(ValueError, match=r"p\(u, v\) failed .* TypeError.* np\.exp in place of math\.exp"):
        UserKinetics(p=lambda u, v: math.exp(u), q=good["q"], guesses=guesses)
    with pytest.raises(ValueError, match=r"q\(u, v\) failed .* np\.where in place of if"):
        UserKinetics(p=good["p"], q=lambda u, v: -v if u > 0 else v, guesses=guesses)
    with pytest.raises(ValueError, match=r"p\(u, v\) has shape \(\); it must be \(3,\)"):
        UserKinetics(p=lambda u, v: 1.0, q=good["q"], guesses=guesses)
    with pytest.raises(ValueError, match=r"partial_derivatives\(u, v\) failed"):
        UserKinetics(**good, guesses=guesses, partial_derivatives=lambda u, v: math.sqrt(u))
    # lists of numbers are as good as arrays
    lists = UserKinetics(
        p=lambda u, v: [0.1 - a + a * a * b for a, b in zip(u, v, strict=True)],
        q=lambda u, v: [0.9 - a * a * b for a, b in zip(u, v, strict=True)],
        guesses=guesses,
    )
    assert np.allclose(lists.steady_states(), Schnakenberg().steady_states())
    assert np.allclose(lists.jacobian((1.0, 0.9)), Schnakenberg().jacobian((1.0, 0.9)), atol=1e-8)


def test_hopf_boundary_of_the_brusselator():
    # tr J = B − 1 − A²
    assert hopf_boundary(Brusselator(A=2.0), "B", (1.0, 10.0)) == pytest.approx(5.0, rel=1e-12)
    with pytest.raises(ValueError, match="no Hopf boundary"):
        hopf_boundary(Brusselator(A=2.0), "B", (1.0, 2.0))
    with pytest.raises(ValueError, match="parameter='C' must be one of 'A', 'B'"):
        hopf_boundary(Brusselator(), "C", (1.0, 2.0))


def test_gray_scott_has_one_or_three_steady_states():
    assert len(GrayScott(F=0.035, k=0.065).steady_states()) == 1
    assert len(GrayScott().steady_states()) == 3
    with pytest.raises(ValueError, match="FAIL"):
        turing_unstable_at(GrayScott(F=0.035, k=0.065), 2.0)


def test_a_ratio_without_instability_prints_the_four_conditions():
    with pytest.raises(ValueError, match=r"(?s)ratio=5: no pattern grows.*d_v f_u.*FAIL.*critical 8.5676"):
        turing_unstable_at(Schnakenberg(), 5.0)
    assert str(conditions(Schnakenberg(), 1.0, 10.0)).count("pass") == 4


def test_a_ratio_that_does_not_help_is_not_asked_for():
    # a > b: f_u = (b − a)/(a + b) < 0 and g_v = −(a + b)² < 0, so there is no activator and no ratio
    with pytest.raises(ValueError, match=r"^no pattern grows.* take other parameters") as caught:
        turing_unstable_at(Schnakenberg(a=2.0, b=0.1), 5.0)
    assert "nan" not in str(caught.value)
    # f_u = 0.25/0.35 > (a + b)² = 0.1225: the trace is positive at any ratio
    with pytest.raises(ValueError, match=r"^ratio=5: no pattern grows.* take other parameters.*may exist"):
        turing_unstable_at(Schnakenberg(a=0.05, b=0.3), 5.0)


def test_no_steady_state_is_an_error():
    never = UserKinetics(p=lambda u, v: 1 + u * u, q=lambda u, v: v - 1, guesses=((1.0, 1.0), (-2.0, 0.0)))
    with pytest.raises(ValueError, match="no uniform steady state"):
        conditions(never, 1.0, 30.0)


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_diffusivities(value):
    with pytest.raises(ValueError, match="d_v="):
        conditions(Schnakenberg(), 1.0, value)


def test_user_kinetics_equal_the_built_in_ones():
    mine = UserKinetics(
        p=lambda u, v: 0.1 - u + u * u * v, q=lambda u, v: 0.9 - u * u * v, guesses=((1.2, 0.7),)
    )
    found, known = conditions(mine, 1.0, 10.0), conditions(Schnakenberg(), 1.0, 10.0)
    assert found.steady_state == pytest.approx((1.0, 0.9), rel=1e-12)
    assert found.critical_ratio == pytest.approx(
        known.critical_ratio, rel=1e-7
    )  # differences, not derivatives
    assert found.fastest_k2 == pytest.approx(known.fastest_k2, rel=1e-7)


def test_user_kinetics_with_a_wrong_jacobian_are_refused():
    with pytest.raises(ValueError, match="∂q/∂v"):
        UserKinetics(
            p=lambda u, v: 0.1 - u + u * u * v, q=lambda u, v: 0.9 - u * u * v, guesses=((1.0, 0.9),),
            partial_derivatives=lambda u, v: (2 * u * v - 1, u * u, -2 * u * v, u * u),
        )  # fmt: skip
    with pytest.raises(ValueError, match=r"p\(u, v\)"):
        UserKinetics(p=lambda u, v: u * np.nan, q=lambda u, v: v, guesses=((1.0, 0.9),))


def test_real_roots():
    assert real_roots(0.0, 1.0, -3.0, 2.0) == pytest.approx([1.0, 2.0], rel=1e-15)
    assert real_roots(1.0, 0.0, 1.0) == []
    assert real_roots(1.0, -6.0, 11.0, -6.0) == pytest.approx([1.0, 2.0, 3.0], rel=1e-13)
