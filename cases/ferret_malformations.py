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
ASPM none, SCN3A 5 to 7 in its window instead of 2 or 3.

TMEM161B, published with shallower sulci and smaller gyri: reproduced is that it folds less (4 or 5 sulci for
8, gyrification index 1.25 to 1.33 for 1.57 to 1.62). Not reproduced are depth and size, in length: its sulci
are as deep (1.80 to 1.88 normal T for 1.80 to 1.88) and its gyri wider (5.9 to 7.0 normal T for 3.5 to 3.9).
In the plane folds of a cortex 1.5 times as thick are that much farther apart, and half as many take up the
excess length, (e^{0.63} - 1)/(e^{0.84} - 1) = 2/3 of the normal, at the same depth.
"""

from turingfold import (
    Imperfection,
    RateGrowth,
    Scene,
    SelfContact,
    Window,
    Zone,
    ferret,
    figures,
    run_case,
    semicircle,
)
from turingfold import parameters as p

THIN_WINDOW = Zone(region=Window(start=0.35, end=0.65, edge=0.05), thickness=0.25)


@p.quick(elements=2, until=0.1)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 4, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, radial_rate: p.Rate = 0.6,
    amplitude: p.Amplitude = 0.02, until: p.Until = ferret.P32, seed: p.Seed = 0,
):  # fmt: skip
    def brain(growth, times=1.0, more=1.0, **options):
        """Return a scene; growth, thickness and elements over the normal ones."""
        across = elements if quick else elements * more
        body = semicircle(
            radius=1.0, thickness=times * thickness, elements=across, base="roller", layers="sigmoid"
        )
        grow = RateGrowth(rate=growth * rate, thinning=thinning, **options)
        terms, noise = (ferret.tissue(bulk=bulk), SelfContact()), Imperfection(amplitude=amplitude)
        return Scene(body=body, processes=(grow, noise), terms=terms, until=until, seed=seed)

    return {
        "normal": brain(1.0),
        "PMG: T/4": brain(1.0, 0.25, 0.75),
        "thick: 2 T": brain(1.0, 2.0, 1.25),
        "SCN3A: local T/4": brain(1.0, more=1.5, zones=(THIN_WINDOW,)),
        "ASPM: rate/4": brain(0.25),
        "TMEM161B: 0.75 rate, 1.5 T": brain(0.75, 1.5),
        "Cdk5: 0.75 rate": brain(0.75),
        "ARHGAP11B: 1.15 rate, radial": brain(1.15, radial_rate=radial_rate),
    }


def draw(results, figure):
    figures.grid(figure, {name: (result, -1) for name, result in results.items()}, columns=2, width=4.2)


if __name__ == "__main__":
    run_case(__file__)
