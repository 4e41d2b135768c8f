"""Where axons pull, and which way, decides what stands on the peaks of the pattern. About 60 s.

    turingfold run cases/tension_placement.py      draws figures/tension_placement.png

Tension on the pial surface towards the peaks (the arrows of the source's Figure 1), on the pial surface away
from them, and along the gray-white interface; each with a pattern near the intrinsic spacing of folds (24
half waves) and one of half that wave number. Registration: +1 gyri, -1 sulci on the peaks of the activator;
p: share of the pattern's phases that would register as well or better, near 1 for sulci on the peaks.
"""

from turingfold import (
    AxonalTension,
    Scene,
    SelfContact,
    TangentialGrowth,
    Turing,
    figures,
    human,
    kinetics_named,
    registration,
    run_case,
    semicircle,
)
from turingfold import parameters as p

EARLY = 0.15  # time at which the load has its strength and growth has not folded the cortex yet


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 4,
    base: p.Base = "clamped", seed: p.Seed = 0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 1.9, core: p.Core = 1.0, radial_core: p.RadialCore = 1.0,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.5,
    traction: p.Traction = 150.0,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    half_waves = half_waves or human.half_waves(body)
    solid = human.tissue(young_gray=young_gray, young_white=young_white, poisson=poisson)
    grow = TangentialGrowth(cortex=cortex, core=core, radial_core=radial_core)
    places = {
        "pial, towards peaks": AxonalTension(strength=traction, surface="pial", direction="toward-peaks"),
        "pial, between peaks": AxonalTension(strength=traction, surface="pial", direction="between-peaks"),
        "interface": AxonalTension(strength=strength, surface="interface"),
    }
    found = {}
    for place, pull in places.items():
        for count in (half_waves, max(1, half_waves // 2)):
            processes = (Turing(kinetics_named(kinetics), half_waves=count), grow)
            scene = Scene(body=body, processes=processes, terms=(solid, pull, SelfContact()), seed=seed)
            found[f"{place}, {count} half waves"] = scene
    return found


def draw(results, figure):
    figure.set_size_inches(12, 9)
    for axes, name, result in figures.section_grid(figure, 3, 2, results):
        early = next(k for k, state in enumerate(result.states) if state.time >= EARLY)
        before = registration(result.pattern(), result.pial(early), result.pial(0))
        s = result.summary()
        after = f"{s['registration']:+.2f} after (p = {s['registration_p']:.2f})"
        words = f"registration {before:+.2f} before folding, {after}; {figures.sulci(s['folds'])}"
        axes.set_title(f"{name}\n{words}", fontsize=10)


if __name__ == "__main__":
    run_case(__file__)
