"""Patterns on growing tissue: mode doubling on a strip, a pattern that evolves while the cortex folds. 2 min.

    turingfold run cases/turing_growth.py      draws figures/turing_growth.png

Left: Schnakenberg's kinetics on a strip that grows as exp(0.01 t), with dilution; half waves double at each
doubling of its length (Crampin, Gaffney, Maini 1999). Right: the scene of Figure 3, and one with more growth,
each with the steady pattern of the undeformed band and with one that goes on reacting on the moving tissue.
"""

import numpy as np
from skfem import MeshTri

from turingfold import (
    AxonalTension,
    Elastic,
    NeoHookean,
    Scene,
    Schnakenberg,
    SelfContact,
    TangentialGrowth,
    Turing,
    figures,
    semicircle,
)
from turingfold.turing.evolving import EvolvingTuring
from turingfold.turing.growing import march_growing
from turingfold.turing.modes import sign_changes
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise

THICKNESS = 2.5e-3
GROWTH = {"growth 1.9": (24, 1.9), "growth 3": (20, 3.0)}  # half waves at the start, growth of the cortex
PACE = 1000.0  # kinetic time in the time of growth: the pattern follows the tissue


def scenes(quick=False):
    body = semicircle(radius=0.0404, thickness=THICKNESS, size=THICKNESS / (2 if quick else 3))
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    terms = (Elastic(gray=gray, white=white), AxonalTension(strength=0.5), SelfContact())
    found = {}
    for name, (half_waves, cortex) in GROWTH.items():
        steady = Turing(Schnakenberg(), half_waves=half_waves)
        for kind, pattern in {"steady": steady, "evolving": EvolvingTuring(steady, pace=PACE)}.items():
            processes = (pattern, TangentialGrowth(cortex=cortex))
            found[f"{kind} pattern, {name}"] = Scene(body=body, processes=processes, terms=terms)
    return found


def doubling(along=160, rate=0.01, until=285.0):
    """Return times, positions, u (times, positions) and half waves on a strip that grows exponentially."""
    space = discretise(MeshTri.init_tensor(np.linspace(0, 1, along + 1), np.array([0, 1 / along])), 2)
    line = np.flatnonzero(space.nodes[1] == 0.0)
    line = line[np.argsort(space.nodes[0, line])]
    system = ReactionDiffusion(space, Schnakenberg(), 0.01, 1.0)
    state = system.uniform(1.0, 0.9)
    state[0] += 0.001 * np.cos(np.pi * space.nodes[0])
    run = march_growing(
        system, state, lambda t: float(np.exp(rate * t)), until=until, dimensions=1, tolerance=1e-3
    )
    times, values = zip(*((moment.time, moment.state[0, line]) for moment in run), strict=True)
    counts = np.array([sign_changes(u - u.mean()) for u in values])
    return np.array(times), space.nodes[0, line], np.array(values), counts


def draw(results, figure):
    figure.set_size_inches(16, 8)
    left, right = figure.subfigures(1, 2, width_ratios=(1, 2))
    times, x, u, counts = doubling()
    axes = left.subplots()
    size = np.exp(0.01 * times)
    colours = axes.pcolormesh(np.outer(size, x), np.repeat(times[:, None], len(x), 1), u, shading="gouraud")
    for count in np.unique(counts):
        seen = times[counts == count]
        if np.ptp(seen) > 5:  # not those passed through while peaks split one after the other
            edge = np.exp(0.01 * seen[0])
            words = f"{count} half wave{'s' * bool(count > 1)}, L = {edge:.3g}"
            axes.annotate(words, (1.02 * edge + 0.3, seen[0]), va="bottom")
    axes.set_xlabel("position on the growing strip")
    axes.set_ylabel("time")
    axes.set_title("mode doubling")
    axes.spines[["top", "right"]].set_visible(False)
    left.colorbar(colours, ax=axes, label="activator u", location="bottom", shrink=0.6)
    for axes, name, result in figures.section_grid(right, 2, 2, results):
        summary, along = result.summary(), result.pattern()
        axes.set_title(
            f"{name}: {sign_changes(along - along.mean())} half waves, {figures.sulci(summary['folds'])},\n"
            f"gyrification {summary['gyrification_index']:.2f}, registration {summary['registration']:+.2f}, "
            f"processes {summary['seconds_by_part']['processes']:.1f} of {summary['seconds']:.0f} s",
            fontsize=9,
        )
