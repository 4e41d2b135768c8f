"""Ferret, local malformations: growth or thickness changed in one zone of the surface. About 100 s.

    turingfold run cases/ferret_local.py -j 2      draws figures/ferret_local.png

The brain of ferret_malformations.py, with an elliptic zone around the apex in which the growth rate g and the
thickness T of the cortex are multiplied as the titles say. As the rate acts over the whole time, 2 g is the
square of the normal growth factor. Elements are smaller in the zone.
"""

import numpy as np

from turingfold import Elastic, NeoHookean, Scene, SelfContact, panels
from turingfold.growth import RateGrowth
from turingfold.imperfection import Imperfection
from turingfold.outlines import Fine, outline
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


def half_disc(size, share):
    """Return the upper half disc, with elements of `share` of the size around the apex."""
    angle = np.pi * np.arange(121) / 120
    arc = np.stack([np.append(np.cos(angle), 0.0), np.append(np.sin(angle), 0.0)])
    arc[1, 120] = 0.0
    fine = (Fine(centre=(0.0, 1.0), radius=0.45, share=share),)
    ends = ((-1.0, 0.0), (1.0, 0.0))
    return outline(arc, thickness=THICKNESS, size=size, base="roller", base_ends=ends, fine=fine)


def scenes(quick=False):
    found = {}
    for name, (growth, thickness) in CHANGES.items():
        share = 1.0 if quick else (thickness / growth) ** 0.5
        body = half_disc(THICKNESS / (2 if quick else 4), max(share, 0.4))
        zone = Zone(region=AROUND_APEX, growth=growth, thickness=thickness)
        processes = (RateGrowth(rate=RATE, zones=(zone,)), Imperfection(amplitude=0.02))
        found[name] = Scene(body=body, processes=processes, terms=TERMS, until=0.1 if quick else P32)
    return found


def draw(results, figure):
    panels.grid(figure, {name: (result, -1) for name, result in results.items()}, columns=2, width=4.2)
