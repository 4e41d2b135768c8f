"""Values that look like mistakes of units: growth in per cent, loads far beyond the stiffness."""

import warnings

import pytest

from turingfold import AxonalTension, Scene, TangentialGrowth, human, semicircle


@pytest.mark.parametrize("factor", [90.0, 190, 0.09, 0.25, 5.1])
@pytest.mark.parametrize("name", ["cortex", "core", "radial_core", "radial_cortex", "swelling_core"])
def test_per_cents_taken_for_factors_are_refused(name, factor):
    with pytest.raises(ValueError, match=rf"{name}=.* must be between 0.3 and 5; per cent or a fraction\?"):
        TangentialGrowth(**{name: factor})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        # μ = 1389/(2·1.4583) = 476.2 Pa, T = 2.5 mm, μT = 1.19 N/m: 150 is 126 times that
        ({"strength": 150.0}, r"strength=150 N/m .* 126 times the shear modulus times .*1\.19 N/m"),
        ({"strength": 1e5, "surface": "pial"}, r"strength=100000 Pa .* 210 times the shear modulus"),
    ],
)
def test_strengths_far_beyond_the_stiffness_are_noticed(options, words):
    body = semicircle(radius=0.0404, thickness=2.5e-3, elements=1)
    solid = human.tissue(two_layers=False)
    with pytest.warns(UserWarning, match=words):
        made = Scene(body=body, terms=(solid, AxonalTension(patches=2, **options)))
    assert made.terms[1].strength == options["strength"]  # as it was given
    with warnings.catch_warnings(record=True) as told:
        Scene(body=body, terms=(solid, AxonalTension(strength=0.5, patches=2)))  # document 1's
    assert not told
