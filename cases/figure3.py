"""Figure 3: pattern, tension and differential growth fold the semi-circle. About 20 s.

    turingfold run cases/figure3.py      stores results/figure3, draws figures/figure3.png

Half a brain slice of the 28th gestational week: radius 40.4 mm, cortex 2.5 mm, gray 1389 Pa, white 1895 Pa,
the cortex growing by 90 % along its surface. The pattern has 24 half waves: 11 peaks, and half a peak at each
end of the pial surface.
"""

from turingfold import (
    AxonalTension,
    Elastic,
    NeoHookean,
    Scene,
    Schnakenberg,
    SelfContact,
    TangentialGrowth,
    Turing,
    figures,
    semicircle,
)

THICKNESS = 2.5e-3
PULL = AxonalTension(strength=0.5)


def scenes(quick=False):
    body = semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / (2 if quick else 6))
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    pattern, grow = Turing(Schnakenberg(), half_waves=24), TangentialGrowth(cortex=1.9)
    terms = (Elastic(gray=gray, white=white), PULL, SelfContact())
    return {"three hypotheses": Scene(body=body, processes=(pattern, grow), terms=terms)}


def draw(results, figure):
    figures.folding(figure, results["three hypotheses"], term=PULL)
