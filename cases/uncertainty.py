"""Uncertainty: what the scatter of the measured stiffness leaves of Figure 3. About 4 min.

    turingfold run cases/uncertainty.py -j 2    draws figures/uncertainty.png, writes table.md and .csv

The scene of Figure 3 on a coarse mesh, with a hundred pairs of Young's moduli: gray 1389 ± 289 Pa, white
1895 ± 592 Pa, as if they were independent and normal, cut at three standard deviations; a Latin hypercube.
Table and picture have percentiles of what comes of it. cases/what_matters.py has the first-order answer.
"""

import numpy as np

from turingfold import human, latin_hypercube, run_case, semicircle
from turingfold import parameters as p

MODULI = {"young_gray": (1389.0, 289.0), "young_white": (1895.0, 592.0)}
MEASURES = {
    "gyrification_index": ("gyrification index", 1.0), "folds": ("sulci", 1.0),
    "sulcal_depth": ("sulcal depth (mm)", 1e3), "registration": ("registration", 1.0),
}  # fmt: skip
PERCENTILES = 5, 25, 50, 75, 95


@p.quick(samples=3, thickness=5e-3, elements=3)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 2,
    base: p.Base = "clamped", poisson: p.Poisson = 0.4583, samples: p.Samples = 100, seed: p.Seed = 0,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    drawn = latin_hypercube(MODULI, samples, seed=seed)
    return {
        f"sample {k}": human.brain(
            body, poisson=poisson, **{name: float(values[k]) for name, values in drawn.items()}
        )
        for k in range(samples)
    }


def measured(results):
    """Return each measure of all results, (samples,)."""
    every = [result.summary() for result in results.values()]
    return {m: scale * np.array([s[m] for s in every]) for m, (_, scale) in MEASURES.items()}


def table(results):
    found = measured(results)
    return [
        {"measure": label}
        | {f"{q} %": float(np.percentile(found[m], q)) for q in PERCENTILES}
        | {"mean": float(found[m].mean()), "standard deviation": float(found[m].std())}
        for m, (label, _) in MEASURES.items()
    ]


def draw(results, figure):
    figure.set_size_inches(12, 6.5)
    axes = figure.subplot_mosaic([["outlines", "outlines", "index", "index"], [*MEASURES]])
    found = measured(results)
    tissues = [result.scene.terms[0] for result in results.values()]
    gray, white = (np.array([getattr(one, layer).young for one in tissues]) for layer in ("gray", "white"))
    ratio = white / gray
    order = np.argsort(ratio)
    shades = axes["index"].scatter(gray, white, c=found["gyrification_index"], s=30)
    axes["index"].set(xlabel="Young's modulus of gray matter (Pa)", ylabel="of white matter (Pa)")
    figure.colorbar(shades, ax=axes["index"], label="gyrification index")
    every = list(results.values())
    for k, color in ((order[0], "C0"), (order[len(order) // 2], "0.4"), (order[-1], "C1")):
        label = f"white over gray {ratio[k]:.2g}"
        axes["outlines"].plot(*(1e3 * every[k].pial()), color=color, linewidth=0.9, label=label)
    axes["outlines"].set_aspect("equal")
    axes["outlines"].set_axis_off()
    axes["outlines"].legend(frameon=False, loc="center")
    for measure, (label, _) in MEASURES.items():
        values = found[measure]
        bins = np.arange(values.min() - 0.5, values.max() + 1) if measure == "folds" else 16
        axes[measure].hist(values, bins=bins, color="0.75")
        low, middle, high = np.percentile(values, (5, 50, 95))
        for value, line in ((low, ":"), (middle, "-"), (high, ":")):
            axes[measure].axvline(value, color="C3", linestyle=line)
        axes[measure].set(xlabel=label, title=f"{middle:.3g} ({low:.3g} to {high:.3g})")
        axes[measure].spines[["top", "right"]].set_visible(False)
    axes[next(iter(MEASURES))].set_ylabel("samples; median, 5 and 95 %")


if __name__ == "__main__":
    run_case(__file__)
