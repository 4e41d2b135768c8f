"""Snaps: where Newton's method finds no equilibrium near the last one, the body creeps down to the next.

Past a limit point the nearest minimum is far, and no shorter step of the scene's time comes closer to it.
With a viscosity c the body moves by steps of the gradient flow: each minimises

    Φ(x) + ½ c (x - x_k)·M (x - x_k),   M = ∫ u·v dA,

whose solution has less energy than x_k, and whose tangent K + c M is positive definite for c above the most
negative eigenvalue -λ of (K, M). Kept just above it, c lets the softest mode grow by c/(c - λ) in a step.
Where the tangent is positive definite again c falls, and at the end it is gone. A saddle is left along the
softest mode, also one that the flow only comes near: there a mode grows from next to nothing. Where no mode
grows and the flow hardly moves, Newton's method is tried without viscosity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..errors import NotConvergedError, OutOfMemoryError, SolveError
from ..parts import Potential
from ..scene import Scene, stress_scale
from ..terms.dynamics import mass
from ..terms.quadratic_energy import Quadratic, SymmetricMatrix
from .equilibrium import Equilibrium
from .newton import Minimiser

FIRST, STIFFEST, LEAST = 1.0, 1e6, 1e-9  # viscosities, in units of the largest shear modulus over T²
STEPS = 300
PATIENCE = 12  # iterations of a step of the flow
EASY, QUICK = 8, 4  # iterations after which the viscosity falls, and falls fast
FALLS, FALLS_FAST, RISES = 0.5, 0.1, 3.0
FORGETS = 0.8  # of a viscosity that was too small, in each step after it
PUSH, PUSHES = 0.05, 20  # away from a saddle: largest displacement in units of T, and how often
RESTS, ABOVE = 1e-2, 1.5  # movement in units of T, and distance from a viscosity that was too small
POWERS = 12  # iterations for the softest mode


@dataclass(frozen=True, eq=False)
class Creep:
    """The gradient flow of a scene: mass matrix, scale of the viscosity, cortical thickness."""

    mass: SymmetricMatrix
    scale: float
    thickness: float

    @classmethod
    def of(cls, scene: Scene) -> Creep:
        """Return that of a scene."""
        T = scene.body.thickness
        return cls(mass(scene.body, 1.0), stress_scale(scene.terms) / T**2, T)

    def to_minimum(self, minimiser: Minimiser, potentials: tuple[Potential, ...], x: Array) -> Equilibrium:
        """Return the equilibrium at which the gradient flow from x ends.

        Raises NotConvergedError where the flow finds no way down, or takes too many steps.
        """
        share = good = FIRST
        floor, soft, pushes, rests, failed = 0.0, np.zeros_like(x), 0, 0, None
        for _ in range(STEPS):
            share = share if share >= LEAST else 0.0
            viscous, before = share > 0, minimiser.effort.iterations
            try:
                found = self._step(minimiser, potentials, x, share)
            except OutOfMemoryError:
                raise
            except SolveError as error:
                failed, floor = error, share
                share = share * RISES if viscous else good
                if minimiser.out_of_time or share > STIFFEST:
                    break
                continue
            spent = minimiser.effort.iterations - before
            moved = float(np.abs(found.x - x).max()) / self.thickness
            if viscous and found.stable:
                good, floor = share, FORGETS * floor
                x, soft = found.x, minimiser.softest_mode(self.mass.whole, POWERS)
                share *= FALLS_FAST if spent <= QUICK else FALLS if spent <= EASY else 1.0
                if moved > PUSH:
                    floor = 0.0  # the energy is curved in another way here
                elif moved < RESTS and floor:
                    if pushes < PUSHES:  # a mode that is hardly there yet may grow
                        x, pushes = self._pushed(potentials, found, soft), pushes + 1
                    if x is found.x:  # nothing grows and little moves: a minimum is near, if anywhere
                        rests += 1
                        if rests & (rests - 1) == 0:  # tried at the 1st, 2nd, 4th, 8th, ... such place
                            share = floor = 0.0
                share = max(share, ABOVE * floor)
            elif viscous:  # too little viscosity for the softest mode
                x, share = found.x, share * RISES**2
                if pushes < PUSHES:
                    x, pushes = self._pushed(potentials, found, soft), pushes + 1
            elif found.stable or pushes == PUSHES:
                return found
            else:
                x, pushes, share = self._pushed(potentials, found, soft), pushes + 1, FIRST
        residual = failed.residual if failed is not None else float("nan")
        words = f" ({failed})" if failed is not None else ""
        raise NotConvergedError(f"no way down to a minimum is found{words}", residual=residual)

    def _step(
        self, minimiser: Minimiser, potentials: tuple[Potential, ...], x: Array, share: float
    ) -> Equilibrium:
        """Return the end of one step of the flow from x, with a share of the first viscosity."""
        more = (Quadratic(self.mass, x, share * self.scale),) if share else ()
        minimiser.forget()
        allowed = minimiser.iterations
        # walls may be softer than any viscosity stiffens: where even the first does not, they are made convex
        minimiser.strict = 0 < share <= FIRST
        minimiser.iterations = min(allowed, PATIENCE) if minimiser.strict else allowed
        try:
            return minimiser.minimise((*potentials, *more), x)
        finally:
            minimiser.iterations, minimiser.strict = allowed, False

    def _pushed(self, potentials: tuple[Potential, ...], found: Equilibrium, mode: Array) -> Array:
        """Return the lower of the two places beside an equilibrium along a mode, (2 n_nodes,), or itself."""
        size = float(np.hypot(*mode.reshape(-1, 2).T).max())
        if not size:  # none is known before the first stable step
            return found.x
        push = PUSH * self.thickness / size * mode
        push = push * found.at.largest_step(push)
        sides = [found.x + share * push for share in (1.0, -1.0, 0.1, -0.1)]
        lowest = min(sides, key=lambda side: _energy(potentials, side))
        return lowest if _energy(potentials, lowest) < _energy(potentials, found.x) else found.x


def _energy(potentials: tuple[Potential, ...], x: Array) -> float:
    parts = [potential.evaluate(x) for potential in potentials]
    return sum(np.inf if part is None else part.energy for part in parts)
