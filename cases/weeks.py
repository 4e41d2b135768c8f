"""Weeks 25, 28, 32 and 40: the semi-circle by gestational age, with inertia. About 2 min.

    turingfold run cases/weeks.py      draws figures/weeks.png

The ages of document 1's Figure 4, from a smooth week 25 on. Its radius, 35.6 mm, is 0.88 of that of document
1's week 28, and the core grows by half in both directions and the cortex to 3.1 times its length by week 40:
our choice, made so that week 28 has the 40.4 mm of document 1 (it comes out within 1 mm), and the cortex
grows twice as much as the core: with 3.3 two triangles in sulci turned over at 4 elements. Growth is spread
over the weeks as Wang et al. (2019) give it; the base slides, as the whole brain grows wider. The fifteen
weeks are run within 10 s, from rest; steps end exactly at the weeks that are shown.
"""

from turingfold import Weeks, figures, human, run_case, semicircle
from turingfold import parameters as p

WEEKS = 25.0, 28.0, 32.0, 40.0


@p.quick(elements=2, thickness=5e-3)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0356, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 4,
    base: p.Base = "roller", seed: p.Seed = 0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 3.1, core: p.Core = 1.5, radial_core: p.RadialCore = 1.5, swelling: p.Swelling = 0.0,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.75,
    dynamics: p.Dynamics = True, duration: p.Duration = 10.0, curve: p.WeekCurve = "wang",
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    ages = Weeks(start=WEEKS[0], end=WEEKS[-1], duration=duration, curve=curve)
    scene = human.brain(
        body, young_gray=young_gray, young_white=young_white, poisson=poisson, cortex=cortex, core=core,
        radial_core=radial_core, swelling=swelling, kinetics=kinetics, half_waves=half_waves,
        strength=strength, dynamics=dynamics, ages=ages, stops=ages.times(*WEEKS[1:-1]), seed=seed,
    )  # fmt: skip
    return {"weeks": scene}


def draw(results, figure):
    result = results["weeks"]
    figure.set_size_inches(13, 7.5)
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    limits = figures.field_limits(result)
    for axes, week in zip(grid.flat, WEEKS, strict=True):
        state = result.at(week=week)
        step = result.states.index(state)
        colors = figures.section(axes, result, step, bar=False, limits=limits)
        x, y = 1e3 * result.pial(step)
        size = f"{(x.max() - x.min()) / 2:.1f} mm half wide, {y.max():.1f} mm high"
        axes.set_title(f"{result.label(state)}: {size}\n{figures.numbers(result, step)}", fontsize=10)
    label = "von Mises stress (kPa)"
    figure.colorbar(colors, ax=grid, label=label, shrink=0.5, aspect=30, extend="max")


if __name__ == "__main__":
    run_case(__file__)
