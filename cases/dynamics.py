"""Document 1's time-dependent run: growth from rest with inertia, against its quasi-static limit. About 40 s.

    turingfold run cases/dynamics.py      stores results/dynamics, draws figures/dynamics.png

A shear wave (0.7 m/s) crosses the brain in 60 ms. Growth by 90 % within 10 s, 1 s and 0.1 s, from zero
displacement and velocity, density 1100 kg/m³: how much of the shape is inertia?
"""

import numpy as np

from turingfold import (
    Inertia,
    Linear,
    Scene,
    SelfContact,
    TangentialGrowth,
    figures,
    human,
    run_case,
    semicircle,
)
from turingfold import parameters as p

DURATIONS = (10.0, 1.0, 0.1)


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 4,
    base: p.Base = "clamped", seed: p.Seed = 0, density: p.Density = 1100.0,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 1.9, core: p.Core = 1.0, radial_core: p.RadialCore = 1.0,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.5,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    half_waves = half_waves or human.half_waves(body)
    solid = human.tissue(young_gray=young_gray, young_white=young_white, poisson=poisson)

    def grown_in(duration, *inertia):
        history, ramp = Linear(duration=duration), 0.1 * duration
        grow = TangentialGrowth(cortex=cortex, core=core, radial_core=radial_core, history=history)
        morphogens, pull = human.pattern_and_pull(
            kinetics=kinetics, half_waves=half_waves, strength=strength, ramp=ramp
        )
        processes, terms = (*morphogens, grow), (solid, *pull, SelfContact(), *inertia)
        return Scene(body=body, processes=processes, terms=terms, until=duration, seed=seed)

    inertia = Inertia(density=density)
    return {"quasi-static": grown_in(1.0)} | {f"{d:g} s": grown_in(d, inertia) for d in DURATIONS}


def draw(results, figure):
    figure.set_size_inches(11, 7)
    axes = figure.subplot_mosaic([["quasi-static", "0.1 s"], ["energy", "outlines"]])
    slow = results["quasi-static"]
    for number, (name, result) in enumerate(results.items()):
        if name in axes:
            figures.section(axes[name], result)
            axes[name].set_title(f"{name}\n{figures.measures(result)}", fontsize=9)
        if result is slow:
            axes["outlines"].plot(*(1e3 * slow.pial()), color="0.6", linewidth=3, label=name)
            continue
        color = f"C{number - 1}"
        growth = [row["growth"] for row in result.history]
        axes["energy"].semilogy(growth, [row["kinetic_energy"] for row in result.history], color, label=name)
        apart = 1e3 * np.hypot(*(result.pial() - slow.pial())).max()
        label = f"{name}: {apart:.2g} mm apart"
        axes["outlines"].plot(*(1e3 * result.pial()), color, linewidth=0.8, label=label)
    axes["energy"].set(xlabel="tangential growth", ylabel="kinetic energy (J/m)")
    axes["energy"].set_title("energy of the motion")
    axes["energy"].legend(frameon=False)
    axes["outlines"].set(aspect="equal", xlabel="mm", title="pial surfaces at the end")
    axes["outlines"].legend(frameon=False, fontsize=8, loc="lower center")


if __name__ == "__main__":
    run_case(__file__)
