"""Branches in the diffusion ratio: onset, square-root law, stability, folds."""

import numpy as np
import pytest
from turing_problems import R_IN, outer_line, semi_annulus

from turingfold.turing.continuation import neutral_ratio, steady_branch
from turingfold.turing.kinetics.activator_inhibitor import GiererMeinhardt
from turingfold.turing.kinetics.chemical import Brusselator, Schnakenberg
from turingfold.turing.modes import mode_with
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.stability import dispersion, turing_unstable_at
from turingfold.turing.steady import settle


def one_half_wave(kinetics):
    """Return system, conditions and mode on a band that holds half a wave."""
    mesh = semi_annulus(12, 1, np.pi / 12)
    space = discretise(mesh, 2)
    mode = mode_with(space, 1, outer_line(mesh), np.pi / 12 * (1 + R_IN) / 2, 1 - R_IN)
    found = turing_unstable_at(kinetics).scaled_to(mode.value)
    return ReactionDiffusion(space, kinetics, found.d_u, found.d_v), found, mode


@pytest.mark.parametrize("kinetics", [Schnakenberg(), Brusselator()])
def test_the_branch_leaves_at_the_neutral_ratio_with_a_square_root(kinetics):
    system, found, mode = one_half_wave(kinetics)
    start = neutral_ratio(found, mode.value)
    assert dispersion(kinetics, found.d_u, start * found.d_u, mode.value) == pytest.approx(0.0, abs=1e-14)
    first, second = steady_branch(system, found, mode, amplitude=0.01, step=0.01, points=2)
    constants = [point.amplitude**2 / (point.ratio - start) for point in (first, second)]
    assert constants[0] == pytest.approx(constants[1], rel=0.01)
    # supercritical: the pattern decays back at twice the rate at which the uniform state leaves
    for point in (first, second):
        rate = dispersion(kinetics, found.d_u, point.ratio * found.d_u, mode.value)
        assert point.leading.real == pytest.approx(-2 * rate, rel=0.03)


def test_the_branch_passes_through_the_pattern_that_a_run_reaches():
    system, found, mode = one_half_wave(Schnakenberg())
    points = list(steady_branch(system, found, mode, points=7))
    point = points[-1]
    assert point.ratio > 11
    start = np.array(found.steady_state)[:, None] + 0.1 * np.outer(
        found.fastest_direction, mode.shape / mode.shape.max()
    )
    at = ReactionDiffusion(system.space, system.kinetics, found.d_u, point.ratio * found.d_u)
    assert np.allclose(settle(at, start).state, point.state, atol=1e-9)
    assert all(p.stable and not p.fold for p in points)


def test_gierer_meinhardt_leaves_backwards_and_becomes_stable_at_the_fold():
    system, found, mode = one_half_wave(GiererMeinhardt())
    start = neutral_ratio(found, mode.value)
    points = list(steady_branch(system, found, mode, points=8))
    assert points[0].ratio < start
    folds = [k for k, point in enumerate(points) if point.fold]
    assert len(folds) == 1
    assert not any(point.stable for point in points[: folds[0]])
    assert all(point.stable for point in points[folds[0] :])
    assert points[-1].ratio > start


def test_a_mode_too_short_for_any_ratio_is_refused():
    _, found, _ = one_half_wave(Schnakenberg())
    with pytest.raises(ValueError, match="decays at every ratio"):
        neutral_ratio(found, 1.01 * found.shortest_k2)
