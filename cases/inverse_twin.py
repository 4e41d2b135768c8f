"""An inverse twin: a growth map that is hidden, and found again from outlines alone. About 1 min.

    turingfold run cases/inverse_twin.py      draws figures/inverse_twin.png

Half a disc with a thick cortex (T/R = 0.1), clamped, whose cortex grows by factors given at 16 places. Its
pial surface at six ages is all that the fit is told, without noise and with noise of 0.5 % and 2 % of the
cortical thickness on each point. Black: the hidden map; colours: the maps found, with bands of two standard
errors. Without noise the largest error is 2e-9, with noise 9e-3 and 4e-2, and all 16 places lie within the
band; both noises are one draw, scaled.
"""

import numpy as np

from turingfold import Elastic, GrowthMap, NeoHookean, Scene, SelfContact, Stepping, fit, run_case, semicircle
from turingfold import parameters as p

NOISES = (0.0, 0.005, 0.02)  # standard deviation over the cortical thickness
START = 1.1  # growth everywhere, from which the fits begin


@p.quick(elements=2)
def scenes(quick=False, *, radius: p.Radius = 0.04, thickness: p.Thickness = 0.004, elements: p.Elements = 3):
    places, ages = (6, 2) if quick else (16, 6)
    terms = (Elastic(gray=NeoHookean.from_young(1389.0, 0.4583)), SelfContact())
    grow = GrowthMap(cortex=tuple(hidden(places).tolist()))
    body = semicircle(radius=radius, thickness=thickness, elements=elements)
    stepping = Stepping(first=1 / ages, largest=1 / ages)
    return {"hidden": Scene(body=body, processes=(grow,), terms=terms, stepping=stepping)}


def hidden(places):
    """Return growth factors that rise and fall twice along the pial surface, (places,)."""
    s = np.linspace(0.0, 1.0, places)
    return 1.2 + 0.08 * np.cos(4 * np.pi * s - 1.0) + 0.04 * np.sin(2 * np.pi * s)


def computed(results):
    result = results["hidden"]
    scene, thickness = result.scene, result.scene.body.thickness
    (grow,) = scene.processes
    names = [f"GrowthMap.cortex.{k}" for k in range(len(grow.cortex))]
    first = Scene(
        body=scene.body, terms=scene.terms, stepping=scene.stepping,
        processes=(GrowthMap(cortex=(START,) * len(names)),),
    )  # fmt: skip
    outlines = {state.time: result.pial(k) for k, state in enumerate(result.states) if state.time > 0}
    values, deviations = [], []
    for noise in NOISES:
        random = np.random.default_rng(0)
        noisy = {
            age: points + noise * thickness * random.standard_normal(points.shape)
            for age, points in outlines.items()
        }
        found = fit(first, noisy, names, noise=noise * thickness or None)
        values.append(found.values)
        deviations.append(found.deviations)
    return {"hidden": np.array(grow.cortex), "values": np.array(values), "deviations": np.array(deviations)}


def draw(results, figure, computed):
    figure.set_size_inches(12, 3.4)
    truth = computed["hidden"]
    share = np.linspace(0.0, 1.0, len(truth))
    for axes, noise, values, deviations, color in zip(
        figure.subplots(1, len(NOISES), sharey=True), NOISES, computed["values"], computed["deviations"],
        ("#009e73", "#0072b2", "#d55e00"), strict=True,
    ):  # fmt: skip
        axes.fill_between(share, values - 2 * deviations, values + 2 * deviations, color=color, alpha=0.3)
        axes.plot(share, values, "o-", color=color, markersize=3, linewidth=1.0, label="found")
        axes.plot(share, truth, "k--", linewidth=1.0, label="hidden")
        off = np.abs(values - truth)
        within = f"{int((off <= 2 * deviations).sum())} of {len(truth)} within two deviations"
        title = f"noise {noise:.1%} of T: {within}" if noise else f"no noise: largest error {off.max():.0e}"
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("along the pial surface")
    axes.legend(fontsize=8)
    figure.axes[0].set_ylabel("growth factor")


if __name__ == "__main__":
    run_case(__file__)
