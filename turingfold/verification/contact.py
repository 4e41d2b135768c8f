"""Contact and tension: gaps, forces that balance, a string's energy."""

from __future__ import annotations

import numpy as np
from skfem import MeshTri1

from ..arrays import Array
from ..geometry.body import Body
from ..geometry.shapes import semicircle
from ..parts import TimeStep
from ..state import State
from ..terms.tension import AxonalTension
from .check import Check, Quantity
from .setups import evaluated

SLOT = 0.3


def walls() -> list[Quantity]:
    """Two walls 0.03 apart whose middles bulge by 0.005 as parabolas: gap 0.03 - 2 · 0.005, to 1e-9.

    The barrier's forces sum to zero, and their moment does: contact is between the two walls alone.
    """
    from ..terms.contact import SelfContact

    body = slotted()
    x = closed(body, 0.03).reshape(-1, 2)
    on = (np.abs(body.nodes[0] - 1 - SLOT / 2) < 0.51 * SLOT) & np.isclose(body.nodes[1], 1.125)
    x[on, 0] += 0.005 * np.sign(1 + SLOT / 2 - body.nodes[0, on])
    state = State(1.0, {"displacement": np.zeros_like(body.nodes), "stress_scale": np.array(1.0)})
    at = evaluated(SelfContact().on(body).during(state, TimeStep(0.1)), x.ravel())
    force, places = at.gradient()[0].reshape(-1, 2), body.nodes.T + x
    size = float(np.abs(force).sum())
    moment = float((places[:, 0] * force[:, 1] - places[:, 1] * force[:, 0]).sum())
    return [
        Quantity("smallest gap", 0.02, float(at.measure()["min_gap"]), 1e-7),
        Quantity("contact pushes: sum of |force| > 0", 1.0, float(size > 0), 0.0),
        Quantity("net force / sum of |force|", 0.0, float(np.abs(force.sum(0)).max() / size), 1e-12),
        Quantity("net moment / sum of |force|", 0.0, moment / size, 1e-12),
    ]


def line_tension() -> list[Quantity]:
    """Energy γ L of a line tension γ = 2 on the interface π (R - T), stretched by 1.2; it balances itself."""
    body = semicircle(radius=1.0, thickness=0.3, size=0.15, base="free")
    count = body.cortex.mesh.doflocs.shape[1]
    state = State(1.0, {"displacement": np.zeros_like(body.nodes), "pattern": np.ones(count)})
    potential = AxonalTension(strength=2.0, follower=True).on(body).during(state, TimeStep(0.1))
    at = evaluated(potential, (0.2 * body.nodes).T.ravel())
    force = at.gradient()[0].reshape(-1, 2)
    x, y = 1.2 * body.nodes
    size, moment = float(np.abs(force).sum()), float((x * force[:, 1] - y * force[:, 0]).sum())
    return [
        Quantity("energy", 2.0 * 1.2 * np.pi * 0.7, float(at.energy), 1e-6),
        Quantity("net force / sum of |force|", 0.0, float(np.abs(force.sum(0)).max() / size), 1e-12),
        Quantity("net moment / sum of |force|", 0.0, moment / size, 1e-12),
    ]


def slotted(size: float = 0.25) -> Body:
    """Return a block of two columns with a slot of depth 1 and width SLOT between them, from x = 1 on."""
    x = np.concatenate([np.arange(0, 1 + 1e-9, size), np.arange(0, 1 + 1e-9, size) + 1 + SLOT])
    mesh = MeshTri1.init_tensor(x, np.arange(0, 1.5 + 1e-9, size))
    centre = mesh.p[:, mesh.t].mean(1)
    inside = (centre[0] > 1) & (centre[0] < 1 + SLOT) & (centre[1] > 0.5)
    mesh = mesh.remove_elements(np.flatnonzero(inside))
    sides = {"pial": lambda p: p[1] > 0, "base": lambda p: p[1] == 0}
    return Body(mesh.with_boundaries(sides), 0.2, "free")


def closed(body: Body, gap: float) -> Array:
    """Return the displacement that moves the right column until the slot has this width from y = 1 up."""
    shift = np.where(body.nodes[0] > 1, (gap - SLOT) * np.clip(2 * body.nodes[1] - 1, 0.0, 1.0), 0.0)
    return np.asarray(np.stack([shift, np.zeros_like(shift)]).T.ravel())


CHECKS = (
    Check("Contact: bulged walls", walls, "geometry, balance"),
    Check("Tension: line", line_tension, "tension times length, balance"),
)
