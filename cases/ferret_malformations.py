"""Ferret, malformations: eight brains that differ in growth and cortical thickness. About 60 s.

    turingfold run cases/ferret_malformations.py      draws figures/ferret_malformations.png

Dimensionless: radius 1, shear modulus 1, bulk modulus 5, cortex T = 0.1 that grows at the rate 1.9 and thins
to T (1 - t/2), as in the public code of Choi et al. 2025; a half disc that slides on its base. P32 is
t = 0.44, where the cortex has grown by e^{0.84} = 2.3 along its surface.

PMG: T/4. Thick: 2 T. SCN3A: T/4 in a window of the surface. ASPM: a quarter of the rate. TMEM161B: three
quarters of the rate and 1.5 T. Cdk5: three quarters of the rate at normal thickness: the source gives only
"shallow sulci", and neurons that do not reach the upper layers expand the cortex less while its folds keep
their spacing. ARHGAP11B: 15 % more tangential and also radial growth, at the rate 0.6.

Over the seeds 0, 1 and 2 normal has 8 sulci, PMG 32 to 35, thick 3 or 4, Cdk5 7 or 8 of 0.7 times the depth,
ASPM none, SCN3A 5 to 7 in its window instead of 2 or 3. The sulci of TMEM161B are shallow for their cortex
(1.0 to 1.3 of its thickness; normal: 1.8 to 1.9) and for their gyri, not in length (1.5 to 1.9 normal T):
folds 1.5 times as far apart take up the excess surface, (e^{0.63} - 1)/(e^{0.84} - 1) = 2/3 of the normal, at
the same depth.
"""

from turingfold import Elastic, NeoHookean, Scene, SelfContact, figures, semicircle
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import RateGrowth
from turingfold.growth.zones import Window, Zone

THICKNESS, RATE, P32 = 0.1, 1.9, 0.44
TERMS = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact())
THIN_WINDOW = Zone(region=Window(start=0.35, end=0.65, edge=0.05), thickness=0.25)


def brain(growth, thickness=1.0, layers=4, quick=False):
    """Return a scene; thickness in units of the normal one, layers: elements across the cortex."""
    across = thickness * THICKNESS
    size = across / (2 if quick else layers)
    body = semicircle(radius=1.0, thickness=across, size=size, base="roller", layers="sigmoid")
    processes = (growth, Imperfection(amplitude=0.02))
    return Scene(body=body, processes=processes, terms=TERMS, until=0.1 if quick else P32)


def scenes(quick=False):
    return {
        "normal": brain(RateGrowth(rate=RATE), quick=quick),
        "PMG: T/4": brain(RateGrowth(rate=RATE), 0.25, 3, quick),
        "thick: 2 T": brain(RateGrowth(rate=RATE), 2.0, 5, quick),
        "SCN3A: local T/4": brain(RateGrowth(rate=RATE, zones=(THIN_WINDOW,)), layers=6, quick=quick),
        "ASPM: rate/4": brain(RateGrowth(rate=RATE / 4), quick=quick),
        "TMEM161B: 0.75 rate, 1.5 T": brain(RateGrowth(rate=0.75 * RATE), 1.5, quick=quick),
        "Cdk5: 0.75 rate": brain(RateGrowth(rate=0.75 * RATE), quick=quick),
        "ARHGAP11B: 1.15 rate, radial": brain(RateGrowth(rate=1.15 * RATE, radial_rate=0.6), quick=quick),
    }


def draw(results, figure):
    figures.grid(figure, {name: (result, -1) for name, result in results.items()}, columns=2, width=4.2)
