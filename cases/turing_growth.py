"""Patterns on growing tissue: mode doubling on a strip, a pattern that evolves while the cortex folds. 2 min.

    turingfold run cases/turing_growth.py      draws figures/turing_growth.png

Left: Schnakenberg's kinetics on a strip that grows as exp(0.01 t), with dilution; half waves double at each
doubling of its length (Crampin, Gaffney, Maini 1999). Right: the body of Figure 3, of which
the cortex alone grows, by two factors, each with the steady pattern of the undeformed band and with one that
goes on reacting on the moving tissue; and two whose reactions run faster, or slower, by the stretch of the
tissue: faster ones double the waves, and the cortex folds otherwise.
"""

import numpy as np

from turingfold import (
    EvolvingTuring,
    Scene,
    Schnakenberg,
    SelfContact,
    TangentialGrowth,
    Turing,
    figures,
    growing_strip,
    human,
    kinetics_named,
    run_case,
    semicircle,
    sign_changes,
)
from turingfold import parameters as p

GROWTH = {"growth 1.9": (1.0, 1.9), "growth 3": (5 / 6, 3.0)}  # half waves over the parameter, cortex
RATE = 0.01  # of the strip's growth
STRETCH = {"faster": 1.0, "slower": -1.0}  # exponents by which reactions follow the change of area


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 3,
    base: p.Base = "clamped", seed: p.Seed = 0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.5,
    pace: p.Pace = 1000.0,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    half_waves = half_waves or human.half_waves(body)
    solid = human.tissue(young_gray=young_gray, young_white=young_white, poisson=poisson)
    _, pull = human.pattern_and_pull(strength=strength)
    found = {}
    for name, (share, cortex) in GROWTH.items():
        steady = Turing(kinetics_named(kinetics), half_waves=max(1, round(share * half_waves)))
        for kind, pattern in {"steady": steady, "evolving": EvolvingTuring(steady, pace=pace)}.items():
            processes, terms = (pattern, TangentialGrowth(cortex=cortex)), (solid, *pull, SelfContact())
            scene = Scene(body=body, processes=processes, terms=terms, seed=seed)
            found[f"{kind} pattern, {name}"] = scene
    share, cortex = GROWTH["growth 1.9"]
    steady = Turing(kinetics_named(kinetics), half_waves=max(1, round(share * half_waves)))
    for word, exponent in STRETCH.items():
        pattern = EvolvingTuring(steady, pace=pace, stretch_exponent=exponent)
        processes, terms = (pattern, TangentialGrowth(cortex=cortex)), (solid, *pull, SelfContact())
        scene = Scene(body=body, processes=processes, terms=terms, seed=seed)
        found[f"{word} where stretched, growth 1.9"] = scene
    return found


def computed(results):
    return vars(growing_strip(Schnakenberg(), lambda t: float(np.exp(RATE * t)), until=285.0))


def draw(results, figure, computed):
    figure.set_size_inches(16, 8)
    left, right = figure.subfigures(1, 2, width_ratios=(1, 2))
    times, x, u, counts = (computed[name] for name in ("times", "positions", "u", "half_waves"))
    axes = left.subplots()
    size = np.exp(RATE * times)
    colours = axes.pcolormesh(np.outer(size, x), np.repeat(times[:, None], len(x), 1), u, shading="gouraud")
    for count in np.unique(counts):
        seen = times[counts == count]
        if np.ptp(seen) > 5:  # not those passed through while peaks split one after the other
            edge = np.exp(RATE * seen[0])
            words = f"{count} half wave{'s' * bool(count > 1)}, L = {edge:.3g}"
            axes.annotate(words, (1.02 * edge + 0.3, seen[0]), va="bottom")
    axes.set_xlabel("position on the growing strip")
    axes.set_ylabel("time")
    axes.set_title("mode doubling")
    axes.spines[["top", "right"]].set_visible(False)
    left.colorbar(colours, ax=axes, label="activator u", location="bottom", shrink=0.6)
    for axes, name, result in figures.section_grid(right, 3, 2, results):
        summary, along = result.summary(), result.pattern()
        axes.set_title(
            f"{name}: {sign_changes(along - along.mean())} half waves, {figures.sulci(summary['folds'])},\n"
            f"gyrification {summary['gyrification_index']:.2f}, registration {summary['registration']:+.2f}, "
            f"processes {summary['seconds_by_part']['processes']:.1f} of {summary['seconds']:.0f} s",
            fontsize=9,
        )


if __name__ == "__main__":
    run_case(__file__)
