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

from turingfold import (
    Imperfection,
    RateGrowth,
    Scene,
    SelfContact,
    Stepping,
    ferret,
    figures,
    outline,
    remeshed,
    run_case,
    simulate,
)
from turingfold import parameters as p

STAGES = {"P0 to P4": 0.36, "P4 to P8": 0.12, "P8 to P16": 0.12, "P16 to P32": 0.12}


@p.quick(elements=2, steps=4, shorter=6, inset=0.02)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 3, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, amplitude: p.Amplitude = 0.1,
    inset: p.Inset = 0.008, shorter: p.Shorter = 1.0, steps: p.Steps = 16, seed: p.Seed = 0,
):  # fmt: skip
    size = thickness / elements
    body = outline(ferret.circle(), thickness=thickness, size=size, layers="sigmoid")
    grow = RateGrowth(rate=rate, thinning=thinning, zones=(ferret.BOTTOM,))
    processes = (grow, Imperfection(amplitude=amplitude, modes=20))
    terms, stepping = (ferret.tissue(bulk=bulk), SelfContact()), Stepping(first=1 / steps, largest=1 / steps)
    found = {}
    for name, duration in STAGES.items():
        if found:
            before = simulate(found[list(found)[-1]]).last
            body = remeshed(body, before, size=size, inset=inset)
        found[name] = Scene(
            body=body, processes=processes, terms=terms, until=duration / shorter, seed=seed,
            stepping=stepping,
        )  # fmt: skip
    return found


def draw(results, figure):
    shown = {name: (result, -1) for name, result in results.items()}
    for axes, result in zip(figures.grid(figure, shown, columns=4, width=3.0), results.values(), strict=True):
        figures.before(axes, result)


if __name__ == "__main__":
    run_case(__file__)
