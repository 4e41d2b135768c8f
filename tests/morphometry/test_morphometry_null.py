"""What chance gives: registrations of moved patterns."""

import numpy as np
import pytest
from morphometry_shapes import angles, ellipse, flower

from turingfold.morphometry.registration import registration, registration_null


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
@pytest.mark.parametrize("shift", [0.0, 0.3, 1.0, np.pi / 2, 2.5])
def test_p_is_the_part_of_all_phases_that_lie_nearer(arc, shift):
    """cos(n t) on folds cos(n t + shift) registers with cos(shift): shift/pi of all phases lie nearer."""
    theta = angles(2000, arc)
    pattern, circle = np.cos(20 * theta), ellipse(1, 1, 2000, arc)
    folded = (1 + 0.05 * np.cos(20 * theta + shift)) * circle
    null = registration_null(pattern, folded, circle)
    assert null.value == pytest.approx(registration(pattern, folded, circle), abs=1e-12)
    assert null.p == pytest.approx(shift / np.pi, abs=0.01)
    # the cosine of a random phase: its quantile at the share q is -cos(pi q)
    for share in (0.05, 0.25, 0.5, 0.95):
        assert null.quantile(share) == pytest.approx(-np.cos(np.pi * share), abs=0.02)


def test_a_pattern_of_another_wave_length_registers_by_chance():
    theta = angles(2000)
    null = registration_null(np.cos(13 * theta + 0.2), flower(20, 0.05, 2000), ellipse(1, 1, 2000))
    assert np.abs(null.samples).max() < 0.01


def test_without_folds_every_phase_registers_as_well():
    null = registration_null(np.cos(9 * angles(500)), ellipse(1, 1, 500), ellipse(1, 1, 500))
    assert (null.value, null.p) == (0.0, 1.0)


def test_null_says_value_chance_and_p():
    theta = angles(1000)
    null = registration_null(np.cos(12 * theta), flower(12, 0.05, 1000), ellipse(1, 1, 1000), phases=101)
    chance = f"by chance {null.quantile(0.5):.3f}, 95 % below {null.quantile(0.95):.3f}"
    assert str(null) == f"1.000 ({chance}; p = 0.010)"
