"""Figure 2: pattern, tension and growth of the whole brain fold the semi-ellipse. About 15 s.

    turingfold run cases/figure2.py      stores results/figure2, draws figures/figure2.png

Materials, thickness and growth are those of Figure 3, and the same --set options change them. The source does
not give the shape of its ellipse: half the width is the radius of Figure 3, and the height is 0.74 of that,
our choice. The cortex has the same thickness everywhere. The pattern has 20 half waves: 9 peaks, and half a
peak at each end of the pial surface. Without pattern the axons pull equally at as many places.
"""

from turingfold import figures, half, human, run_case, semiellipse
from turingfold import parameters as p


@p.quick(elements=2, along=1.0)
def scenes(
    quick=False, *,
    width: p.Width = 2 * 0.0404, height: p.Height = 0.74 * 0.0404, thickness: p.Thickness = 2.5e-3,
    elements: p.Elements = 3, along: p.Along = 2.0,
    base: p.Base = "clamped", layers: p.Layers = "sharp", seed: p.Seed = 0, halved: p.Halved = False,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 2.3, core: p.Core = 1.05, radial_core: p.RadialCore = 1.1, swelling: p.Swelling = 0.2,
    growth_law: p.GrowthLaw = "prescribed",
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.75,
    tension: p.Tension = True, pattern: p.Pattern = True, two_layers: p.TwoLayers = True,
    loads: p.Loads = "tension", dynamics: p.Dynamics = False, duration: p.Duration = 10.0,
):  # fmt: skip
    body = semiellipse(
        width=width, height=height, thickness=thickness, elements=elements, along=along, base=base,
        layers=layers,
    )  # fmt: skip
    half_waves = half_waves or human.half_waves(body, width=2.22)
    scene = human.brain(
        half(body) if halved else body, young_gray=young_gray, young_white=young_white, poisson=poisson,
        two_layers=two_layers,
        cortex=cortex, core=core, radial_core=radial_core, swelling=swelling, growth_law=growth_law,
        kinetics=kinetics, half_waves=half_waves, strength=strength, pattern=pattern, tension=tension,
        loads=loads, dynamics=dynamics, duration=duration, seed=seed,
    )  # fmt: skip
    return {"three hypotheses": scene}


def draw(results, figure):
    figures.folding(figure, results["three hypotheses"])


if __name__ == "__main__":
    run_case(__file__)
