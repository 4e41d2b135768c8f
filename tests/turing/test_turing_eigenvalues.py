"""Rightmost eigenvalues, complex pairs included, against all eigenvalues of dense matrices."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, eig, eigvalsh
from turing_problems import R_IN, outer_line, semi_annulus

from turingfold.errors import NotConvergedError
from turingfold.geometry.shapes import semicircle
from turingfold.turing.continuation import steady_branch
from turingfold.turing.eigenvalues import eigenvalue_near, rightmost_eigenvalues, unstable_box
from turingfold.turing.kinetics.activator_inhibitor import FitzHughNagumo, GiererMeinhardt, KochMeinhardt
from turingfold.turing.kinetics.bvam import BVAM, BVAM2012
from turingfold.turing.kinetics.chemical import Brusselator, GrayScott, LengyelEpstein, Schnakenberg, Thomas
from turingfold.turing.modes import mode_with
from turingfold.turing.process import Turing
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.stability import conditions_at_ratio, hopf_boundary, turing_unstable_at

# of each kinetics a parameter, and the value of it at which tr J = 0 while det J > 0 at a steady state (u, v)
HOPF = (
    (Schnakenberg(), "b", hopf_boundary(Schnakenberg(), "b", (0.3, 0.9))),
    (GiererMeinhardt(a=0.1), "c", hopf_boundary(GiererMeinhardt(a=0.1), "c", (0.5, 2.0))),
    (KochMeinhardt(), "mu_h", hopf_boundary(KochMeinhardt(), "mu_h", (0.001, 0.02))),
    (Brusselator(), "B", 5.0),  # 1 + A²
    # u = 10, v = 43.75: h = 70, by u −3, by v 1.6; tr J = −1 + 3 − α − 1.6
    (Thomas(a=80.0, b=218.75, rho=3.36, K=0.1), "alpha", 0.4),
    # v² = k = 0.04, u = (F + k)/v: 5 F² − 0.6 F + 0.008 = 0
    (GrayScott(k=0.04), "F", (0.6 - 0.2**0.5) / 10),
    (LengyelEpstein(), "sigma", hopf_boundary(LengyelEpstein(), "sigma", (1.0, 50.0))),
    (BVAM(), "alpha", 0.91),  # −β
    (BVAM2012(), "b", -1.0),
    (FitzHughNagumo(), "e_v", hopf_boundary(FitzHughNagumo(), "e_v", (0.1, 10.0))),
)


def dense(system, state):
    """Return all eigenvalues by descending real part, and the matrices J and M, species by species."""
    mass, stiffness = system.space.mass.toarray(), system.space.stiffness.toarray()
    p_u, p_v, q_u, q_v = system.kinetics.derivatives(*state)
    jacobian = np.block(
        [[mass * p_u - system.d_u * stiffness, mass * p_v], [mass * q_u, mass * q_v - system.d_v * stiffness]]
    )
    both = block_diag(mass, mass)
    values = eig(jacobian, both, right=False)
    return values[np.argsort(-values.real)], jacobian, both


def near_hopf(kinetics, name, value, share, along=24):
    """Return a system and a state beside the Hopf boundary: the uniform one and a wave of 5 % on it."""
    kinetics = replace(kinetics, **{name: value * (1 + share)})
    u, v = min(kinetics.steady_states(), key=lambda point: abs(np.trace(kinetics.jacobian(point))))
    J = kinetics.jacobian((u, v))
    space = discretise(semi_annulus(along, 1), 2)
    spread = 0.1 * np.abs(J).max() / 36.0  # equal, so that what grows oscillates
    system = ReactionDiffusion(space, kinetics, spread, spread)
    wave = np.cos(6 * np.arctan2(space.nodes[1], space.nodes[0]))
    return system, system.uniform(u, v) * (1 + 0.05 * wave) + 0.01 * (u == 0) * wave


@pytest.mark.parametrize("share", [-0.02, 0.02])
@pytest.mark.parametrize(("kinetics", "name", "value"), HOPF, ids=[type(k).__name__ for k, _, _ in HOPF])
def test_near_its_hopf_boundary_every_kinetics_shows_its_rightmost_pair(kinetics, name, value, share):
    system, state = near_hopf(kinetics, name, value, share)
    found, (exact, _, _) = rightmost_eigenvalues(system, state), dense(system, state)
    assert abs(exact[0].imag) > 0
    assert found[0].real == pytest.approx(exact[0].real, abs=1e-7 * abs(exact[0]))
    assert abs(found[0].imag) == pytest.approx(abs(exact[0].imag), rel=1e-7)
    # nothing that does not decay is missing
    if exact[0].real < 0:
        assert found[0].real < 0
    # and each that is returned is an eigenvalue
    for value in found:
        assert np.abs(exact - value).min() < 1e-6 * np.abs(exact[:20]).max()


@pytest.mark.parametrize(("kinetics", "name", "value"), HOPF, ids=[type(k).__name__ for k, _, _ in HOPF])
def test_the_box_holds_the_numerical_range(kinetics, name, value):
    system, state = near_hopf(kinetics, name, value, 0.0, along=16)
    right, high = unstable_box(system, state)
    exact, _, _ = dense(system, state)
    unstable = exact[exact.real >= 0]
    assert (unstable.real <= right).all()
    assert (np.abs(unstable.imag) <= high).all()
    # the range of the reaction alone, the species scaled as the box scales them
    p_v, q_u = (np.abs(system.kinetics.derivatives(*state)[i]).max() for i in (1, 2))
    _, jacobian, mass = dense(replace(system, d_u=1e-300, d_v=1e-300), state)
    n, s = system.space.size, np.sqrt(p_v / q_u)
    scale = np.repeat([1.0, s], n)
    scaled = scale[:, None] * jacobian / scale
    assert eigvalsh(scaled + scaled.T, 2 * mass).max() <= right
    assert np.abs(eigvalsh(1j * (scaled - scaled.T), 2 * mass)).max() <= high


@pytest.mark.slow
def test_a_branch_is_unstable_where_a_pair_of_eigenvalues_says_so():
    mesh = semi_annulus(20, 1, np.pi / 6)
    space = discretise(mesh, 2)
    mode = mode_with(space, 2, outer_line(mesh), np.pi / 6 * (1 + R_IN) / 2, 1 - R_IN)
    found = turing_unstable_at(BVAM2012()).scaled_to(mode.value)
    system = ReactionDiffusion(space, BVAM2012(), found.d_u, found.d_v)
    stable = []
    for point in steady_branch(system, found, mode, points=11):
        exact = dense(replace(system, d_v=point.ratio * system.d_u), point.state)[0][0]
        assert point.leading.real == pytest.approx(exact.real, abs=1e-7)
        assert abs(point.leading.imag) == pytest.approx(abs(exact.imag), abs=1e-7)
        stable.append(point.stable)
    assert stable == 8 * [True] + 3 * [False]


def test_a_steady_pattern_that_would_oscillate_is_no_steady_pattern():
    # three times the critical ratio: a pair at 0.16 ± 2.63 i
    where = semicircle(radius=0.0404, thickness=2.5e-3, size=1.25e-3, base="clamped")
    pattern = Turing(BVAM2012(), half_waves=8, ratio=3 * conditions_at_ratio(BVAM2012()).critical_ratio)
    with pytest.raises(NotConvergedError, match=r"oscillat.* period of 2\.39") as caught:
        pattern.pattern(where)
    assert "0.16" in str(caught.value)


def test_a_complex_eigenvalue_is_followed_to_other_elements():
    system, state = near_hopf(*HOPF[3], 0.02)
    exact = dense(system, state)[0]
    for value in exact[exact.imag > 0][:3]:
        assert eigenvalue_near(system, state, value * (1.001 + 0.001j)) == pytest.approx(value, rel=1e-6)
