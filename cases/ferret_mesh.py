"""Ferret, mesh independence: 1 : 4 : 8 : 12 times as many triangles in the cortex. About 70 s.

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

from turingfold import Drag, Elastic, NeoHookean, Scene, SelfContact, Stepping, figures, semicircle
from turingfold.geometry.mirror import half
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import RateGrowth

THICKNESS, COARSEST, P32 = 0.1, 0.025, 0.44
SOLID, FLOW = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), Drag(coefficient=3.0)
PROCESSES = (RateGrowth(rate=1.9), Imperfection(amplitude=0.05, modes=10))


def brain(finer, seed=0, quick=False):
    """Return a scene with `finer` times as many triangles in the cortex as the coarsest mesh has."""
    size = COARSEST / finer**0.5
    whole = semicircle(radius=1.0, thickness=THICKNESS, size=size, base="roller", layers="sigmoid")
    walls = SelfContact(gap=0.4 * (finer / 12) ** 0.5)  # touch at the same distance on every mesh
    step = 1 / 10 if quick else 1 / 40
    return Scene(
        body=half(whole),
        processes=PROCESSES,
        terms=(SOLID, walls, FLOW),
        until=0.1 if quick else P32,
        stepping=Stepping(first=step, largest=step),
        seed=seed,
    )


def scenes(quick=False):
    return {f"{finer} x": brain(finer, quick=quick) for finer in ((1, 4) if quick else (1, 4, 8, 12))}


def draw(results, figure):
    counts = {name: 2 * result.scene.body.in_cortex.sum() for name, result in results.items()}
    notes = {name: f"{count} triangles in the cortex" for name, count in counts.items()}
    figures.grid(figure, {k: (r, -1) for k, r in results.items()}, columns=2, notes=notes, width=4.2)
