"""Ferret, mesh independence: 1 : 4 : 8 : 12 times as many triangles in the cortex. About 60 s.

    turingfold run cases/ferret_mesh.py      draws figures/ferret_mesh.png

The normal brain of ferret_malformations.py, with noise that has wave lengths of fold spacing and more and is
function of the arc length, not of the mesh: it decides where folds form, so that neither they nor the
gyrification index may depend on the mesh. (With the weaker and finer noise of the other cases a fold more or
less can depend on the steps taken.)
"""

from turingfold import Elastic, NeoHookean, Scene, SelfContact, panels, semicircle
from turingfold.growth import RateGrowth
from turingfold.imperfection import Imperfection

THICKNESS, COARSEST, P32 = 0.1, 0.034, 0.44
SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))


def scenes(quick=False):
    found = {}
    for finer in (1, 4) if quick else (1, 4, 8, 12):
        body = semicircle(radius=1.0, thickness=THICKNESS, size=COARSEST / finer**0.5, base="roller")
        walls = SelfContact(gap=0.4 * (finer / 12) ** 0.5)  # touch at the same distance on every mesh
        processes = (RateGrowth(rate=1.9), Imperfection(amplitude=0.1, modes=20))
        until = 0.1 if quick else P32
        found[f"{finer} x"] = Scene(body=body, processes=processes, terms=(SOLID, walls), until=until, seed=2)
    return found


def draw(results, figure):
    counts = {name: result.scene.body.in_cortex.sum() for name, result in results.items()}
    notes = {name: f"{count} triangles in the cortex" for name, count in counts.items()}
    panels.grid(figure, {k: (r, -1) for k, r in results.items()}, columns=2, notes=notes, width=4.2)
