"""Stiff systems: Robertson's rates in two forms, and a diffusion ratio of 1e4 with kinetics scaled by 1e6."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from skfem import MeshTri
from turing_problems import semi_annulus

from turingfold.turing.integrators.bdf import march_bdf
from turingfold.turing.integrators.rosenbrock import march
from turingfold.turing.kinetics.chemical import Schnakenberg
from turingfold.turing.kinetics.user import UserKinetics
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.steady import settle


def final(moments):
    for moment in moments:
        last = moment
    return last


def robertson_of_two():
    """Return A and C of Robertson's three reactions 0.04, 1e4, 3e7, with B at its quasi-steady value."""

    def b_of(a, c):  # 3e7 b² + 1e4 c b − 0.04 a = 0, in the form without cancellation
        return 2 * 0.04 * a / (1e4 * c + np.sqrt((1e4 * c) ** 2 + 4 * 3e7 * 0.04 * a))

    return UserKinetics(
        p=lambda a, c: -0.04 * a + 1e4 * b_of(a, c) * c,
        q=lambda a, c: 3e7 * b_of(a, c) ** 2,
        guesses=((0.8, 0.2),),
    )


def robertson_conserved():
    """Return A and B of Robertson's reactions, none left out: C = 1 − A − B, with one diffusivity for all."""
    return UserKinetics(
        p=lambda a, b: -0.04 * a + 1e4 * b * (1 - a - b),
        q=lambda a, b: 0.04 * a - 1e4 * b * (1 - a - b) - 3e7 * b * b,
        partial_derivatives=lambda a, b: (
            -0.04 - 1e4 * b, 1e4 * (1 - a - 2 * b), 0.04 + 1e4 * b, -1e4 * (1 - a - 2 * b) - 6e7 * b,
        ),
        guesses=((0.8, 1e-5),),
    )  # fmt: skip


# A, B and C at t = 40: Hairer, Wanner (1996), chapter IV.1
ROBERTSON_40 = 0.7158270688, 9.185534765e-6, 0.2841637457


@pytest.mark.parametrize("method", [march, march_bdf])
def test_robertson_with_its_quasi_steady_species_eliminated(method):
    space = discretise(semi_annulus(12, 1), 1)
    system = ReactionDiffusion(space, robertson_of_two(), 1e-3, 1.0)
    end = final(method(system, system.uniform(1.0, 0.0), until=40.0, tolerance=1e-7)).state
    # the quasi-steady B changes A by its own size, 9e-6
    assert np.allclose(end.T, ROBERTSON_40[::2], atol=2e-5)


@pytest.mark.parametrize("method", [march, march_bdf])
def test_robertson_with_its_conserved_sum_eliminated(method):
    space = discretise(semi_annulus(12, 1), 1)
    system = ReactionDiffusion(space, robertson_conserved(), 1.0, 1.0)
    moment = final(method(system, system.uniform(1.0, 0.0), until=40.0, tolerance=1e-6))
    assert np.allclose(moment.state.T, ROBERTSON_40[:2], rtol=1e-5, atol=0.0)
    assert moment.steps < 400  # at the fastest rate, 3e3, an explicit method needs 6e4


@pytest.fixture(scope="module")
def spike():
    """Return u and v of a steady half spike on 0 < x < 1/2, for diffusivities 1e-4 and 1."""
    kinetics = Schnakenberg()

    def slope(x, y):
        p, q = kinetics.rates(y[0], y[2])
        return np.stack([y[1], -1e4 * p, y[3], -q])

    # guess: 1e-4 u'' = u − u² v₀ at the spike, v'' = −b away from it, ∫ u² v₀ = b / 2: v₀ = 1/15
    x = np.linspace(0, 0.5, 401)
    u, v = 0.1 + 22.5 / np.cosh(x / 0.02) ** 2, 1 / 15 + 0.45 * (x - x * x)
    guess = np.stack([u, np.gradient(u, x), v, np.gradient(v, x)])
    found = solve_bvp(slope, lambda a, b: np.array([a[1], b[1], a[3], b[3]]), x, guess, tol=1e-6)
    assert found.success
    return lambda x: found.sol(x)[[0, 2]]


@pytest.mark.parametrize("scale", [1.0, 1e6])
def test_diffusion_ratio_1e4_and_kinetics_scaled_by_1e6_are_solved_where_resolved(scale, spike):
    # kinetics 1e6 times as fast make the same pattern on a strip a thousandth as long
    known = Schnakenberg()
    kinetics = UserKinetics(
        p=lambda u, v: scale * known.rates(u, v)[0],
        q=lambda u, v: scale * known.rates(u, v)[1],
        partial_derivatives=lambda u, v: tuple(scale * slope for slope in known.derivatives(u, v)),
        guesses=((1.0, 0.9),),
    )
    errors, length = [], 0.5 * scale**-0.5
    for along in (100, 200):  # 2 and 4 quadratic elements to the activator's own length, 0.01
        mesh = MeshTri.init_tensor(np.linspace(0, length, along + 1), np.array([0, length / along]))
        system = ReactionDiffusion(discretise(mesh, 2), kinetics, 1e-4, 1.0)
        x = system.space.nodes[0] / (2 * length)
        start = system.uniform(1.0, 0.9)
        start[0] += 0.1 * np.cos(2 * np.pi * x)
        found = settle(system, start)
        assert found.stable
        assert system.space.mean(found.state)[0] == pytest.approx(1.0, abs=1e-11)
        exact = spike(x)
        errors.append((np.abs(found.state - exact).max(axis=1) / exact.max(axis=1)).max())
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) > 2.5
