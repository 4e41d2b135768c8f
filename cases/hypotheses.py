"""The three hypotheses on and off: eight combinations on the semi-circle. About 60 s.

    turingfold run cases/hypotheses.py      stores results/hypotheses, draws figures/hypotheses.png

DGH, differential growth: the cortex grows by 90 % and is softer than the core; off, one material that grows
by 20 % everywhere.  ATH, axonal tension: on the gray-white interface; off, no load.  IPH, intermediate
progenitors: a Turing pattern says where the axons pull and how strongly; off, there is no morphogen, and the
axons pull equally on eight evenly spaced patches. The pattern acts through the tension alone: without ATH it
is there and moves nothing.
"""

from itertools import product

from turingfold import Scene, SelfContact, TangentialGrowth, figures, human, run_case, semicircle
from turingfold import parameters as p


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 4,
    base: p.Base = "clamped", seed: p.Seed = 0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 1.9, core: p.Core = 1.0, radial_core: p.RadialCore = 1.0, even: p.Even = 1.2,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.5,
    patches: p.Patches = 8,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    half_waves = half_waves or human.half_waves(body)

    def scene(differential, tension, pattern):
        solid = human.tissue(
            young_gray=young_gray, young_white=young_white, poisson=poisson, two_layers=differential
        )
        morphogens, pull = human.pattern_and_pull(
            kinetics=kinetics, half_waves=half_waves, strength=strength, pattern=pattern, tension=tension,
            patches=patches,
        )  # fmt: skip
        grow = TangentialGrowth(cortex=cortex, core=core, radial_core=radial_core)
        if not differential:
            grow = TangentialGrowth(cortex=even, core=even, radial_core=even, radial_cortex=even)
        terms = (solid, *pull, SelfContact())
        return Scene(body=body, processes=(*morphogens, grow), terms=terms, seed=seed)

    return {name_of(*on): scene(*on) for on in product((True, False), repeat=3)}


def name_of(differential, tension, pattern):
    on = zip(("DGH", "ATH", "IPH"), (differential, tension, pattern), strict=True)
    return " + ".join(name for name, there in on if there) or "none"


def draw(results, figure):
    figure.set_size_inches(12, 12)
    for axes, name, result in figures.section_grid(figure, 4, 2, results):
        idle = "IPH" in name and "ATH" not in name
        note = " (the pattern has no way to act)" if idle else ""
        axes.set_title(f"{name}{note}\n{figures.measures(result)}", fontsize=10)


if __name__ == "__main__":
    run_case(__file__)
