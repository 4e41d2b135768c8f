"""Figure 3: pattern, tension and growth of the whole brain fold the semi-circle. About 15 s.

    turingfold run cases/figure3.py      stores results/figure3, draws figures/figure3.png

Half a brain slice of the 28th gestational week: radius 40.4 mm, cortex 2.5 mm, gray 1389 Pa, white 1895 Pa.
The cortex grows by 130 % along its surface, the core by 5 % along it and 10 % across, and its inner half
swells by 20 % more: values chosen by cases/growth_of_the_core.py. The pattern has 24 half waves: 11 peaks,
and half a peak at each end of the pial surface. Without pattern the axons pull equally at as many places.

    --set growth_law=cortex   only the cortex grows
    --set growth_law=stress   the core grows in response to the stress that it bears
    --set loads=figure1       arrows on the pial surface in place of the tension (sulci on the peaks)
    --set halved=on           half is computed, and mirrored: half the time and energy, no asymmetry
    --set dynamics=on         with inertia, from rest, within `duration`; minutes
"""

from turingfold import figures, half, human, run_case, semicircle
from turingfold import parameters as p


@p.quick(elements=2, along=1.0)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3,
    elements: p.Elements = 3, along: p.Along = 2.0,
    base: p.Base = "clamped", layers: p.Layers = "sharp", seed: p.Seed = 0, halved: p.Halved = False,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 2.3, core: p.Core = 1.05, radial_core: p.RadialCore = 1.1, swelling: p.Swelling = 0.2,
    growth_law: p.GrowthLaw = "prescribed",
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.75,
    tension: p.Tension = True, pattern: p.Pattern = True, two_layers: p.TwoLayers = True,
    loads: p.Loads = "tension", dynamics: p.Dynamics = False, duration: p.Duration = 10.0,
):  # fmt: skip
    body = semicircle(
        radius=radius, thickness=thickness, elements=elements, along=along, base=base, layers=layers
    )
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
