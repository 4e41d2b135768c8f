"""The neo-Hookean law: natural state, stress, tangent, parameters, and its linear limit."""

import numpy as np
import pytest
from checks import message_names
from hypothesis import given, settings
from hypothesis import strategies as st

from turingfold.terms.elastic import material
from turingfold.terms.elastic.material import NeoHookean
from turingfold.testing import taylor_order

MU, KAPPA = 476.24, 5551.6


def energy(F: np.ndarray, mu: float = MU, kappa: float = KAPPA) -> float:
    """ψ of a 3x3 deformation gradient, from the package's law of the invariants."""
    return float(material.energy(mu, kappa, np.vdot(F, F), np.linalg.det(F)))


def cofactor(F: np.ndarray) -> np.ndarray:
    return np.linalg.det(F) * np.linalg.inv(F).T


def stress(F: np.ndarray, mu: float = MU, kappa: float = KAPPA) -> np.ndarray:
    a, b = material.stress_coefficients(mu, kappa, np.vdot(F, F), np.linalg.det(F))
    return a * F + b * cofactor(F)


def tangent(F: np.ndarray, dF: np.ndarray, mu: float = MU, kappa: float = KAPPA) -> np.ndarray:
    """The tangent applied to dF; the change of the cofactor is exact, as it is a quadratic function of F."""
    I1, J = np.vdot(F, F), np.linalg.det(F)
    a, b = material.stress_coefficients(mu, kappa, I1, J)
    c1, c2 = material.tangent_coefficients(mu, kappa, I1, J)
    C = cofactor(F)
    change = 0.5 * (cofactor(F + dF) - cofactor(F - dF))
    FdF, CdF = np.vdot(F, dF), np.vdot(C, dF)
    return a * dF + c1 * (F * CdF + C * FdF) + c2 * C * CdF + b * change


def states(count: int = 4):
    rng = np.random.default_rng(3)
    for _ in range(count):
        F = np.eye(3) + 0.35 * rng.standard_normal((3, 3))
        if np.linalg.det(F) < 0.1:
            F = np.eye(3) + 0.1 * rng.standard_normal((3, 3))
        yield F, rng.standard_normal((3, 3))


def test_the_undeformed_state_has_no_energy_and_no_stress():
    assert energy(np.eye(3)) == 0.0
    assert np.abs(stress(np.eye(3))).max() < 1e-13 * MU


def test_leaving_out_the_third_direction_would_stress_the_undeformed_state():
    a, b = material.stress_coefficients(MU, KAPPA, 2.0, 1.0)
    assert a + b == pytest.approx(MU / 3, rel=1e-14)


@pytest.mark.parametrize(("F", "d"), list(states()))
def test_stress_is_the_slope_of_the_energy(F, d):
    slope = np.vdot(stress(F), d)
    assert taylor_order(lambda h: energy(F + h * d) - energy(F) - h * slope, KAPPA, 0.05) > 1.9


@pytest.mark.parametrize(("F", "d"), list(states()))
def test_tangent_is_the_slope_of_the_stress(F, d):
    bend = tangent(F, d)

    def remainder(h: float) -> float:
        return float(np.linalg.norm(stress(F + h * d) - stress(F) - h * bend))

    assert taylor_order(remainder, KAPPA, 0.02) > 1.9


def test_tangent_has_major_symmetry():
    rng = np.random.default_rng(4)
    for F, d in states():
        e = rng.standard_normal((3, 3))
        one, other = np.vdot(e, tangent(F, d)), np.vdot(d, tangent(F, e))
        assert one == pytest.approx(other, rel=1e-13, abs=1e-10 * KAPPA)


@pytest.mark.parametrize("name", ["mu", "kappa"])
def test_energy_stress_and_tangent_change_with_each_parameter(name):
    F, d = next(states())
    other = {"mu": MU, "kappa": KAPPA, name: 2 * {"mu": MU, "kappa": KAPPA}[name]}
    assert energy(F, **other) > energy(F)
    assert np.linalg.norm(stress(F, **other) - stress(F)) > 1.0
    assert np.linalg.norm(tangent(F, d, **other) - tangent(F, d)) > 1.0


