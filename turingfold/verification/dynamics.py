"""Motion: a bar that vibrates after a sudden pull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from skfem import MeshTri1

from ..arrays import Array
from ..geometry.body import Body
from ..parts import Load, Operator, TimeStep
from ..scene import Scene
from ..solve.march import begin, march
from ..state import State
from ..stepping import MIDPOINT, Stepping
from ..terms.dynamics import Inertia
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic
from ..terms.line import DeadLoad
from .check import Check, Quantity

LENGTH, HEIGHT, YOUNG, DENSITY, PULL = 1.0, 0.1, 3.0, 2.0, 1e-4
ELEMENTS, PERIODS, STEPS = 24, 2, 400


@dataclass(frozen=True)
class Pull(Load):
    """A dead force on the right end of the bar, from the start on, evenly spread; N/m."""

    force: float

    def on(self, body: Body) -> Pulled:
        """Return the force on a body."""
        return Pulled(body, self.force)


class Pulled(Operator):
    """The force on one body."""

    def __init__(self, body: Body, force: float) -> None:
        """Spread it over the end's edges by Simpson's rule, exact for quadratic shape functions."""
        right = np.flatnonzero(body.nodes[0] > LENGTH - 1e-9)
        order = right[np.argsort(body.nodes[1, right])]
        shares = np.zeros(len(order))
        for k in range(0, len(order) - 2, 2):
            shares[k : k + 3] += np.array([1, 4, 1]) / 6
        forces = np.zeros((body.nodes.shape[1], 2))
        forces[order, 0] = force * shares / shares.sum()
        self.load = DeadLoad(forces.ravel())

    def during(self, state: State, step: TimeStep) -> DeadLoad:
        """Return the force, which does not change."""
        return self.load


def bar_under_a_sudden_pull() -> list[Quantity]:
    """u(L, t) of a bar fixed at x = 0, ν = 0, pulled by F from t = 0 on: between 0 and 2 F L/(E A), linear.

    The wave of speed c = √(E/ρ) makes it a triangle of period 4 L/c, that is the sum of all modes ω_n =
    (2 n - 1) π c/(2 L) with 8/(π² (2 n - 1)²) each. By the midpoint rule the sum of kinetic and strain energy
    and that of the load stays 0. Waves of a few elements or steps run too slowly: 1.3 % at the peak.
    """
    moments = pulled_bar()
    wave = LENGTH / np.sqrt(YOUNG / DENSITY)
    static = PULL * LENGTH / (YOUNG * HEIGHT)
    times, ends, energies, kinetic = moments
    phase = np.exp(1j * np.pi * times / (2 * wave))  # of the first mode
    # 1 - cos(ω₁ t) has the share 8/π² in the end's motion: its phase tells the period
    waves = np.stack([np.ones_like(times), phase.real, phase.imag], axis=1)
    _, along, across = np.linalg.lstsq(waves, ends, rcond=None)[0] / static
    peak = float(ends.max() / (2 * static))
    return [
        Quantity("largest displacement of the end / (2 F L/(E A))", 1.0, peak, 2e-2),
        Quantity("share of the first mode", 8 / np.pi**2, float(-along), 1e-2),
        Quantity("part of it out of phase", 0.0, float(across), 1e-2),
        Quantity("energy / largest kinetic energy", 0.0, float(np.abs(energies).max() / kinetic.max()), 1e-4),
    ]


def pulled_bar() -> tuple[Array, Array, Array, Array]:
    """Return times, displacements of the bar's end, m, and all and kinetic energy, J/m, of two periods."""
    grid = MeshTri1.init_tensor(np.linspace(0, LENGTH, ELEMENTS + 1), np.array([0, HEIGHT / 2, HEIGHT]))
    sides = {"pial": lambda x: x[1] == HEIGHT, "base": lambda x: x[0] == 0}
    body = Body(grid.with_boundaries(sides), 0.5 * HEIGHT, "roller")
    until = PERIODS * 4 * LENGTH / float(np.sqrt(YOUNG / DENSITY))
    stepping = Stepping(first=1 / STEPS, largest=1 / STEPS, scheme=MIDPOINT, tolerance=1e-10)
    scene = Scene(
        body=body, until=until, stepping=stepping,
        terms=(Elastic(gray=NeoHookean.from_young(YOUNG, 0.0)), Pull(PULL), Inertia(density=DENSITY)),
    )  # fmt: skip
    middle = int(np.argmin(np.hypot(body.nodes[0] - LENGTH, body.nodes[1] - HEIGHT / 2)))
    steps = [step for step, _ in march(scene, begin(scene))]
    times, stored, kinetic = (
        np.array([step.numbers[name] for step in steps]) for name in ("time", "energy", "kinetic_energy")
    )
    ends = np.array([step.state["displacement"][0, middle] for step in steps])
    return times, ends, stored + kinetic, kinetic


CHECKS = (Check("Dynamics: suddenly pulled bar", bar_under_a_sudden_pull, "d'Alembert's solution"),)
