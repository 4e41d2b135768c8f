"""Ferret, which growth made this brain: a growth map from stages 1 to 3, stage 4 foretold. About 1 min.

    turingfold run cases/inverse_ferret.py      draws figures/inverse_ferret.png

Outlines of both hemispheres that Choi et al. 2025 published, read as in ferret_outlines.py. The body is stage
1; its cortex, T = 0.1, grows by factors at PLACES places round the surface, its core by one. The time of a
stage is its share of the growth in perimeter from stage 1 to 4. Growth is fitted to stages 2 and 3 and goes
on at the same rate to stage 4, which the fit has not seen; beside it, uniform growth of the cortex to the
same perimeter. Stages that cross themselves are repaired as bodies are (`outline`). Compared are mean
distances from stage 4, each curve laid on it first, and similarities with what chance gives.

The map foretells stage 4 to 0.064 (left) and 0.049 R (right) on average, uniform growth to 0.060 and 0.039:
no better, and as with the weight at the corner of the L-curve (0.064, 0.049). A fit to distances from a curve
through the target's points, done before, gave 0.056 and 0.033: chance. Stages 2 and 3 themselves are missed
by 0.05 to 0.2 T, and the cores come out as shrinking, to 0.65 and 0.69: the published sections are slices of
a body in space, and their tissue leaves the plane.
"""

import os
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from turingfold import (
    GrowthMap,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    ferret,
    figures,
    fit,
    outline,
    outline_distance,
    perimeter,
    run_case,
    similarity_null,
    simulate,
)
from turingfold import parameters as p

BESIDE = Path(__file__).parents[2] / "shared" / "reference" / "ferret"
FOLDER = Path(os.environ.get("FERRET_OUTLINES", BESIDE))
published = partial(ferret.published_outline, FOLDER)
SIDES, PLACES = ("left", "right"), 16
SMOOTH = 0.02  # weight of the second differences of the map


def body_of(side, stage, thickness, elements):
    return outline(
        published(side, stage), thickness=thickness, elements=elements, smooth=0.02, layers="sigmoid"
    )


@p.quick(elements=2, uniform=1.3)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 3, bulk: p.BulkRatio = 5.0,
    uniform: p.Cortex = 2.2,
):  # fmt: skip
    grow = (GrowthMap(cortex=(uniform,) * PLACES), TangentialGrowth(cortex=1.0, core=1.01))
    terms, steps = (ferret.tissue(bulk=bulk), SelfContact()), Stepping(first=0.025, largest=0.025)
    return {
        side: Scene(body=body_of(side, 1, thickness, elements), processes=grow, terms=terms, stepping=steps)
        for side in SIDES[: 1 if quick else 2]
    }


def stage(scene, side, number):
    """Return a stage's outline as a body of this cortex has it, and its share of the growth in perimeter."""
    lengths = [perimeter(published(side, k)) for k in (1, number, 4)]
    body = scene.body
    made = body_of(side, number, body.thickness, body.elements_through_cortex)
    points = made.nodes[:, made.pial_paths[0].nodes]
    return points, (lengths[1] - lengths[0]) / (lengths[2] - lengths[0])


def fitted(scene, side):
    """Return the fit to stages 2 and 3, begun with a little uniform growth."""
    targets = {time: points for points, time in (stage(scene, side, k) for k in (2, 3))}
    uniform = GrowthMap(cortex=(1.2,) * PLACES), TangentialGrowth(cortex=1.0, core=1.01)
    start = replace(scene, processes=uniform)
    names = [*(f"GrowthMap.cortex.{k}" for k in range(PLACES)), "TangentialGrowth.core"]
    return fit(start, targets, names, bounds=(0.5, 4.0), smoothness=SMOOTH, tolerance=1e-4)


def computed(results):
    found = {}
    for side, result in results.items():
        last, _ = stage(result.scene, side, 4)
        lengths = np.array([perimeter(result.pial(k)) for k in range(len(result.states))])
        longer = perimeter(published(side, 4)) / perimeter(published(side, 1))
        even = result.pial(int(np.argmin(np.abs(lengths / lengths[0] - longer))))
        made = fitted(result.scene, side)
        told = simulate(made.scene).pial()
        start = result.pial(0)
        likeness = [similarity_null(last, points, starts=(None, start)) for points in (told, even)]
        found |= {
            f"{side} growth": made.values, f"{side} errors": made.deviations,
            f"{side} foretold": told, f"{side} even": even,
            f"{side} misfits": np.array(list(made.misfits.values())),
            f"{side} distances": np.array([
                outline_distance(curve, last, closed=True) for curve in (told, even, start)
            ]),
            f"{side} similarity": np.array([[one.value, one.foldings.p] for one in likeness]),
        }  # fmt: skip
    return found


def draw(results, figure, computed):
    figure.set_size_inches(13, 7)
    rows = figure.subplots(len(results), 3, width_ratios=(1, 1, 1.4), squeeze=False)
    for (one, other, growth), side in zip(rows, results, strict=True):
        x, y = np.stack([*published(side, 4)])
        far = computed[f"{side} distances"]
        for axes, key, words, distance in ((one, "foretold", "growth map of stages 1 to 3", far[0]),
                                           (other, "even", "uniform growth", far[1])):  # fmt: skip
            axes.fill(x, y, fill=False, linestyle=":", edgecolor=figures.INK, linewidth=0.8)
            axes.fill(*computed[f"{side} {key}"], fill=False, edgecolor="#0072b2", linewidth=1.0)
            axes.set_aspect("equal")
            axes.axis("off")
            text = f"{side}, {words}\nmean distance from stage 4 (dotted): {distance:.3f} R"
            axes.set_title(text, fontsize=9)
        values, errors = computed[f"{side} growth"], computed[f"{side} errors"]
        errors = np.where(np.isfinite(errors), errors, 0.0)
        s = np.arange(PLACES) / PLACES
        growth.errorbar(s, values[:-1], 2 * errors[:-1], fmt="o-", markersize=3, linewidth=1.0, capsize=2)
        growth.axhline(values[-1], color="0.5", linestyle="--", linewidth=1.0)
        growth.set_xlabel("along the surface of stage 1")
        growth.set_ylabel("growth factor at stage 4")
        growth.set_title(f"{side}: cortex (bars: two standard errors), core (dashed)", fontsize=9)


if __name__ == "__main__":
    run_case(__file__)
