"""Ferret, mesh independence: 1 : 4 : 8 : 12 times as many triangles in the cortex. About 2 min.

    turingfold run cases/ferret_mesh.py -j 2      draws figures/ferret_mesh.png

The growth of ferret_malformations.py: neither folds nor gyrification index may depend on the mesh. That needs
a choice of folds which is unique and the same on every mesh:

Drag. Past the onset a minimum of the elastic energy has many neighbours, and which of them Newton's method
finds depends on steps and mesh. With a drag c the body moves down the energy, c du/dt = -dΦ/du, and the waves
that grow fastest win everywhere at once; without it some gyri stay wide and split just about P32. c = 3 and
40 steps resolve that motion: c/dt = 273 exceeds the most negative eigenvalue of the tangent per mass of
density 1 (-68 to -211 at the ends of the steps, 1 x, seeds 0 to 3), so that the step has one minimum nearby.
The drag is part of the model: c = 1 and c = 10 choose other numbers of folds.
Noise of fold spacing and longer waves, even about apex and base as the sliding base is a mirror: half the
brain is computed. Noise that is not even makes sulci beside the base that come and go with the mesh.
Walls that touch at the same distance on every mesh.

Measured over the seeds 0 to 9, 1 x against 4 x: 9 or 10 sulci, the same number for every seed; gyrification
index 0.6 to 1.3 per cent lower on 1 x, a third of it because the surface is measured along chords. The four
meshes: seed 0 only. Amplitude, drag and coarsest mesh were chosen on the seeds 0 to 5; 6 to 9 were new.
"""

from turingfold import (
    Drag,
    Imperfection,
    RateGrowth,
    Scene,
    SelfContact,
    Stepping,
    ferret,
    figures,
    half,
    run_case,
    semicircle,
)
from turingfold import parameters as p


@p.quick(steps=10, until=0.1)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 4, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, drag: p.Drag = 3.0, amplitude: p.Amplitude = 0.05,
    until: p.Until = ferret.P32, steps: p.Steps = 40, seed: p.Seed = 0,
):  # fmt: skip
    found = {}
    for finer in (1, 4) if quick else (1, 4, 8, 12):
        size = thickness / elements / finer**0.5
        whole = semicircle(radius=1.0, thickness=thickness, size=size, base="roller", layers="sigmoid")
        walls = SelfContact(gap=0.4 * (finer / 12) ** 0.5)  # touch at the same distance on every mesh
        grow = RateGrowth(rate=rate, thinning=thinning)
        found[f"{finer} x"] = Scene(
            body=half(whole),
            processes=(grow, Imperfection(amplitude=amplitude, modes=10)),
            terms=(ferret.tissue(bulk=bulk), walls, Drag(coefficient=drag)),
            until=until,
            stepping=Stepping(first=1 / steps, largest=1 / steps),
            seed=seed,
        )
    return found


def draw(results, figure):
    counts = {name: 2 * result.scene.body.in_cortex.sum() for name, result in results.items()}
    notes = {name: f"{count} triangles in the cortex" for name, count in counts.items()}
    figures.grid(figure, {k: (r, -1) for k, r in results.items()}, columns=2, notes=notes, width=4.2)


if __name__ == "__main__":
    run_case(__file__)
