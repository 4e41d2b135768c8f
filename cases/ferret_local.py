"""Ferret, local malformations: growth or thickness changed in one zone of the surface. About 60 s.

    turingfold run cases/ferret_local.py      draws figures/ferret_local.png

The brain of ferret_malformations.py, with an elliptic zone around the apex in which the growth rate g and the
thickness T of the cortex are multiplied as the titles say. As the rate acts over the whole time, 2 g is the
square of the normal growth factor.
"""

from turingfold import Elastic, NeoHookean, Scene, SelfContact, panels, semicircle
from turingfold.growth import RateGrowth
from turingfold.imperfection import Imperfection
from turingfold.zones import Ellipse, Zone

THICKNESS, RATE, P32 = 0.1, 1.9, 0.44
TERMS = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact())
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
    found = {}
    for name, (growth, thickness) in CHANGES.items():
        layers = 2 if quick else 4 if thickness == 1 else 5
        body = semicircle(radius=1.0, thickness=THICKNESS, size=THICKNESS / layers, base="roller")
        zone = Zone(region=AROUND_APEX, growth=growth, thickness=thickness)
        processes = (RateGrowth(rate=RATE, zones=(zone,)), Imperfection(amplitude=0.02))
        found[name] = Scene(body=body, processes=processes, terms=TERMS, until=0.1 if quick else P32)
    return found


def draw(results, figure):
    panels.grid(figure, {name: (result, -1) for name, result in results.items()}, columns=2, width=4.2)
