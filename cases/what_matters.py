"""What matters: how far Figure 3's folds depend on stiffness, growth and tension. About 30 s.

    turingfold run cases/what_matters.py      draws figures/what_matters.png

The scene of Figure 3. Bars: by how many per cent a measure of its end changes with one per cent of a
parameter (growth: of the factor), from the tangent of the equilibrium, without another run. Titles: the
standard deviation of each measure that document 1's Young's moduli leave, gray 1389 ± 289 Pa and white
1895 ± 592 Pa, to first order, as if they were independent and Poisson's ratio known. The hundred runs of
cases/uncertainty.py spread as much in sulcal depth (1.0 mm), and by a third more in the index (0.08): it
falls faster where white matter is stiff than it rises where that is soft.
"""

import numpy as np

from turingfold import figures, human, run_case, semicircle, sensitivity
from turingfold import parameters as p

MODULI = {"Young's modulus, gray": ("gray", 289 / 1389), "Young's modulus, white": ("white", 592 / 1895)}
OTHERS = {
    "growth of the cortex": "TangentialGrowth.cortex", "growth of the core": "TangentialGrowth.core",
    "tension of axons": "AxonalTension.strength",
}  # fmt: skip
MEASURES = {"gyrification_index": (1.0, ""), "perimeter": (1e3, " mm"), "sulcal_depth": (1e3, " mm")}
STORED = "per_cent", "numbers", "deviations"


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 6,
    poisson: p.Poisson = 0.4583, cortex: p.Cortex = 2.3, half_waves: p.HalfWaves = None,
    strength: p.Strength = 0.75,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements)
    scene = human.brain(body, poisson=poisson, cortex=cortex, half_waves=half_waves, strength=strength)
    return {"end": scene}


def computed(results):
    # E at a given Poisson's ratio scales both moduli: one per cent of E is one per cent of μ and of κ
    both = [f"Elastic.{layer}.{modulus}" for layer, _ in MODULI.values() for modulus in ("mu", "kappa")]
    found = sensitivity(results["end"], to=(*both, *OTHERS.values()), of=tuple(MEASURES))
    relative = found.relative
    moduli = relative[:, :4].reshape(len(MEASURES), 2, 2).sum(2)
    shares = np.array([share for _, share in MODULI.values()])
    deviations = found.numbers * np.sqrt(((moduli * shares) ** 2).sum(1))
    return dict(zip(STORED, (np.hstack([moduli, relative[:, 4:]]), found.numbers, deviations), strict=True))


def draw(results, figure, computed):
    figure.set_size_inches(12, 2.6)
    names = (*MODULI, *OTHERS)
    for axes, values, number, deviation, (measure, (scale, unit)) in zip(
        figure.subplots(1, len(MEASURES)), *(computed[name] for name in STORED), MEASURES.items(), strict=True
    ):
        figures.tornado(axes, names, values)
        known = f"{scale * number:.2f} ± {scale * deviation:.2f}{unit}"
        axes.set_title(f"{measure.replace('_', ' ')}: {known}", fontsize=10)


if __name__ == "__main__":
    run_case(__file__)
