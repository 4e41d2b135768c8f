"""Phase diagrams: which cortices fold, by thickness and growth, and by modulus ratio and growth. About 6 min.

    turingfold run cases/phase_diagram.py -j 2      draws figures/phase_diagram.png, writes table.md and .csv

Half a disc on rollers whose cortex alone grows, without pattern and tension: it is smooth until it buckles.
A run for each column passes through all growths; the colour is the number of sulci that are at least a fifth
of the cortex deep. The line is the growth at which the smooth solution loses its stability, by the tangent
(`buckling`); the dashed one that of a thin stiff film on a deep core, 1 + (3 E_core/E_cortex)^(2/3)/4, at
equal Poisson's ratios, which is no guide where the cortex is about as soft as the core.
"""

from typing import Annotated

import numpy as np

from turingfold import (
    Elastic,
    NeoHookean,
    NotConvergedError,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    buckling,
    find_folds,
    run_case,
    semicircle,
)
from turingfold import parameters as p

Columns = Annotated[int, p.Parameter("", 2, 100, "runs for each diagram")]
Rows = Annotated[int, p.Parameter("", 1, 100, "growths at which each run is shown")]
RATIOS = 0.5, 8.0  # Young's modulus of gray over white matter
DIAGRAMS = "thickness", "ratio"


@p.quick(columns=2, rows=4, elements=2, thinnest=4e-3, thickness=4e-3)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 3,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 2.4, thinnest: p.Thickness = 1.5e-3, thickest: p.Thickness = 5e-3,
    columns: Columns = 8, rows: Rows = 14,
):  # fmt: skip
    def made(body, gray):
        moduli = (NeoHookean.from_young(young, poisson) for young in (gray, young_white))
        solid = Elastic(**dict(zip(("gray", "white"), moduli, strict=True)))
        return Scene(
            body=body, terms=(solid, SelfContact()), processes=(TangentialGrowth(cortex=cortex),),
            stepping=Stepping(stops=tuple(np.linspace(0, 1, rows + 1)[1:])),
        )  # fmt: skip

    found = {}
    for own in np.linspace(thinnest, thickest, columns):
        body = semicircle(radius=radius, thickness=float(own), elements=elements, base="roller")
        found[f"thickness {1e3 * own:.3g} mm"] = made(body, young_gray)
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base="roller")
    for own in np.geomspace(*RATIOS, columns):
        found[f"ratio {own:.3g}"] = made(body, float(own) * young_white)
    return found


def place(result, diagram):
    """Return where a run stands in its diagram: thickness, mm, or modulus ratio."""
    solid, body = result.scene.terms[0], result.scene.body
    return 1e3 * body.thickness if diagram == "thickness" else solid.gray.young / solid.white.young


def growths(result):
    """Return the growth of the cortex at rest and at each stop."""
    return 1 + (result.scene.processes[0].cortex - 1) * np.array([0, *result.scene.stepping.stops])


def computed(results):
    critical, folds = [], []
    for result in results.values():
        try:
            critical.append(buckling(result.scene).growth)
        except NotConvergedError:
            critical.append(np.nan)
        states = [result.at(time=stop, exact=True) for stop in (0, *result.scene.stepping.stops)]
        thickness = result.scene.body.thickness
        folds.append([find_folds(result.pial(state), thickness=thickness).count for state in states])
    return {"critical": critical, "folds": folds}


def draw(results, figure, computed):
    from matplotlib.colors import BoundaryNorm

    figure.set_size_inches(12, 4.6)
    every = list(results.values())
    most = int(computed["folds"].max())
    norm = BoundaryNorm(np.arange(most + 2) - 0.5, 256)
    for axes, diagram in zip(figure.subplots(1, 2), DIAGRAMS, strict=True):
        own = [k for k, name in enumerate(results) if name.startswith(diagram)]
        x = np.array([place(every[k], diagram) for k in own])
        y = growths(every[own[0]])
        shades = axes.pcolormesh(x, y, computed["folds"][own].T, shading="nearest", norm=norm)
        axes.plot(x, computed["critical"][own], "o-", color="C1", label="the smooth cortex buckles")
        axes.set(xlabel="thickness of the cortex (mm)", ylabel="growth of the cortex")
        if diagram == "ratio":
            axes.set(xscale="log", xlabel="Young's modulus, gray over white matter", ylabel="")
            axes.set_xticks(ticks := [0.5, 1, 2, 4, 8], [f"{tick:g}" for tick in ticks])
            axes.minorticks_off()
            film = x >= 2
            axes.plot(x[film], 1 + (3 / x[film]) ** (2 / 3) / 4, "w--", label="thin stiff film, in theory")
        axes.set_ylim(1.0, y[-1])
        axes.legend(loc="lower left", fontsize=8, facecolor="0.3", labelcolor="white", framealpha=1)
    figure.colorbar(shades, ax=figure.axes[:2], label="sulci", ticks=range(0, most + 1, 1 + most // 12))


def table(results):
    return [
        {"run": name, "growth of the cortex": float(growths(result)[-1])}
        | {key: result.summary()[key] for key in ("folds", "gyrification_index", "status")}
        for name, result in results.items()
    ]


if __name__ == "__main__":
    run_case(__file__)
