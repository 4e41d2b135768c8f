"""Thickness along the pial surface, of bodies and sections, against formulas on circles and ellipses."""

import numpy as np
import pytest

from turingfold import Section, half, outline, semicircle, thickness_profile
from turingfold.state import State

AT = 2 * np.pi * np.arange(400) / 400
CIRCLE = np.stack([np.cos(AT), np.sin(AT)])


def deformed(body, by):
    return State(1.0, {"displacement": by(body.nodes) - body.nodes})


def test_a_body_has_the_thickness_of_the_section_that_it_is_made_from():
    """White circles out of the middle: Fischl and Dale's measure on a circle is R - |p - c|, about."""
    shift = np.array([[0.05], [0.0]])
    section = Section([CIRCLE, 0.5 * CIRCLE + 2.0], [0.8 * CIRCLE + shift, 0.3 * CIRCLE + 2.0])
    body = outline(section, size=0.08)
    found = thickness_profile(body, deformed(body, lambda x: 1.5 * x), section)
    assert found.given == pytest.approx(found.start, rel=0.01)
    assert found.grown == pytest.approx(1.5 * found.start, rel=1e-9)
    x, y = np.concatenate([body.nodes[:, path.nodes] for path in body.pial_paths], axis=1)
    first = np.hypot(x, y) < 1.01
    sagitta = 0.04**2 / (8 * 0.3)  # of straight lines between nodes half an edge apart
    assert found.start[~first] == pytest.approx(0.2, abs=1.2 * sagitta)
    # |p - w| = |p - c| - 0.8, and from w back to the circle it is 1 - |w|
    away = np.hypot(x[first] - 0.05, y[first])
    white = 0.05 + (x[first] - 0.05) * 0.8 / away, y[first] * 0.8 / away
    exact = 0.5 * (away - 0.8 + 1 - np.hypot(*white))
    assert found.start[first] == pytest.approx(exact, abs=1.2 * sagitta)
    assert np.diff(found.arc).min() > 0
    assert found.arc[np.flatnonzero(~first)[0]] == pytest.approx(
        2 * np.pi, rel=1e-4
    )  # the second part begins


def test_growth_of_thickness_is_told_in_words_and_places_without_a_section_have_none():
    body = semicircle(radius=0.04, thickness=2e-3, elements=2)
    thinner = deformed(
        body, lambda x: x * (1 + 0.5e-3 / np.maximum(np.hypot(*x), 0.038) * (np.hypot(*x) < 0.0385))
    )
    found = thickness_profile(body, thinner)
    assert found.given is None
    middle = slice(len(found.start) // 3, -len(found.start) // 3)
    assert found.start[middle] == pytest.approx(2e-3, rel=1e-3)
    assert found.grown[middle] == pytest.approx(1.5e-3, rel=1e-3)
    assert str(found).startswith(
        "thickness at the start 2.00 mm (2.00 to 2.00), grown 1.50 mm (1.50 to 1.50)"
    )
    far = Section([1e-3 * CIRCLE + 0.1], [0.5e-3 * CIRCLE + 0.1])
    assert np.isnan(thickness_profile(body, thinner, far).given).all()


def test_half_a_body_is_refused():
    body = half(semicircle(radius=0.04, thickness=2e-3, elements=2))
    with pytest.raises(ValueError, match="half of one"):
        thickness_profile(body, deformed(body, lambda x: x))
