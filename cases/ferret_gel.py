"""Gel brains: a coat of 1, 4 or 8 layers that swells from outside folds the finer the thinner it is. 7 min.

    turingfold run cases/ferret_gel.py      draws figures/ferret_gel.png

The two-layer gel experiment: a core with 1, 4 or 8 coats, each 0.025 of the radius thick, put into solvent
for 1.5 h (t = 1). The solvent diffuses in from the surface with D = 0.02 radius² per 1.5 h, that is 1e-9 m²/s
for a radius of 16 mm; a wet coat is 2.5 times as long. Same moduli for coat and core (mu = 1, kappa = 5): our
choices.
"""

from turingfold import (
    Imperfection,
    Scene,
    SelfContact,
    Swelling,
    ferret,
    figures,
    run_case,
    semicircle,
)
from turingfold import parameters as p

COATS = {1: 1, 4: 4 / 3, 8: 5 / 3}  # elements across so many coats, over those across one


@p.quick(elements=2, swelling=1.2)
def scenes(
    quick=False, *,
    coat: p.RelativeThickness = 0.025, elements: p.Elements = 3, bulk: p.BulkRatio = 5.0,
    swelling: p.Cortex = 2.5, diffusivity: p.Diffusivity = 0.02,
    amplitude: p.Amplitude = 0.005, seed: p.Seed = 0,
):  # fmt: skip
    found = {}
    for coats, more in COATS.items():
        across = elements if quick else elements * more
        body = semicircle(
            radius=1.0, thickness=coats * coat, elements=across, base="roller", layers="sigmoid"
        )
        wet = Swelling(
            coefficient=swelling - 1.0, zone="cortex", diffusivity=diffusivity, source="pial",
            out_of_plane="fixed",
        )  # fmt: skip
        processes, terms = (wet, Imperfection(amplitude=amplitude)), (ferret.tissue(bulk=bulk), SelfContact())
        name = f"{coats} coats" if coats > 1 else "1 coat"
        found[name] = Scene(body=body, processes=processes, terms=terms, seed=seed)
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


if __name__ == "__main__":
    run_case(__file__)
