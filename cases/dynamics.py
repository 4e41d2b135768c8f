"""Document 1's time-dependent run: growth from rest, with inertia, against its quasi-static limit. 4 min.

    turingfold run cases/dynamics.py      draws figures/dynamics.png

A shear wave (0.7 m/s) crosses the brain in 60 ms. The growth of Figure 3 within 10 s, 1 s and 0.1 s, from
zero displacement and velocity, density 1100 kg/m³: how much of the shape is inertia? Motion is damped by a
stress of 10 ms times the rate of the elastic one; document 1 gives no damping, ours is part of the model.
Steps follow the motion: each moves no node further off it than a share of the thickness. One run, dotted, has
half of that. For a second after growth the motion dies: what is left then is told beside its peak.
"""

import numpy as np

from turingfold import figures, human, run_case, semicircle
from turingfold import parameters as p

DURATIONS = (10.0, 1.0, 0.1)
HALVED = "1 s, half the error"


@p.quick(elements=2, thickness=5e-3, cortex=2.0)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 2.5e-3, elements: p.Elements = 3,
    base: p.Base = "clamped", seed: p.Seed = 0, density: p.Density = 1100.0, damping: p.Damping = 0.01,
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 2.3, core: p.Core = 1.05, radial_core: p.RadialCore = 1.1, swelling: p.Swelling = 0.2,
    kinetics: p.Kinetics = "Schnakenberg", half_waves: p.HalfWaves = None, strength: p.Strength = 0.75,
    local_error: p.LocalError = 0.02,
):  # fmt: skip
    body = semicircle(radius=radius, thickness=thickness, elements=elements, base=base)
    common = {
        "young_gray": young_gray, "young_white": young_white, "poisson": poisson, "cortex": cortex,
        "core": core, "radial_core": radial_core, "swelling": swelling, "kinetics": kinetics,
        "half_waves": half_waves, "strength": strength, "density": density, "damping": damping, "seed": seed,
    }  # fmt: skip

    def grown_in(duration, share=1.0):
        error = share * local_error
        return human.brain(body, dynamics=True, duration=duration, local_error=error, **common)

    found = {"quasi-static": human.brain(body, **common)}
    found |= {f"{duration:g} s": grown_in(duration) for duration in DURATIONS[2 * quick :]}
    return found if quick else found | {HALVED: grown_in(1.0, 0.5)}


def draw(results, figure):
    figure.set_size_inches(12, 8)
    axes = figure.subplot_mosaic([["quasi-static", "0.1 s"], ["energy", "outlines"]])
    slow = results["quasi-static"]
    axes["outlines"].plot(*(1e3 * slow.pial()), color="0.6", linewidth=3, label="quasi-static")
    colors = {f"{duration:g} s": f"C{k}" for k, duration in enumerate(DURATIONS)}
    for name, result in results.items():
        s = result.summary()
        if name in axes:
            figures.section(axes[name], result)
            axes[name].set_title(f"{name}\n{figures.measures(result)}", fontsize=10)
        if result is slow:
            continue
        color, line = colors[name.partition(",")[0]], ":" if name == HALVED else "-"
        times = np.array([row["time"] for row in result.history])
        energy = np.array([row["kinetic_energy"] for row in result.history])
        most = f"{name}: peak {energy.max():.2g}, {energy[-1]:.1g} at the end, {s['steps']} steps"
        duration = result.scene.until - human.REST
        axes["energy"].semilogy(times / duration, energy, color=color, linestyle=line, label=most)
        if name != HALVED:
            apart = 1e3 * np.hypot(*(result.pial() - slow.pial())).max()
            words = f"{name}: {figures.sulci(s['folds'])}, index {s['gyrification_index']:.2f}"
            label = f"{words}, {apart:.2g} mm apart"
            axes["outlines"].plot(*(1e3 * result.pial()), color=color, linewidth=0.8, label=label)
    axes["energy"].set(xlabel="time over duration of growth", ylabel="kinetic energy (J/m)", xlim=(0, 2))
    axes["energy"].set_title("energy of the motion")
    axes["energy"].set_ylim(1e-18, 0.1)  # room for the legend
    axes["energy"].legend(frameon=False, fontsize=8, loc="lower left")
    axes["outlines"].set(aspect="equal", xlabel="mm", title="pial surfaces at the end")
    axes["outlines"].legend(frameon=False, fontsize=8, loc="lower center")


if __name__ == "__main__":
    run_case(__file__)
