"""A section of a brain from a file: a drawing, points, a mask, labels, or surfaces. About 1 min.

    turingfold run section                                       the smooth outline that comes with the case
    turingfold run section --set outline=my.svg --set unit=mm    a drawing, or its curves named: white=white
    turingfold run section --set outline=slice.png --set width=0.14                             a mask
    turingfold run section --set outline=aseg.nii.gz --set gray=3,42 --set white=2,41           labels
    turingfold run section --set outline=lh.pial --set white=lh.white --set at=0.02             surfaces
    turingfold run cases/section.py      draws figures/section.png

The cortex is 2.5 mm thick, or as thick as the white surface says, and grows along both of its directions, in
the plane and across it, to 1.7 times its length; the pial surface touches itself and does not cross. Moduli
are those of document 1. Of images the steps of the voxels are smoothed away, over 1.5 voxels; smooth=0 keeps
them. With skull=0.002 a skull lies 2 mm around the convex hull. Below, the cortex's
thickness along its surface, undeformed and deformed.

Without a file: a hemisphere's outline, r = R (1 + 0.15 cos 2φ - 0.2 e^{-(φ/0.4)²} + 0.03 sin 3φ), R = 25 mm,
with the shallow pit of the insula at its side.
"""

import numpy as np

from turingfold import (
    Scene,
    SelfContact,
    TangentialGrowth,
    figures,
    human,
    read_section,
    run_case,
    skull_around,
    thickness_profile,
)
from turingfold import outline as body_of
from turingfold import parameters as p

RADIUS, POINTS = 0.025, 400


def hemisphere():
    """Return a smooth outline, (2, n) in m."""
    angle = 2 * np.pi * np.arange(POINTS) / POINTS
    pit = np.exp(-((((angle + np.pi) % (2 * np.pi) - np.pi) / 0.4) ** 2))
    radius = RADIUS * (1 + 0.15 * np.cos(2 * angle) - 0.2 * pit + 0.03 * np.sin(3 * angle))
    return radius * np.stack([np.cos(angle), np.sin(angle)])


@p.quick(elements=2, cortex=1.2)
def scenes(
    quick=False, *,
    outline: p.File = "", white: p.WhiteSurface = "", holes: p.Holes = "", gray: p.GrayLabels = "",
    unit: p.Unit = "", plane: p.Plane = "coronal", at: p.At = None, width: p.SectionWidth = None,
    smooth: p.Smooth = None, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 4,
    layers: p.Layers = "sharp",
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 1.7, core: p.Core = 1.0, out_of_plane: p.OutOfPlane = "tangential",
    skull: p.SkullGap = None,
):  # fmt: skip
    given = hemisphere()
    if outline:
        given = read_section(
            outline, white=white, holes=holes, gray=gray, unit=unit, plane=plane, at=at, width=width
        )
    body = body_of(
        given, thickness=None if outline and white else thickness, size=thickness / elements,
        smooth=smooth, layers=layers,
    )  # fmt: skip
    solid = human.tissue(young_gray=young_gray, young_white=young_white, poisson=poisson)
    grow = TangentialGrowth(cortex=cortex, core=core, out_of_plane=out_of_plane)
    contact = SelfContact(skull=None if skull is None else skull_around(body, gap=skull))
    return {"section": Scene(body=body, processes=(grow,), terms=(solid, contact))}


def computed(results):
    profile = thickness_profile(results["section"].scene.body, results["section"].last)
    return {"arc": profile.arc, "start": profile.start, "grown": profile.grown, "words": [str(profile)]}


def draw(results, figure, computed):
    result = results["section"]
    figure.set_size_inches(11, 7.5)
    grid = figure.add_gridspec(2, 2, height_ratios=(3, 1))
    before, after = (figure.add_subplot(grid[0, k]) for k in (0, 1))
    along = figure.add_subplot(grid[1, :])
    for name, color in (("start", figures.INK), ("grown", "#b0413e")):
        along.plot(1e3 * computed["arc"], 1e3 * computed[name], color=color, linewidth=1, label=name)
    along.set_xlabel("along the undeformed pial surface (mm)")
    along.set_ylabel("cortex (mm)")
    along.set_title(computed["words"][0])
    along.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    body = result.scene.body
    figures.tissue(before, body)
    before.set_title(f"{body.mesh.nelements} triangles, {len(body.pial_paths)} closed pial curve(s)")
    figures.section(after, result)
    figures.outline(after, body)
    after.set_title(figures.measures(result))


if __name__ == "__main__":
    run_case(__file__)
