"""Ferret, local malformations: growth or thickness changed in one zone of the surface. About 3 min.

    turingfold run cases/ferret_local.py -j 2      draws figures/ferret_local.png

The brain of ferret_mesh.py, with an elliptic zone around the apex in which the growth rate g and the
thickness T of the cortex are multiplied as the titles say. As the rate acts over the whole time, 2 g is the
square of the normal growth factor. All have the same mesh, noise and drag, so that only the zone differs.
Without drag the tall, fine folds of 2 g, 0.25 T snap one after the other, which takes most of the time.

Nine elements through the cortex were chosen after seeing that with six and eight the last end of 2 g, 0.25 T
has two triangles turned over or edges that cross at the tip of a crease (5, 9: neither; 10 stops there).

Over the seeds 0, 1 and 2, with eight elements: 2 g deepens the folds of the zone from 1.6 to 1.8 T to 2.4 to
3.1 T; 0.25 T has 6 or 7 sulci there instead of 2 or 3, and normal ones beyond it.
"""

from turingfold import (
    Drag,
    Ellipse,
    Imperfection,
    RateGrowth,
    Scene,
    SelfContact,
    Stepping,
    Zone,
    ferret,
    figures,
    half,
    run_case,
    semicircle,
)
from turingfold import parameters as p

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


@p.quick(elements=2, steps=10, until=0.1)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 9, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, drag: p.Drag = 3.0, amplitude: p.Amplitude = 0.05,
    until: p.Until = ferret.P32, steps: p.Steps = 40, seed: p.Seed = 0,
):  # fmt: skip
    whole = semicircle(radius=1.0, thickness=thickness, elements=elements, base="roller", layers="sigmoid")
    terms = (ferret.tissue(bulk=bulk), SelfContact(), Drag(coefficient=drag))
    options = {"body": half(whole), "terms": terms, "until": until, "seed": seed}
    stepping = Stepping(first=1 / steps, largest=1 / steps)
    found = {}
    for name, (growth, share) in CHANGES.items():
        zone = Zone(region=AROUND_APEX, growth=growth, thickness=share)
        grow = RateGrowth(rate=rate, thinning=thinning, zones=(zone,))
        processes = (grow, Imperfection(amplitude=amplitude, modes=10))
        found[name] = Scene(processes=processes, stepping=stepping, **options)
    return found


def draw(results, figure):
    figures.grid(figure, {name: (result, -1) for name, result in results.items()}, columns=3)


if __name__ == "__main__":
    run_case(__file__)
