"""Core growth prescribed, and as a response of white matter to stress. About 4 min.

    turingfold run cases/stress_growth.py      draws figures/stress_growth.png

The scene of Figure 3 with three cores: one that does not grow; one that grows as in Figure 3; and one whose
white matter grows along the stress that it bears, at the rate 1 over its shear modulus in the time of growth
(Bayly et al. 2013), with 40, 80 and 160 equal steps. The inner core swells in all of them.
"""

from dataclasses import replace

from turingfold import Stepping, figures, human, run_case, semicircle
from turingfold import parameters as p

STEPS = (40, 80, 160)


@p.quick(elements=2, thickness=5e-3, cortex=1.9)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 3,
    base: p.Base = "clamped", seed: p.Seed = 0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 2.3, core: p.Core = 1.05, radial_core: p.RadialCore = 1.1, swelling: p.Swelling = 0.2,
    rate: p.StressRate = 1.0,
    half_waves: p.HalfWaves = None, strength: p.Strength = 0.75,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)

    def scene(*, steps=20, core=1.0, across=1.0, law="prescribed"):
        made = human.brain(
            body, young_gray=young_gray, young_white=young_white, poisson=poisson, cortex=cortex, core=core,
            radial_core=across, swelling=swelling, growth_law=law, stress_rate=rate, half_waves=half_waves,
            strength=strength, seed=seed,
        )  # fmt: skip
        return replace(made, stepping=Stepping(first=1 / steps, largest=1 / steps))

    found = {"core that does not grow": scene()}
    found["core that grows as prescribed"] = scene(core=core, across=radial_core)
    for steps in (10, 20) if quick else STEPS:
        found[f"core that grows by stress, {steps} steps"] = scene(steps=steps, law="stress")
    return found


def draw(results, figure):
    *others, last = results
    *_, coarse = [name for name in others if "stress" in name][:1]
    index = {name: results[name].summary()["gyrification_index"] for name in (coarse, last)}
    shown = {name: results[name] for name in results if "stress" not in name or name in (coarse, last)}
    figure.set_size_inches(12, 8)
    for axes, name, result in figures.section_grid(figure, 2, 2, shown):
        note = ""
        if name == last:
            note = f" (index of the panel before: {100 * (index[coarse] / index[last] - 1):+.2f} %)"
        axes.set_title(f"{name}{note}\n{figures.measures(result)}\n{figures.areas(result)}", fontsize=9)


if __name__ == "__main__":
    run_case(__file__)
