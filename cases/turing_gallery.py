"""Ten kinetics on the cortical band of the semi-circle, and their activators along it. About 30 s.

    turingfold run cases/turing_gallery.py      draws figures/turing_gallery.png

Each at its published parameters, with the diffusivities that make 24 half waves the fastest mode of the band;
steady, certified by Newton's method and the leading eigenvalue. The mechanics is a body at rest.
"""

from turingfold import (
    BVAM,
    BVAM2012,
    Brusselator,
    Elastic,
    FitzHughNagumo,
    GiererMeinhardt,
    GrayScott,
    KochMeinhardt,
    LengyelEpstein,
    NeoHookean,
    Scene,
    Schnakenberg,
    Stepping,
    Thomas,
    Turing,
    figures,
    semicircle,
)

THICKNESS = 2.5e-3
KINETICS = {
    "Schnakenberg": Schnakenberg(),
    "Gierer-Meinhardt": GiererMeinhardt(),
    "Koch-Meinhardt, saturated": KochMeinhardt(),
    "Brusselator": Brusselator(),
    "Thomas": Thomas(),
    "Gray-Scott": GrayScott(),
    "Lengyel-Epstein": LengyelEpstein(),
    "BVAM, stripes": BVAM(),
    "BVAM 2012": BVAM2012(),
    "FitzHugh-Nagumo": FitzHughNagumo(),
}


def scenes(quick=False):
    body = semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / 6)
    gray = NeoHookean.from_young(1389.0, 0.4583)
    solid, at_once = Elastic(gray=gray, white=gray), Stepping(first=1.0, largest=1.0)
    return {
        name: Scene(body=body, processes=(Turing(kinetics),), terms=(solid,), stepping=at_once)
        for name, kinetics in list(KINETICS.items())[: 3 if quick else None]
    }


def draw(results, figure):
    figure.set_size_inches(13, 15)
    rows = figure.subplots(len(results), 2, width_ratios=(1, 3.2))
    for (band, curve), (name, result) in zip(rows, results.items(), strict=True):
        figures.activator(band, result, bar=False)
        body = result.scene.body
        along = body.spread(body.cortex, result.last["activator"])[body.pial]
        curve.plot(1e3 * body.pial_arc, along, color="#0072b2")
        words = f"{name}: activator from {along.min():.3g} to {along.max():.3g}"
        curve.set_title(words, fontsize=10, loc="left")
        curve.set_xlim(0, 1e3 * body.pial_arc[-1])
        curve.spines[["top", "right"]].set_visible(False)
        curve.tick_params(labelbottom=name == list(results)[-1])
    curve.set_xlabel("arc length along the pial surface (mm)")
