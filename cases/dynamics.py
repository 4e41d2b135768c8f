"""Document 1's time-dependent run: growth from rest with inertia, against its quasi-static limit. About 40 s.

    turingfold run cases/dynamics.py      stores results/dynamics, draws figures/dynamics.png

A shear wave (0.7 m/s) crosses the brain in 60 ms. Growth by 90 % within 10 s, 1 s and 0.1 s, from zero
displacement and velocity, density 1100 kg/m³: how much of the shape is inertia?
"""

import numpy as np

from turingfold import (
    AxonalTension,
    Elastic,
    Inertia,
    Linear,
    NeoHookean,
    Scene,
    Schnakenberg,
    SelfContact,
    TangentialGrowth,
    Turing,
    figures,
    semicircle,
)

THICKNESS = 2.5e-3
DURATIONS = (10.0, 1.0, 0.1)


def scenes(quick=False):
    body = semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / (2 if quick else 4))
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    pattern, solid = Turing(Schnakenberg(), half_waves=24), Elastic(gray=gray, white=white)

    def grown_in(duration, *inertia):
        pull = AxonalTension(strength=0.5, ramp=0.1 * duration)
        grow = TangentialGrowth(cortex=1.9, history=Linear(duration=duration))
        terms = (solid, pull, SelfContact(), *inertia)
        return Scene(body=body, processes=(pattern, grow), terms=terms, until=duration)

    inertia = Inertia(density=1100.0)
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
