"""Triangles at the boundary that are about to turn over: a barrier where quadrature points do not look.

Where the surface creases, a triangle may turn over at a side while its volume at the quadrature points, and
with it the elastic energy, stays finite.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Integers
from ..geometry.body import Body
from .pair_barrier import PairBarrier, barrier_slope, cross

LEAST = 0.2  # det F below which the barrier acts
# places along the side at the boundary, and det F that it has there at least: det F is quadratic, so that its
# least value between two places lies below the lower one by its second derivative over 8·16² at most
FLOOR = 0.02
PLACES = np.stack([np.arange(17) / 16, np.zeros(17)], axis=1)


class Inversion(PairBarrier):
    """Triangles, of which det F is β × α at each place over what it is at rest; nodes: theirs, (6, c)."""

    def measure(self, directions: Array) -> Array:
        """Return β × α over its floor."""
        return np.asarray(cross(directions) - self.floor)

    def derivatives(self, directions: Array) -> tuple[Array, Array]:
        """Return the derivatives of β × α."""
        (alpha, beta), k = directions, directions.shape[1]
        first = np.stack([-beta[:, 1], beta[:, 0], alpha[:, 1], -alpha[:, 0]], axis=1)
        second = np.zeros((4, 4))
        second[0, 3] = second[3, 0] = -1.0
        second[1, 2] = second[2, 1] = 1.0
        return first, np.broadcast_to(second, (k, 4, 4))


def bounding(body: Body, edges: Integers) -> Integers:
    """Return the nodes of the triangles at boundary edges (start, middle, end), (6, m), that side first."""
    triangles = body.triangles[:, body.mesh.f2t[0, edges[1] - body.mesh.nvertices]]
    side = np.argmax(triangles[3:] == edges[1], axis=0)  # middles follow the corners
    turned = (np.arange(3)[:, None] + side) % 3
    return np.concatenate([np.take_along_axis(part, turned, 0) for part in (triangles[:3], triangles[3:])])


def inversion(triangles: Integers, rest: Array, stiffness: float) -> Inversion:
    """Return the barrier for triangles, (6, c), of nodes at `rest`, (n, 2); stiffness: as of contact."""
    free = Inversion(triangles, derivatives(PLACES), np.empty(0), np.empty(0))
    at_rest = free.measure(free.directions(rest))
    share = 0.5 * at_rest / len(PLACES)  # of the area
    weight = stiffness * share * LEAST / -barrier_slope(0.5)
    return Inversion(triangles, free.shares, (LEAST - FLOOR) * at_rest, weight, FLOOR * at_rest)


def derivatives(places: Array) -> Array:
    """Return the derivatives of the six shape functions along both axes, α last, (2, p, 6), at (p, 2)."""
    x, y = places.T
    z = 1 - x - y
    nil = np.zeros_like(x)
    along_x = np.stack([1 - 4 * z, 4 * x - 1, nil, 4 * (z - x), 4 * y, -4 * y], axis=1)
    along_y = np.stack([1 - 4 * z, nil, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)], axis=1)
    return np.stack([along_y, along_x])
