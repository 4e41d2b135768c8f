"""Ferret, real outlines: coronal sections of a P0 brain fold until they are as long as the published. 20 s.

    turingfold run cases/ferret_outlines.py      draws figures/ferret_outlines.png

Sections of both hemispheres (Choi et al. 2025, stage 1), read from the folder that the environment variable
FERRET_OUTLINES names, else from ../shared/reference/ferret beside the repository. Smoothed over 0.04, cortex
T = 0.1 (rounded inside where the outline is tighter), growth at the rate 1.9 with thinning, none at the
bottom (y < -0.4). Each side grows until its perimeter has increased as much as that of the published stage 4,
whose outlines cross themselves 6 and 2 times: ours never do.

Length and index come out (1.33 and 1.18 for 1.40 and 1.23), the places of the folds do not: similarity to
stage 4 (p = 1, left and right) is 0.87 and 0.86, less than that of the ungrown start (0.89 and 0.89) and of
the most similar circle (0.91 and 0.89). `turingfold compare` prints these beside every similarity.
"""

import os
from functools import partial
from pathlib import Path

from turingfold import RateGrowth, Scene, SelfContact, ferret, figures, outline, perimeter, run_case
from turingfold import parameters as p

BESIDE = Path(__file__).parents[2] / "shared" / "reference" / "ferret"
FOLDER = Path(os.environ.get("FERRET_OUTLINES", BESIDE))
published = partial(ferret.published_outline, FOLDER)
PUBLISHED = {"left": 1.401, "right": 1.233}  # gyrification index of stage 4


@p.quick(elements=2, until_left=0.1, until_right=0.1)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 4, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5,
    # where the perimeters have grown by 1.551 and 1.354
    until_left: p.Until = 0.447, until_right: p.Until = 0.362,
):  # fmt: skip
    found = {}
    for side, until in {"left": until_left, "right": until_right}.items():
        options = {"thickness": thickness, "elements": elements, "layers": "sigmoid"}
        body = outline(published(side, 1), smooth=0.04, **options)
        grow = RateGrowth(rate=rate, thinning=thinning, zones=(ferret.BOTTOM,))
        terms = (ferret.tissue(bulk=bulk), SelfContact())
        found[side] = Scene(body=body, processes=(grow,), terms=terms, until=until)
    return found


def draw(results, figure):
    shown, notes = {}, {}
    for side, result in results.items():
        start, end = result.scene.body.pial_curve.length, perimeter(result.pial())
        shown[f"{side}, P0"] = result, 0
        shown[f"{side}, grown"] = result, -1
        ratio, gi = end / start, PUBLISHED[side]
        notes[f"{side}, grown"] = f"perimeter {ratio:.3f} times P0's; stage 4: GI {gi:.3f} (dotted)"
    drawn = figures.grid(figure, shown, columns=4, notes=notes, width=2.6)
    for axes, side in zip(drawn[1::2], results, strict=True):
        x, y = published(side, 4)
        axes.fill(x, y, fill=False, linestyle=":", edgecolor=figures.INK, linewidth=0.8)


if __name__ == "__main__":
    run_case(__file__)
