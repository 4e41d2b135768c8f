"""Figure 2: pattern, tension and differential growth fold the semi-ellipse. About 20 s.

    turingfold run cases/figure2.py      stores results/figure2, draws figures/figure2.png

Materials, thickness and growth are those of Figure 3. The source does not give the shape of its ellipse: half
the width is the radius of Figure 3, and the height is 0.74 of that, our choice. The cortex has the same
thickness everywhere. The pattern has 20 half waves: 9 peaks, and half a peak at each end of the pial surface.
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
    semiellipse,
)

THICKNESS = 2.5e-3
RATIO = 0.74  # height over half the width
PULL = AxonalTension(strength=0.5)


def scenes(quick=False):
    body = semiellipse(
        width=2 * 0.0404, height=RATIO * 0.0404, thickness=THICKNESS, size=THICKNESS / (2 if quick else 6)
    )
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    pattern, grow = Turing(Schnakenberg(), half_waves=20), TangentialGrowth(cortex=1.9)
    terms = (Elastic(gray=gray, white=white), PULL, SelfContact())
    return {"three hypotheses": Scene(body=body, processes=(pattern, grow), terms=terms)}


def draw(results, figure):
    figures.folding(figure, results["three hypotheses"], term=PULL)
