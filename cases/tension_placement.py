"""Where axons pull, and which way, decides what stands on the peaks of the pattern. About 60 s.

    turingfold run cases/tension_placement.py      draws figures/tension_placement.png

Tension on the pial surface towards the peaks (the arrows of the source's Figure 1), on the pial surface away
from them, and along the gray-white interface; each with a pattern near the intrinsic spacing of folds (24
half waves) and one of half that wave number. Registration: +1 gyri, -1 sulci on the peaks of the activator.
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
    registration,
    semicircle,
)

THICKNESS = 2.5e-3
PLACES = {
    "pial, towards peaks": AxonalTension(strength=150.0, surface="pial", direction="toward-peaks"),
    "pial, between peaks": AxonalTension(strength=150.0, surface="pial", direction="between-peaks"),
    "interface": AxonalTension(strength=0.5, surface="interface"),
}
HALF_WAVES = (24, 12)
EARLY = 0.15  # time at which the load has its strength and growth has not folded the cortex yet


def scenes(quick=False):
    body = semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / (2 if quick else 4))
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    solid, contact, grow = Elastic(gray=gray, white=white), SelfContact(), TangentialGrowth(cortex=1.9)
    found = {}
    for place, pull in PLACES.items():
        for count in HALF_WAVES:
            processes, terms = (Turing(Schnakenberg(), half_waves=count), grow), (solid, pull, contact)
            found[f"{place}, {count} half waves"] = Scene(body=body, processes=processes, terms=terms)
    return found


def draw(results, figure):
    figure.set_size_inches(12, 9)
    for axes, name, result in figures.section_grid(figure, len(PLACES), len(HALF_WAVES), results):
        early = next(k for k, state in enumerate(result.states) if state.time >= EARLY)
        before, after = (registration(result.pattern(), result.pial(k), result.pial(0)) for k in (early, -1))
        folds = figures.sulci(result.summary()["folds"])
        words = f"registration {before:+.2f} before folding, {after:+.2f} after; {folds}"
        axes.set_title(f"{name}\n{words}", fontsize=10)
