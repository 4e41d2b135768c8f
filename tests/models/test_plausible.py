"""Values that look like mistakes of units: growth in per cent, loads far beyond the stiffness."""

import warnings

import pytest

from turingfold import (
    ActiveStress,
    AxonalTension,
    BoundaryLoads,
    GrowthMap,
    PeakLoads,
    Scene,
    Schnakenberg,
    Swelling,
    TangentialGrowth,
    Turing,
    human,
    semicircle,
)

PATTERN = (Turing(Schnakenberg(), half_waves=24),)


@pytest.mark.parametrize("factor", [90.0, 190, 0.09, 0.25, 5.1])
@pytest.mark.parametrize("name", ["cortex", "core", "radial_core", "radial_cortex", "swelling_core"])
def test_per_cents_taken_for_factors_are_refused(name, factor):
    with pytest.raises(ValueError, match=rf"{name}=.* must be between 0.3 and 5; per cent or a fraction\?"):
        TangentialGrowth(**{name: factor})


@pytest.mark.parametrize(
    ("load", "words"),
    [
        # μ = 1389/(2·1.4583) = 476.2 Pa, T = 2.5 mm, μT = 1.19 N/m: 150 is 126 times that
        (AxonalTension(strength=150.0, patches=2), r"strength=150 N/m .* 126 times the .*1\.19 N/m"),
        (AxonalTension(strength=1e5, surface="pial", patches=2), r"strength=100000 Pa .* 210 times the"),
        (BoundaryLoads(places=(0.2, 0.5), forces=((0.0, 1.0), (90, -120)), width=2e-3),
         r"the largest of forces=150 N/m .* 126 times the .*1\.19 N/m"),
        (PeakLoads(strength=-150.0, distance=2e-3, width=2e-3), r"PeakLoads: strength=-150 N/m .* 126 times"),
        (ActiveStress(stress=1e5), r"ActiveStress: stress=100000 Pa .* 210 times the"),
    ],
    ids=lambda given: type(given).__name__,
)  # fmt: skip
def test_loads_far_beyond_the_stiffness_are_noticed(load, words):
    body, solid = semicircle(radius=0.0404, thickness=2.5e-3, elements=1), human.tissue(two_layers=False)
    with pytest.warns(UserWarning, match=words):
        made = Scene(body=body, terms=(solid, load), processes=PATTERN if "pattern" in load.reads else ())
    assert made.terms[1] == load  # as it was given


@pytest.mark.parametrize(
    "load",
    [
        AxonalTension(strength=0.5, patches=2),  # document 1's
        BoundaryLoads(places=(0.2, 0.5), forces=((0.0, 1.0), (9, -12)), width=2e-3),
        PeakLoads(strength=-1.0, distance=2e-3, width=2e-3),
        ActiveStress(stress=1e3),
    ],
    ids=lambda given: type(given).__name__,
)
def test_other_loads_are_not(load):
    body, solid = semicircle(radius=0.0404, thickness=2.5e-3, elements=1), human.tissue(two_layers=False)
    with warnings.catch_warnings(record=True) as told:
        Scene(body=body, terms=(solid, load), processes=PATTERN if "pattern" in load.reads else ())
    assert not told


@pytest.mark.parametrize("coefficient", [20.0, 4.1, -0.8])
def test_per_cents_taken_for_a_swelling_are_refused(coefficient):
    with pytest.raises(
        ValueError, match=rf"coefficient={coefficient:g} must be between -0.7 and 4; per cent"
    ):
        Swelling(coefficient=coefficient)


@pytest.mark.parametrize("factor", [190.0, 0.2])
def test_per_cents_taken_for_factors_of_a_map_are_refused(factor):
    with pytest.raises(ValueError, match=rf"cortex={factor:g} must be between 0.3 and 5; per cent"):
        GrowthMap(cortex=(1.2, factor, 1.3))
