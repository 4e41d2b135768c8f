"""The three hypotheses on and off, and growth: nine combinations on the semi-circle, three seeds. 2 min.

    turingfold run cases/hypotheses.py      draws figures/hypotheses.png; results/hypotheses/table.md and .csv

Growth of Figure 3 in eight of them, that differ by what they say.  DGH: white matter has another modulus than
gray; off, all tissue is gray matter.  ATH: axons pull along the gray-white interface; off, nothing pulls.
IPH: a Turing pattern says where they pull and how strongly; off, they pull equally at twelve evenly spaced
places. The pattern acts through the tension alone: without ATH it is there and moves nothing. The ninth has
all three, and no growth.

The cortex's growth has seeded noise of 1 %. The picture shows seed 0; the table has means over the seeds ±
the largest deviation, the registration with the pattern where there is one (without sulci that of the dents
which tension makes alone), and the largest share of its phases that register as well or better, p.
"""

from dataclasses import replace
from itertools import product

import numpy as np

from turingfold import Imperfection, figures, human, run_case, semicircle
from turingfold import parameters as p

NO_GROWTH = {"cortex": 1.0, "core": 1.0, "radial_core": 1.0, "swelling": 0.0}
HYPOTHESES = "DGH", "ATH", "IPH"
STILL = "DGH + ATH + IPH, no growth"


@p.quick(elements=2, thickness=5e-3, cortex=1.9)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 3,
    base: p.Base = "clamped", young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0,
    poisson: p.Poisson = 0.4583, cortex: p.Cortex = 2.3, core: p.Core = 1.05, radial_core: p.RadialCore = 1.1,
    swelling: p.Swelling = 0.2, kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None,
    strength: p.Strength = 0.75, amplitude: p.Amplitude = 0.01,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    grown = {"cortex": cortex, "core": core, "radial_core": radial_core, "swelling": swelling}

    def scene(seed, growth, layers=True, tension=True, pattern=True):
        made = human.brain(
            body, young_gray=young_gray, young_white=young_white, poisson=poisson, two_layers=layers,
            tension=tension, pattern=pattern, kinetics=kinetics, half_waves=half_waves, strength=strength,
            seed=seed, **growth,
        )  # fmt: skip
        return replace(made, processes=(*made.processes, Imperfection(amplitude=amplitude)))

    found = {}
    for seed in (0,) if quick else (0, 1, 2):
        for on in product((True, False), repeat=3):
            found[f"{name_of(on)}, seed {seed}"] = scene(seed, grown, *on)
        found[f"{STILL}, seed {seed}"] = scene(seed, NO_GROWTH)
    return found


def name_of(on):
    return " + ".join(name for name, there in zip(HYPOTHESES, on, strict=True) if there) or "none"


def by_name(results):
    """Return the summaries of all seeds by the name without the seed."""
    found = {}
    for name, result in results.items():
        found.setdefault(name.rpartition(", seed")[0], []).append(result.summary())
    return found


def table(results):
    rows = []
    for name, summaries in by_name(results).items():
        registered = summaries[0]["registration"] is not None

        def spread(measure, scale=1.0, digits=2, summaries=summaries):
            values = scale * np.array([s[measure] for s in summaries])
            return f"{values.mean():.{digits}f} ± {np.abs(values - values.mean()).max():.{digits}f}"

        rows.append({
            "on": name,
            "sulci": ", ".join(str(s["folds"]) for s in summaries),
            "gyrification index": spread("gyrification_index", digits=3),
            "depth (mm)": spread("sulcal_depth", 1e3),
            "registration": spread("registration") if registered else None,
            "p": max(s["registration_p"] for s in summaries) if registered else None,
        })  # fmt: skip
    return rows


def draw(results, figure):
    figure.set_size_inches(14, 10)
    first = {name.rpartition(", seed")[0]: one for name, one in results.items() if name.endswith(" 0")}
    for axes, name, result in figures.section_grid(figure, 3, 3, first):
        idle = "IPH" in name and "ATH" not in name
        note = " (the pattern has no way to act)" if idle else ""
        words = figures.measures(result).replace(", registration", ",\nregistration")
        axes.set_title(f"{name}{note}\n{words}", fontsize=9)


if __name__ == "__main__":
    run_case(__file__)
