"""Human, a real section: its outline without sulci folds again, normal, with polymicrogyria, thick. 5 min.

    turingfold run cases/human_section.py      draws figures/human_section.png; results/human_section/table.md

The section is the user's own: closed curves of points in mm, BRAIN_SECTION_pial_1.csv and on, largest first,
and BRAIN_SECTION_white_1.csv and on, in the folder that the environment variable BRAIN_SECTIONS names, else
in ../shared/reference/sections beside the repository; BRAIN_SECTION is the variable for their name, without
it s1_coronal_+50_lh, of an adult. To start from any other file, see section.py.

The start is the section with its sulci filled by a disc, smoothed, and made smaller, with a cortex as thick
as the median of the section's own. It grows to 1.8 times its length, along both directions of the cortex.
PMG: a quarter of the thickness in a zone of 20 mm around the highest point. Thick: twice the thickness.

The largest piece of s1_coronal_+50_lh has 16 sulci of 6.4 mm and a gyrification index of 1.77. Grown are 13
of 7.6 mm and 1.51; with PMG 20, the more by small ones in the zone; with a thick cortex 6 of 14 mm. Their
places are not those of the adult: the similarity, 0.83, is that of random foldings of the same wave lengths,
and less than that of a circle, 0.85; neither growth nor start knows where the adult's sulci are. The adult's
cortex is 1.67 times as thick on gyri as in sulci; grown, 1.98 times (PMG 1.95, thick 1.78).
"""

import os
from pathlib import Path

import numpy as np

from turingfold import (
    Ellipse,
    RefinementDisc,
    Scene,
    Section,
    SelfContact,
    TangentialGrowth,
    Zone,
    figures,
    find_folds,
    gyrification_index,
    human,
    morphological_closing,
    outline,
    perimeter,
    read_outline,
    run_case,
    similarity_null,
    thickness_profile,
)
from turingfold import parameters as p

BESIDE = Path(__file__).parents[2] / "shared" / "reference" / "sections"
FOLDER = Path(os.environ.get("BRAIN_SECTIONS", BESIDE))
NAME = os.environ.get("BRAIN_SECTION", "s1_coronal_+50_lh")
ZONE = 0.02  # m


def adult():
    """Return the section that the outline comes from."""
    files = {surface: sorted(FOLDER.glob(f"{NAME}_{surface}_*.csv")) for surface in ("pial", "white")}
    curves = {
        surface: [read_outline(file, unit="mm").single() for file in each] for surface, each in files.items()
    }
    if not curves["pial"] or not curves["white"]:
        where = FOLDER if "BRAIN_SECTIONS" in os.environ else "a folder that BRAIN_SECTIONS names"
        raise FileNotFoundError(
            f"there are no curves {NAME}_pial_1.csv and {NAME}_white_1.csv in {where}; set BRAIN_SECTIONS "
            "to the folder and BRAIN_SECTION to the name of yours: points x,y in mm, one closed curve a file"
        )
    return Section(curves["pial"], curves["white"], source=NAME)


@p.quick(elements=2, cortex=1.15)
def scenes(
    quick=False, *,
    closing: p.Closing = 0.01, smooth: p.Smooth = 4e-3, scale: p.Scale = 0.85, elements: p.Elements = 3,
    thickness: p.OwnThickness = None,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 1.8, core: p.Core = 1.0, out_of_plane: p.OutOfPlane = "tangential",
):  # fmt: skip
    section = adult()
    points = scale * morphological_closing(section.pial[0], closing)
    points -= points.mean(1, keepdims=True)
    T = thickness or scale * float(np.nanmedian(section.thickness()[0]))
    apex = tuple(points[:, np.argmax(points[1])].tolist())
    solid = human.tissue(young_gray=young_gray, young_white=young_white, poisson=poisson)

    def scene(times=1.0, zones=(), fine=()):
        body = outline(
            points, thickness=times * T, elements=times * elements, smooth=smooth, layers="sigmoid", fine=fine
        )
        grow = TangentialGrowth(cortex=cortex, core=core, out_of_plane=out_of_plane, zones=zones)
        return Scene(body=body, processes=(grow,), terms=(solid, SelfContact()))

    thin = Zone(region=Ellipse(centre=apex, semi_axes=(ZONE, ZONE), edge=ZONE / 4), thickness=0.25)
    disc = RefinementDisc(centre=apex, radius=ZONE, share=0.5 if quick else 0.34)
    local = scene(zones=(thin,), fine=disc)
    return {"normal": scene(), "PMG: T/4 in a zone": local, "thick: 2 T": scene(2.0)}


def table(results):
    section = adult()
    real, T = section.pial[0], float(np.nanmedian(section.thickness()[0]))
    rows = [measured("adult", real, T, section.thickness()[0])]
    for name, result in results.items():
        grown, body = result.pial(), result.scene.body
        start = body.nodes[:, body.pial]
        null = similarity_null(real, grown, starts=(None, start), thickness=T)
        low, high = null.foldings.quantile(0.05), null.foldings.quantile(0.95)
        rows.append(measured(name, grown, body.thickness, thickness_profile(body, result.last).grown) | {
            "similarity to the adult": null.value, "of the best circle": null.circle,
            "of the start": null.start, "of random foldings": f"{low:.2f} to {high:.2f}",
        })  # fmt: skip
    return [dict.fromkeys(rows[-1]) | row for row in rows]


def measured(name, points, T, along):
    """Return the measures of a pial surface; T the cortex's nominal thickness, `along` that at points; m."""
    folds = find_folds(points, thickness=T, closed=True)
    return {
        "section": name,
        "gyrification index": gyrification_index(points, closed=True),
        "index by closing": gyrification_index(points, closing=3 * T, closed=True),
        "sulci": folds.count,
        "depth (mm)": 1e3 * folds.depth,
        "perimeter (mm)": 1e3 * perimeter(points),
        "cortex (mm)": 1e3 * float(np.nanmedian(along)),
        "cortex, gyri over sulci": float(np.nanmean(along[folds.gyri]) / np.nanmean(along[folds.sulci])),
    }


def computed(results):
    rows = {row["section"]: row for row in table(results)}
    told = [
        f"{row['sulci']} sulci, GI {row['gyrification index']:.2f}, depth {row['depth (mm)']:.1f} mm"
        for row in rows.values()
    ]
    return {"numbers": told}


def draw(results, figure, computed):
    figure.set_size_inches(15, 6)
    first, *others = figure.subplots(1, 1 + len(results), sharex=True, sharey=True)
    numbers = computed["numbers"]
    section = adult()
    centre = section.pial[0].mean(1, keepdims=True)
    for curves, color in ((section.pial, "#b9887f"), (section.white, "#f3e9dc")):
        for curve in curves:
            first.fill(*(1e3 * (curve - centre)), facecolor=color, edgecolor=figures.INK, linewidth=0.5)
    first.set_title(f"adult\n{numbers[0]}", fontsize=9)
    first.set_aspect("equal")
    first.set_axis_off()
    for axes, told, (name, result) in zip(others, numbers[1:], results.items(), strict=True):
        figures.section(axes, result, bar=False)
        axes.set_title(f"{name}\n{told}", fontsize=9)


if __name__ == "__main__":
    run_case(__file__)
