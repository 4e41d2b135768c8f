"""Ferret, normal development: continuous growth from P0 to P32. About 15 s.

    turingfold run cases/ferret_normal.py      draws figures/ferret_normal.png

A coronal section, dimensionless as in Choi et al. 2025: a disc of radius 1, shear modulus 1, bulk modulus 5,
cortex T = 0.1 that grows at the rate 1.9 and thins to T (1 - t/2), no growth in the middle (r < 0.5) and at
the bottom (y < -0.4), each with a ramp of 0.2. P32 is t = 0.44, where the cortex has grown by e^{0.84} = 2.3
along its surface; that growth slows down with age, to 1/e in 12 days, is our choice.
"""

import numpy as np

from turingfold import Elastic, NeoHookean, Scene, SelfContact, figures
from turingfold.growth.histories import growth_time
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import RateGrowth
from turingfold.growth.zones import Ellipse, HalfPlane, Zone
from turingfold.outlines import outline

THICKNESS, P32 = 0.1, 0.44
MIDDLE = Zone(region=Ellipse(centre=(0, 0), semi_axes=(0.5, 0.5), edge=0.2, ramp="straight"), growth=0.0)
BOTTOM = Zone(region=HalfPlane(point=(0, -0.4), normal=(0, 1), edge=0.2, ramp="straight"), growth=0.0)


def scenes(quick=False):
    angle = 2 * np.pi * np.arange(240) / 240
    circle = np.stack([np.cos(angle), np.sin(angle)])
    body = outline(circle, thickness=THICKNESS, size=THICKNESS / (2 if quick else 4), layers="sigmoid")
    processes = (RateGrowth(rate=1.9, zones=(MIDDLE, BOTTOM)), Imperfection(amplitude=0.02))
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact())
    return {"continuous": Scene(body=body, processes=processes, terms=terms, until=0.1 if quick else P32)}


def draw(results, figure):
    result = results["continuous"]
    shown = {}
    for day in (0, 4, 8, 16, 32):
        time = growth_time(day, duration=result.scene.until)
        shown[f"P{day}"] = result, figures.nearest_step(result, time)
    figures.grid(figure, shown, columns=5, width=2.6)
