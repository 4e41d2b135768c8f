"""Ferret, mesh independence: one brain on meshes of 1 : 4 : 8 : 12 times as many triangles. About 60 s.

    turingfold run cases/ferret_mesh.py      draws figures/ferret_mesh.png

The normal brain of ferret_malformations.py. The noise that decides where folds form is a function of the arc
length, not of the mesh, so that folds and gyrification index must not depend on the mesh either.
"""

from turingfold import Elastic, NeoHookean, Scene, SelfContact, panels, semicircle
from turingfold.growth import RateGrowth
from turingfold.imperfection import Imperfection

THICKNESS, COARSEST, P32 = 0.1, 0.036, 0.44
SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))


def scenes(quick=False):
    found = {}
    for finer in (1, 4) if quick else (1, 4, 8, 12):
        body = semicircle(radius=1.0, thickness=THICKNESS, size=COARSEST / finer**0.5, base="roller")
        walls = SelfContact(gap=0.4 * (finer / 12) ** 0.5)  # touch at the same distance on every mesh
        processes = (RateGrowth(rate=1.9), Imperfection(amplitude=0.05))
        until = 0.1 if quick else P32
        found[f"{finer} x"] = Scene(body=body, processes=processes, terms=(SOLID, walls), until=until)
    return found


def draw(results, figure):
    counts = {name: result.scene.body.in_cortex.sum() for name, result in results.items()}
    notes = {name: f"{count} triangles in the cortex" for name, count in counts.items()}
    panels.grid(figure, {k: (r, -1) for k, r in results.items()}, columns=2, notes=notes, width=4.2)
