"""Ferret, local malformations: growth or thickness changed in one zone of the surface. About 75 s.

    turingfold run cases/ferret_local.py -j 2      draws figures/ferret_local.png

The brain of ferret_mesh.py, with an elliptic zone around the apex in which the growth rate g and the
thickness T of the cortex are multiplied as the titles say. As the rate acts over the whole time, 2 g is the
square of the normal growth factor. All have the same mesh, noise and drag, so that only the zone differs.
Without drag the tall, fine folds of 2 g, 0.25 T snap one after the other, which takes most of the time.

Over the seeds 0, 1 and 2: 2 g deepens the folds of the zone from 1.6 to 1.8 T to 2.4 to 3.1 T; 0.25 T has 6
or 7 sulci there instead of 2 or 3, and normal ones beyond it.
"""

from turingfold import Drag, Elastic, NeoHookean, Scene, SelfContact, Stepping, figures, semicircle
from turingfold.geometry.mirror import half
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import RateGrowth
from turingfold.growth.zones import Ellipse, Zone

THICKNESS, RATE, P32 = 0.1, 1.9, 0.44
TERMS = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact(), Drag(coefficient=3.0))
AROUND_APEX = Ellipse(centre=(0.0, 1.0), semi_axes=(0.5, 0.4), edge=0.12)
CHANGES = {
    "normal": (1.0, 1.0),
    "1.5 g": (1.5, 1.0),
    "2 g": (2.0, 1.0),
    "0.5 T": (1.0, 0.5),
    "0.25 T": (1.0, 0.25),
    "1.5 g, 0.5 T": (1.5, 0.5),
    "2 g, 0.25 T": (2.0, 0.25),
}


def scenes(quick=False):
    size = THICKNESS / (2 if quick else 8)  # 2 elements across a quarter of the thickness
    body = half(semicircle(radius=1.0, thickness=THICKNESS, size=size, base="roller", layers="sigmoid"))
    step = 1 / 10 if quick else 1 / 40
    found = {}
    for name, (growth, thickness) in CHANGES.items():
        zone = Zone(region=AROUND_APEX, growth=growth, thickness=thickness)
        found[name] = Scene(
            body=body,
            processes=(RateGrowth(rate=RATE, zones=(zone,)), Imperfection(amplitude=0.05, modes=10)),
            terms=TERMS,
            until=0.1 if quick else P32,
            stepping=Stepping(first=step, largest=step),
        )
    return found


def draw(results, figure):
    figures.grid(figure, {name: (result, -1) for name, result in results.items()}, columns=3)
