"""Growth of the core: how much of it leaves folds, on semi-circle and semi-ellipse. About 3 min.

    turingfold run cases/growth_of_the_core.py      draws figures/growth_of_the_core.png

The scenes of Figures 3 and 2 with a cortex that grows by 90 % or by 130 % along its surface, and a core that
grows by 0 to 40 % in both directions. What folds is the growth of the cortex over that of the core. Stars:
the defaults of Figures 2 and 3, 2.3 over 1.05 along the surface, 1.1 across and swelling of the inner core by
20 %. They were chosen after seeing some 25 runs with cortex 1.9 to 2.5, core 1.05 to 1.2, swelling 0 to 0.2
and tension 0.5 to 1.5 N/m, so that on both bodies the area becomes at least 1.4 times as large, registration
is above 0.75, the index no less than that of cortex-only growth, and no triangle turns over at 6 elements:
with cortex 2.4, core 1.1, swelling 0.15 and 1 N/m two did, in sulci beside the base of the ellipse.
"""

from turingfold import human, run_case, semicircle, semiellipse
from turingfold import parameters as p

CORTEX, CORE = (1.9, 2.3), (1.0, 1.1, 1.2, 1.3, 1.4)
CHOSEN = (2.3, 1.05, 1.1)
PANELS = {
    "gyrification_index": "gyrification index", "folds": "sulci", "registration": "registration",
    "area_growth": "area, deformed over undeformed",
}  # fmt: skip


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, height: p.Height = 0.74 * 0.0404, thickness: p.Thickness = 2.5e-3,
    elements: p.Elements = 3, base: p.Base = "clamped", strength: p.Strength = 0.75,
    swelling: p.Swelling = 0.2, seed: p.Seed = 0,
):  # fmt: skip
    bodies = {
        "circle": semicircle(radius=radius, thickness=thickness, elements=elements, base=base),
        "ellipse": semiellipse(
            width=2 * radius, height=height, thickness=thickness, elements=elements, base=base
        ),
    }
    waves = {"circle": None, "ellipse": human.half_waves(bodies["ellipse"], width=2.22)}
    points = [(g, core, core, 0.0) for g in CORTEX for core in CORE] + [(*CHOSEN, swelling)]
    return {
        named(shape, *point): human.brain(
            body, cortex=point[0], core=point[1], radial_core=point[2], swelling=point[3], strength=strength,
            half_waves=waves[shape], seed=seed,
        )
        for shape, body in bodies.items()
        for point in (points[-2:] if quick else points)
    }  # fmt: skip


def named(shape, cortex, core, across, swelling):
    return f"{shape}, {cortex:g} over {core:g}" + (f", swelling {swelling:g}" if swelling else "")


def draw(results, figure):
    figure.set_size_inches(11, 6.5)
    series = {}
    for name, result in results.items():
        shape, growth, *swollen = name.split(", ")
        cortex, core = map(float, growth.split(" over "))
        kind = shape, "chosen" if swollen else f"cortex {cortex:g}"
        series.setdefault(kind, []).append((cortex / core, result.summary()))
    for axes, (measure, label) in zip(figure.subplots(2, 2).flat, PANELS.items(), strict=True):
        for (shape, kind), points in series.items():
            ratios, values = zip(*((ratio, s[measure]) for ratio, s in sorted(points)[::-1]), strict=True)
            color = "C0" if shape == "circle" else "C1"
            marker = {"chosen": "*", "cortex 1.9": "s"}.get(kind, "o")
            size, line = (13, "none") if kind == "chosen" else (5, "-" if marker == "o" else "--")
            style = {"color": color, "marker": marker, "markersize": size, "linestyle": line}
            axes.plot(ratios, values, label=f"{shape}, {kind}", **style)
        axes.set(xlabel="growth of the cortex over that of the core", ylabel=label)
        axes.spines[["top", "right"]].set_visible(False)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)


if __name__ == "__main__":
    run_case(__file__)
