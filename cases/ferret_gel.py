"""Gel brains: a coat of 1, 4 or 8 layers that swells from outside folds the finer the thinner it is. 45 s.

    turingfold run cases/ferret_gel.py      draws figures/ferret_gel.png

The two-layer gel experiment: a core with 1, 4 or 8 coats, each 0.025 of the radius thick, put into solvent
for 1.5 h (t = 1). The solvent reaches depth y as erfc(y/√(4 D t)) with D = 0.02 radius² per 1.5 h, that is
1e-9 m²/s for a radius of 16 mm; a wet coat is 2.5 times as long. Same moduli for coat and core (mu = 1, kappa
= 5): our choices.
"""

from turingfold import Elastic, NeoHookean, Scene, SelfContact, figures, semicircle
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.swelling import SurfaceSwelling

COAT = 0.025
LAYERS = {1: 3, 4: 4, 8: 5}  # elements across so many coats


def scenes(quick=False):
    found = {}
    for coats, layers in LAYERS.items():
        thickness = coats * COAT
        size = thickness / (2 if quick else layers)
        body = semicircle(radius=1.0, thickness=thickness, size=size, base="roller", layers="sigmoid")
        swelling = SurfaceSwelling(final=1.2 if quick else 2.5, diffusivity=0.02)
        terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact())
        name = f"{coats} coats" if coats > 1 else "1 coat"
        found[name] = Scene(body=body, processes=(swelling, Imperfection(amplitude=0.005)), terms=terms)
    return found


def draw(results, figure):
    shown = {}
    for name, result in results.items():
        for minutes in (30, 90):
            title = f"{name}, {minutes} min"
            shown[title] = result, figures.nearest_step(result, result.scene.until * minutes / 90)
    drawn = figures.grid(figure, shown, columns=2)
    for axes, (result, _) in zip(drawn, shown.values(), strict=True):
        figures.before(axes, result)
