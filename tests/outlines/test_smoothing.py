"""What smoothing takes away and fills is told; exact for circles and waves on them."""

import numpy as np
import pytest

from turingfold.geometry.changes import OutlineWarning
from turingfold.outlines import outline

AT = 2 * np.pi * np.arange(800) / 800
CIRCLE = np.stack([np.cos(AT), np.sin(AT)])


def left(smooth):
    """Return what is left of the radius of a unit circle: one wave per turn, kernel 2g - g*g."""
    return 1 - (1 - np.exp(-(smooth**2) / 2)) ** 2


def test_a_circle_that_shrinks_has_lost_area():
    with pytest.warns(OutlineWarning, match=r"area lost 28\.57%.*less smoothing"):
        body = outline(CIRCLE, thickness=0.1, size=0.05, smooth=1.0)
    assert body.changes.lost == pytest.approx(1 - left(1.0) ** 2, abs=1e-4)
    assert body.changes.added == pytest.approx(0.0, abs=1e-4)


def test_less_than_five_percent_is_a_remark():
    body = outline(CIRCLE, thickness=0.1, size=0.05, smooth=0.5)
    lost = 1 - left(0.5) ** 2
    assert 0.01 < lost < 0.05
    assert body.changes.lost == pytest.approx(lost, abs=1e-4)
    assert "area lost 2.7" in " ".join(body.changes.remarks())


def test_waves_that_are_smoothed_away_are_lost_and_filled_though_their_sum_is_nothing():
    """½ ∫ |r² - 1| over the area of r = 1 + a cos nφ is 4 a over π, to the first order in a."""
    wave = (1 + 0.06 * np.cos(16 * AT)) * CIRCLE
    with pytest.warns(OutlineWarning, match="area lost"):
        body = outline(wave, thickness=0.1, size=0.05, smooth=0.25)
    assert body.changes.lost + body.changes.added == pytest.approx(4 * 0.06 / np.pi, rel=0.1)
    assert body.changes.lost == pytest.approx(body.changes.added, rel=0.3)


def test_the_cortex_is_compared_with_that_of_the_curves_as_given():
    """Circles of radii 1 and 0.8, of which smoothing leaves others; r keeps 1 - (1 - exp(-s²/2r²))²."""
    inner = 0.8 * left(0.5 / 0.8)
    body = outline(CIRCLE, interface=0.8 * CIRCLE, size=0.05, smooth=0.5)
    exact = (left(0.5) ** 2 - inner**2) / (1 - 0.8**2) - 1
    assert exact > 0.01
    assert body.changes.cortex == pytest.approx(exact, abs=2e-3)