def test_energy_does_not_see_rotations_before_or_after():
    rng = np.random.default_rng(5)
    for F, _ in states():
        Q, R = (np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in range(2))
        Q, R = Q * np.sign(np.linalg.det(Q)), R * np.sign(np.linalg.det(R))
        assert energy(Q @ F @ R) == pytest.approx(energy(F), rel=1e-12)
        np.testing.assert_allclose(stress(Q @ F), Q @ stress(F), atol=1e-11 * KAPPA)


def test_small_strains_are_hookes_law():
    # σ = 2μ dev ε + κ tr ε, what the two moduli mean
    eps = 1e-6 * np.array([[1.0, 0.3, 0.0], [0.3, -0.4, 0.2], [0.0, 0.2, 0.5]])
    deviator = eps - np.trace(eps) / 3 * np.eye(3)
    expected = 2 * MU * deviator + KAPPA * np.trace(eps) * np.eye(3)
    np.testing.assert_allclose(stress(np.eye(3) + eps), expected, atol=1e-4 * np.abs(expected).max())


def test_volume_change_alone_costs_the_bulk_part():
    # F = λ 1: I₁ J^{-2/3} = 3 for every λ, so ψ = κ/2 (λ³ - 1)²
    for stretch in (0.5, 1.7):
        expected = 0.5 * KAPPA * (stretch**3 - 1) ** 2
        assert energy(stretch * np.eye(3)) == pytest.approx(expected, rel=1e-12)


def test_simple_shear_costs_half_mu_gamma_squared():
    F = np.eye(3)
    F[0, 1] = 0.8
    assert energy(F) == pytest.approx(0.5 * MU * 0.8**2, rel=1e-12)


def test_moduli_of_document_one():
    # E/(2(1+ν)) and E/(3(1-2ν)) of gray and white matter, and the ratio of the two Young's moduli
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    assert (gray.mu, gray.kappa) == (pytest.approx(476.24, abs=5e-3), pytest.approx(5551.6, abs=0.05))
    assert (white.mu, white.kappa) == (pytest.approx(649.73, abs=5e-3), pytest.approx(7573.9, abs=0.1))
    assert gray.kappa / gray.mu == pytest.approx(11.66, abs=5e-3)
    assert white.mu / gray.mu == pytest.approx(1895 / 1389, rel=1e-14)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(young=st.floats(1e-3, 1e9), poisson=st.floats(-0.9, 0.499))
def test_poisson_ratio_and_young_modulus_come_back(young, poisson):
    made = NeoHookean.from_young(young, poisson)
    assert made.poisson == pytest.approx(poisson, abs=1e-9)
    assert made.young == pytest.approx(young, rel=1e-9)


def test_moduli_without_names_are_refused():
    with pytest.raises(ValueError, match=r"NeoHookean\.from_young\(1389, 0\.4583\)") as failure:
        NeoHookean(1389, 0.4583)  # E and ν, taken for μ and κ, would be a wrong material without a word
    message_names(failure.value, "mu=", "kappa=", "Poisson")


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf"), "soft", None, True])
@pytest.mark.parametrize("name", ["mu", "kappa"])
def test_moduli_must_be_positive_numbers(name, bad):
    with pytest.raises(ValueError, match=name) as failure:
        NeoHookean(**{"mu": 1.0, "kappa": 5.0, name: bad})
    message_names(failure.value, "Pa")


@pytest.mark.parametrize("poisson", [0.5, -1.0, 0.7, -2.0, float("nan")])
def test_poisson_ratio_must_be_inside_its_bounds(poisson):
    with pytest.raises(ValueError, match="poisson") as failure:
        NeoHookean.from_young(1389.0, poisson)
    if np.isfinite(poisson):
        message_names(failure.value, "-1", "0.5", "0.4999")


@pytest.mark.parametrize("young", [0.0, -5.0, float("inf")])
def test_young_modulus_must_be_positive(young):
    with pytest.raises(ValueError, match="young"):
        NeoHookean.from_young(young, 0.3)
