"""Ferret, malformations of a folded brain: growth or cortex differ after the first folds. About 2 min.

    turingfold run cases/ferret_folded.py -j 2      draws figures/ferret_folded.png

As in Choi et al. 2025, whose malformed brains start from the folded one of P8 and not from a smooth one.
Here they start, free of stress, from the published coronal section of the left hemisphere at stage 3 (index
1.14), read as in ferret_outlines.py; it crosses itself three times, is taken apart there, and is smoothed
over 0.04. The normal cortex, T = 0.1, grows at the rate 1.9 with thinning, none at the bottom (y < -0.4); the
malformed ones as in ferret_malformations.py. At t = 0.36 it has grown by 2.0; at 0.24, tried first, by 1.6,
where nothing new folds.

The sulci that were there deepen in all but ASPM (index 1.12; normal 1.29), and choose where others come: two
for the normal cortex. PMG covers the old gyri with fine folds (30 sulci for 7), SCN3A the zone above alone;
twice the thickness and TMEM161B add none. Seed 0.
"""

import os
from functools import partial
from pathlib import Path

from turingfold import (
    Ellipse,
    Imperfection,
    RateGrowth,
    Scene,
    SelfContact,
    Zone,
    ferret,
    figures,
    outline,
    run_case,
)
from turingfold import parameters as p

BESIDE = Path(__file__).parents[2] / "shared" / "reference" / "ferret"
FOLDER = Path(os.environ.get("FERRET_OUTLINES", BESIDE))
published = partial(ferret.published_outline, FOLDER)
TOP = Ellipse(centre=(-0.4, 0.6), semi_axes=(0.45, 0.45), edge=0.12)


@p.quick(elements=2, until=0.05)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 3, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, amplitude: p.Amplitude = 0.02,
    until: p.Until = 0.36, seed: p.Seed = 0,
):  # fmt: skip
    def brain(growth, times=1.0, more=1.0, zones=()):
        """Return a scene; growth, thickness and elements over the normal ones."""
        across = elements if quick else elements * more
        body = outline(
            published("left", 3), smooth=0.04, thickness=times * thickness, elements=across, layers="sigmoid"
        )
        grow = RateGrowth(rate=growth * rate, thinning=thinning, zones=(ferret.BOTTOM, *zones))
        terms, noise = (ferret.tissue(bulk=bulk), SelfContact()), Imperfection(amplitude=amplitude)
        return Scene(body=body, processes=(grow, noise), terms=terms, until=until, seed=seed)

    return {
        "normal": brain(1.0),
        "PMG: T/4": brain(1.0, 0.25, 0.75),
        "thick: 2 T": brain(1.0, 2.0, 1.25),
        "SCN3A: T/4 above": brain(1.0, more=1.5, zones=(Zone(region=TOP, thickness=0.25),)),
        "ASPM: rate/4": brain(0.25),
        "TMEM161B: 0.75 rate, 1.5 T": brain(0.75, 1.5),
    }


def draw(results, figure):
    shown = {name: (result, -1) for name, result in results.items()}
    for axes, result in zip(figures.grid(figure, shown, columns=3, width=3.0), results.values(), strict=True):
        figures.before(axes, result)


if __name__ == "__main__":
    run_case(__file__)
