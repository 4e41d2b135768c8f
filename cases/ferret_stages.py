"""Ferret, development in stages: each starts free of stress from the shape reached before. About 40 s.

    turingfold run cases/ferret_stages.py      draws figures/ferret_stages.png

The brain of ferret_normal.py in the stages P0 to P4, P8, P16 and P32. Each stage begins with the outline
traced anew on the deformed section (0.008 inside it, so that closed sulci stand open by two per cent of the
radius), the nominal cortex and no stress. The first stage grows by e^{1.9 · 0.36} = 2.0, past the threshold
of folding; each later one by only e^{1.9 · 0.12} = 1.26, far below it, and yet the folds deepen, for they are
in the shape already. How growth is shared among the stages is our choice. The early stages are run when the
scenes are made.

Over the seeds 0 to 4 all outlines can be traced, and the gyrification index grows from 1.23 to 1.26 at P4 to
1.62 to 1.69 at P32.
"""

from functools import cache

import numpy as np

from turingfold import Elastic, NeoHookean, Scene, SelfContact, Stepping, figures, simulate
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import RateGrowth
from turingfold.growth.zones import HalfPlane, Zone
from turingfold.outlines import outline
from turingfold.outlines.remesh import retraced

THICKNESS = 0.1
STAGES = {"P0 to P4": 0.36, "P4 to P8": 0.12, "P8 to P16": 0.12, "P16 to P32": 0.12}
BOTTOM = Zone(region=HalfPlane(point=(0, -0.4), normal=(0, 1), edge=0.2, ramp="straight"), growth=0.0)


@cache  # each stage needs the ends of all before it
def stages(seed=0, quick=False):
    """Return the scenes by name; each is made of the end of the last."""
    size = THICKNESS / (2 if quick else 3)
    angle = 2 * np.pi * np.arange(240) / 240
    body = outline(np.stack([np.cos(angle), np.sin(angle)]), thickness=THICKNESS, size=size, layers="sigmoid")
    processes = (RateGrowth(rate=1.9, zones=(BOTTOM,)), Imperfection(amplitude=0.1, modes=20))
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact())
    steps = Stepping(first=0.25, largest=0.25) if quick else Stepping(first=1 / 16, largest=1 / 16)
    found = {}
    for name, duration in STAGES.items():
        if found:
            before = simulate(found[list(found)[-1]]).last
            body = retraced(body, before, size=size, inset=0.02 if quick else 0.008)
        until = duration / 6 if quick else duration
        found[name] = Scene(
            body=body, processes=processes, terms=terms, until=until, stepping=steps, seed=seed
        )
    return found


def scenes(quick=False):
    return dict(stages(quick=quick))


def draw(results, figure):
    shown = {name: (result, -1) for name, result in results.items()}
    for axes, result in zip(figures.grid(figure, shown, columns=4, width=3.0), results.values(), strict=True):
        figures.before(axes, result)
