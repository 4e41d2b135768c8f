"""Ferret, normal development: continuous growth from P0 to P32. About 15 s.

    turingfold run cases/ferret_normal.py      draws figures/ferret_normal.png

A coronal section, dimensionless as in Choi et al. 2025: a disc of radius 1, shear modulus 1, bulk modulus 5,
cortex T = 0.1 that grows at the rate 1.9 and thins to T (1 - t/2), no growth in the middle (r < 0.5) and at
the bottom (y < -0.4), each with a ramp of 0.2. P32 is t = 0.44, where the cortex has grown by e^{0.84} = 2.3
along its surface; that growth slows down with age, to 1/e in 12 days, is our choice.
"""

from turingfold import (
    Days,
    Ellipse,
    Imperfection,
    RateGrowth,
    Scene,
    SelfContact,
    Zone,
    ferret,
    figures,
    outline,
    run_case,
)
from turingfold import parameters as p

MIDDLE = Zone(region=Ellipse(centre=(0, 0), semi_axes=(0.5, 0.5), edge=0.2, ramp="straight"), growth=0.0)


@p.quick(elements=2, until=0.1)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 4, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, amplitude: p.Amplitude = 0.02,
    until: p.Until = ferret.P32, seed: p.Seed = 0,
):  # fmt: skip
    body = outline(ferret.circle(), thickness=thickness, elements=elements, layers="sigmoid")
    ages = Days(duration=until)
    grow = RateGrowth(rate=rate, thinning=thinning, zones=(MIDDLE, ferret.BOTTOM), ages=ages)
    processes, terms = (grow, Imperfection(amplitude=amplitude)), (ferret.tissue(bulk=bulk), SelfContact())
    return {"continuous": Scene(body=body, processes=processes, terms=terms, until=until, seed=seed)}


def draw(results, figure):
    result = results["continuous"]
    shown = {}
    for day in (0, 4, 8, 16, 32):
        time = Days(duration=result.scene.until).time(day)
        shown[f"P{day}"] = result, figures.nearest_step(result, time)
    figures.grid(figure, shown, columns=5, width=2.6)


if __name__ == "__main__":
    run_case(__file__)
