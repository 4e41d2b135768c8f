"""The three hypotheses on and off: eight combinations on the semi-circle. About 60 s.

    turingfold run cases/hypotheses.py      stores results/hypotheses, draws figures/hypotheses.png

DGH, differential growth: the cortex grows by 90 % and is softer than the core; off, one material that grows
by 20 % everywhere.  ATH, axonal tension: on the gray-white interface; off, no load.  IPH, intermediate
progenitors: a Turing pattern says where the axons pull and how strongly; off, there is no morphogen, and the
axons pull equally on eight evenly spaced patches. The pattern acts through the tension alone: without ATH it
is there and moves nothing.
"""

from itertools import product

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
    semicircle,
)

THICKNESS = 2.5e-3
GRAY, WHITE = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)


def scenes(quick=False):
    body = semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / (2 if quick else 4))
    return {name_of(*on): scene(body, *on) for on in product((True, False), repeat=3)}


def name_of(differential, tension, pattern):
    on = zip(("DGH", "ATH", "IPH"), (differential, tension, pattern), strict=True)
    return " + ".join(name for name, there in on if there) or "none"


def scene(body, differential, tension, pattern):
    if differential:
        solid, grow = Elastic(gray=GRAY, white=WHITE), TangentialGrowth(cortex=1.9)
    else:
        solid, grow = Elastic(gray=GRAY), TangentialGrowth(cortex=1.2, core=1.2, radial_core=1.2)
    morphogen = (Turing(Schnakenberg(), half_waves=24),) if pattern else ()
    pull = (AxonalTension(strength=0.5, patches=0 if pattern else 8),) if tension else ()
    return Scene(body=body, processes=(*morphogen, grow), terms=(solid, *pull, SelfContact()))


def draw(results, figure):
    figure.set_size_inches(12, 12)
    for axes, name, result in figures.section_grid(figure, 4, 2, results):
        idle = "IPH" in name and "ATH" not in name
        note = " (the pattern has no way to act)" if idle else ""
        axes.set_title(f"{name}{note}\n{figures.measures(result)}", fontsize=10)
