"""Figure 3: pattern, tension and differential growth fold the semi-circle. About 20 s.

    turingfold run cases/figure3.py      stores results/figure3, draws figures/figure3.png

Half a brain slice of the 28th gestational week: radius 40.4 mm, cortex 2.5 mm, gray 1389 Pa, white 1895 Pa,
the cortex growing by 90 % along its surface. The pattern has 24 half waves: 11 peaks, and half a peak at each
end of the pial surface. Without pattern the axons pull equally at as many places.
"""

from turingfold import Scene, SelfContact, TangentialGrowth, figures, human, run_case, semicircle
from turingfold import parameters as p


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 6,
    base: p.Base = "clamped", layers: p.Layers = "sharp", seed: p.Seed = 0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 1.9, core: p.Core = 1.0, radial_core: p.RadialCore = 1.0,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.5,
    tension: p.Tension = True, pattern: p.Pattern = True, two_layers: p.TwoLayers = True,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base, layers=layers)
    half_waves = half_waves or human.half_waves(body)
    solid = human.tissue(
        young_gray=young_gray, young_white=young_white, poisson=poisson, two_layers=two_layers
    )
    morphogens, pull = human.pattern_and_pull(
        kinetics=kinetics, half_waves=half_waves, strength=strength, pattern=pattern, tension=tension
    )
    grow = TangentialGrowth(cortex=cortex, core=core, radial_core=radial_core)
    processes, terms = (*morphogens, grow), (solid, *pull, SelfContact())
    return {"three hypotheses": Scene(body=body, processes=processes, terms=terms, seed=seed)}


def draw(results, figure):
    figures.folding(figure, results["three hypotheses"])


if __name__ == "__main__":
    run_case(__file__)
