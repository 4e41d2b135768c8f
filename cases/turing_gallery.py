"""Ten kinetics on the cortical band of the semi-circle, and their activators along it. About 30 s.

    turingfold run cases/turing_gallery.py      draws figures/turing_gallery.png

Each at its published parameters, with the diffusivities that make 24 half waves the fastest mode of the band;
steady, certified by Newton's method and the leading eigenvalue. The mechanics is a body at rest.
"""

from turingfold import Scene, Stepping, Turing, figures, human, kinetics_named, run_case, semicircle
from turingfold import parameters as p

KINETICS = {
    "Schnakenberg": "Schnakenberg",
    "Gierer-Meinhardt": "GiererMeinhardt",
    "Koch-Meinhardt, saturated": "KochMeinhardt",
    "Brusselator": "Brusselator",
    "Thomas": "Thomas",
    "Gray-Scott": "GrayScott",
    "Lengyel-Epstein": "LengyelEpstein",
    "BVAM, stripes": "BVAM",
    "BVAM 2012": "BVAM2012",
    "FitzHugh-Nagumo": "FitzHughNagumo",
}


def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 6,
    half_waves: p.HalfWaves = None, seed: p.Seed = 0,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements)
    half_waves = half_waves or human.half_waves(body)
    at_rest, at_once = human.tissue(two_layers=False), Stepping(first=1.0, largest=1.0)
    found = {}
    for title, name in list(KINETICS.items())[: 3 if quick else None]:
        pattern = Turing(kinetics_named(name), half_waves=half_waves)
        found[title] = Scene(body=body, processes=(pattern,), terms=(at_rest,), stepping=at_once, seed=seed)
    return found


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


if __name__ == "__main__":
    run_case(__file__)
