"""Ferret, real sections: each stage starts from its own outline and is compared with the next. About 6 min.

    turingfold run cases/ferret_sections.py -j 2      draws figures/ferret_sections.png, and table.md

Outlines of both hemispheres at the four stages that Choi et al. 2025 published, read as in
ferret_outlines.py. From each of the first three the cortex, T = 0.1, grows to 1.9 times its length, none at
the bottom, by three laws: the rate law of the public code; the growth factor of the paper, g = 1.9; and that
also across the plane, as an area grows. Measured is the first state whose perimeter is as many times that of
its start as published, or the last one.

The table is that of the source's appendix 1 in the plane: similarity to the published next stage for p = 1, 2
and infinity, with four landmarks that need no clicks, the highest, lowest, left and right points; beside it
what chance gives. In all 18 rows the published length is reached, with up to 0.14 less gyrification index;
as growth of area at g = 1.13 to 1.45, by the other laws at 1.18 to 1.80. In no row is the grown section more
similar to the next stage at p = 1 than its ungrown start; but for left 1 to 2 a circle is more similar, too.
Left 3 to 4 passes random foldings, 0.89 to 0.90 for up to 0.89; right 3 to 4 does not.

Below the sections: published and grown stage 4 of the left side by 5, 15 and 25 elliptic Fourier descriptors.
"""

import os
from functools import partial
from pathlib import Path

import numpy as np

from turingfold import (
    RateGrowth,
    Scene,
    SelfContact,
    TangentialGrowth,
    ferret,
    figures,
    fold_count,
    fourier_descriptors,
    gyrification_index,
    outline,
    perimeter,
    reconstruction_error,
    run_case,
    similarity_null,
)
from turingfold import parameters as p

BESIDE = Path(__file__).parents[2] / "shared" / "reference" / "ferret"
FOLDER = Path(os.environ.get("FERRET_OUTLINES", BESIDE))
published = partial(ferret.published_outline, FOLDER)
SIDES, STAGES, ORDERS = ("left", "right"), (1, 2, 3), (5, 15, 25)
LAWS = {"rate": "rate law", "paper": "g = 1.9", "area": "g = 1.9, also across"}
OURS, THEIRS = "#0072b2", "#d55e00"


@p.quick(elements=2, cortex=1.1)
def scenes(
    quick=False, *,
    thickness: p.RelativeThickness = 0.1, elements: p.Elements = 3, bulk: p.BulkRatio = 5.0,
    rate: p.Rate = 1.9, thinning: p.Thinning = 0.5, cortex: p.Cortex = 1.9, smooth: p.SmoothRadii = 0.02,
):  # fmt: skip
    factor = {"cortex": cortex, "zones": (ferret.BOTTOM,)}
    laws = {
        "rate": RateGrowth(rate=rate, thinning=thinning, zones=(ferret.BOTTOM,)),
        "paper": TangentialGrowth(**factor),
        "area": TangentialGrowth(out_of_plane="tangential", **factor),
    }
    terms, found = (ferret.tissue(bulk=bulk), SelfContact()), {}
    for side in SIDES:
        for stage in STAGES:
            body = outline(
                published(side, stage), thickness=thickness, elements=elements, smooth=smooth,
                layers="sigmoid",
            )  # fmt: skip
            for law, grow in laws.items():
                until = np.log(cortex) / rate if law == "rate" else 1.0
                found[name_of(side, stage, law)] = Scene(
                    body=body, processes=(grow,), terms=terms, until=float(until)
                )
    return found


def name_of(side, stage, law):
    return f"{side} {stage} to {stage + 1}, {LAWS[law]}"


def grown(result, side, stage):
    """Return the first state whose perimeter has grown as published, or the last, and whether it has."""
    aim = perimeter(published(side, stage + 1)) / perimeter(published(side, stage))
    start = perimeter(result.pial(0))
    ratios = np.array([perimeter(result.pial(k)) / start for k in range(len(result.states))])
    reached = np.flatnonzero(ratios >= aim)
    return (int(reached[0]), True) if len(reached) else (len(ratios) - 1, False)


def landmarks(a, b):
    """Return the highest, lowest, leftmost and rightmost points of two curves, (4, 2) numbers of points."""
    return np.array([[end(c[axis]) for c in (a, b)] for axis in (0, 1) for end in (np.argmin, np.argmax)])


def table(results):
    rows = []
    for side in SIDES:
        for stage in STAGES:
            theirs, before = published(side, stage + 1), published(side, stage)
            for law, words in LAWS.items():
                result = results[name_of(side, stage, law)]
                step, reached = grown(result, side, stage)
                ours = result.pial(step)
                row = {
                    "side": side, "stages": f"{stage} to {stage + 1}", "law": words,
                    "g": float(result.states[step]["growth"][0].max()), "length as published": reached,
                    "index": gyrification_index(ours, closed=True),
                    "published": gyrification_index(theirs, closed=True),
                    "folds": fold_count(ours, closed=True),
                    "folds published": fold_count(theirs, closed=True),
                }  # fmt: skip
                for order in (1, 2, np.inf):
                    null = similarity_null(
                        theirs, ours, order, starts=(None, before), landmarks=landmarks(theirs, ours)
                    )
                    low, high = (null.foldings.quantile(share) for share in (0.05, 0.95))
                    row |= {
                        f"s, p = {order:g}": null.value, f"circle, p = {order:g}": null.circle,
                        f"start, p = {order:g}": null.start,
                        f"random, p = {order:g}": f"{low:.2f} to {high:.2f}",
                    }  # fmt: skip
                rows.append(row)
    return rows


def draw(results, figure):
    figure.set_size_inches(12, 13)
    rows = figure.subplots(3, 3)
    for axes, side in zip(rows, SIDES, strict=False):
        for one, stage in zip(axes, STAGES, strict=True):
            result = results[name_of(side, stage, "rate")]
            step, reached = grown(result, side, stage)
            outlines(one, result.pial(step), published(side, stage + 1), published(side, stage))
            length = "at the published length" if reached else "at the end"
            one.set_title(f"{side}, stage {stage} to {stage + 1}, {length}", fontsize=9)
    rows[0, 0].legend(frameon=False, fontsize=8)
    result = results[name_of("left", 3, "rate")]
    ours, theirs = result.pial(grown(result, "left", 3)[0]), published("left", 4)
    at = np.linspace(0.0, 1.0, 600)
    for one, order in zip(rows[2], ORDERS, strict=True):
        both = [fourier_descriptors(points, order, closed=True).at(at) for points in (ours, theirs)]
        outlines(one, *both)
        errors = [reconstruction_error(points, order, closed=True) for points in (ours, theirs)]
        one.set_title(f"order {order}: errors {errors[0]:.3f}, {errors[1]:.3f} R", fontsize=9)


def outlines(axes, ours, theirs, start=None):
    """Draw curves (2, n) on each other."""
    for points, color, label in ((theirs, THEIRS, "published"), (ours, OURS, "grown")):
        axes.plot(*np.hstack([points, points[:, :1]]), color=color, linewidth=1.3, label=label)
    if start is not None:
        axes.plot(
            *np.hstack([start, start[:, :1]]), color=figures.INK, linewidth=0.8, linestyle=":", label="start"
        )
    axes.set_aspect("equal")
    axes.set_axis_off()


if __name__ == "__main__":
    run_case(__file__)
