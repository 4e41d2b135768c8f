"""Walls that fold together about a node: what keeps two boundary edges with a common end from crossing.

Seen from their common node, the places ξ of both edges lie in the directions α = (x(ξ) - x(0))/ξ and β alike;
outside the body the angle between them is θ, half a turn on a smooth surface and zero where both walls meet.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Booleans, Integers
from .pair_barrier import PairBarrier, barrier_slope, cross, dot

PLACES = np.array([0.0, 0.2, 0.4])  # ξ; farther from the node, chords of the two edges repel each other
LEVERS = np.array([0.05, 0.2, 0.4])  # of an edge: at which walls push there
SHARE = 0.15  # of an edge that each place stands for
NARROW = 0.75  # times `gap`: angle below which walls repel, and not above half of that at rest
QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


class Creases(PairBarrier):
    """Pairs of edges with a common node, θ from the first of them clockwise to the other.

    nodes: the common one, middle and end of the first edge, and of the other, (5, c).
    """

    def measure(self, directions: Array) -> Array:
        """Return the angle θ = arg α - arg β in (-π, π]."""
        return np.asarray(np.arctan2(cross(directions), dot(directions)))

    def derivatives(self, directions: Array) -> tuple[Array, Array]:
        """Return the derivatives of θ: that of arg α is Jα/|α|² with J a quarter turn, and so on."""
        away = directions / np.sum(directions**2, axis=-1, keepdims=True)
        turned = away @ QUARTER_TURN.T * np.array([1.0, -1.0])[:, None, None]
        second = np.zeros((directions.shape[1], 4, 4))
        for arm in range(2):
            # of arg α, -(α ⊗ Jα + Jα ⊗ α)/|α|⁴
            mixed = away[arm][:, :, None] * turned[arm][:, None]
            block = slice(2 * arm, 2 * arm + 2)
            second[:, block, block] = -(mixed + mixed.swapaxes(1, 2))
        return turned.swapaxes(0, 1).reshape(-1, 4), second

    def closing(self, directions: Array) -> Booleans:
        """Return whether both walls go the same way: the angle is zero, not half a turn."""
        return np.asarray(dot(directions) > 0)


def creases(edges: Integers, left: Booleans, rest: Array, gap: float, stiffness: float) -> Creases:
    """Return the pairs of edges (start, middle, end), (3, m), that have a node of the body in common.

    left: of the body's edges, which come before those of obstacles: whether tissue is left of the way along.
    rest: the nodes at rest, (n, 2).  stiffness: traction, about, where θ is half of its bound.
    """
    nodes = np.array(_pairs(edges, left, rest), dtype=np.int64).reshape(-1, 5).T
    free = Creases(nodes, _shares(), np.empty(0), np.empty(0))
    at_rest = free.measure(free.directions(rest)).min(axis=0)
    narrow = np.where(at_rest > 0, np.minimum(NARROW * gap, 0.5 * at_rest), NARROW * gap)
    lengths = 0.5 * sum(np.hypot(*(rest[nodes[k]] - rest[nodes[0]]).T) for k in (2, 4))
    weight = SHARE * stiffness * LEVERS[:, None] * lengths**2 * narrow / -barrier_slope(0.5)
    return Creases(nodes, free.shares, np.broadcast_to(narrow, weight.shape), weight)


def _pairs(edges: Integers, left: Booleans, rest: Array) -> list[list[int]]:
    """Return the five nodes of each pair, the edge first from which θ is measured clockwise."""
    arms: dict[int, list[tuple[bool | None, list[int]]]] = {}  # of each node: tissue left of the edge, nodes
    for k, edge in enumerate(edges.T.tolist()):
        inside = bool(left[k]) if k < len(left) else None
        arms.setdefault(edge[0], []).append((inside, edge))
        arms.setdefault(edge[2], []).append((None if inside is None else not inside, edge[::-1]))
    found = []
    for node, meeting in arms.items():
        own = sorted((a for a in meeting if a[0] is not None), key=lambda a: not a[0])
        if len(own) == 2 and own[0][0] and not own[1][0]:
            found.append([*own[0][1], *own[1][1][1:]])
        if not own:
            continue
        for _, obstacle in (a for a in meeting if a[0] is None):  # which goes on from a corner of the body
            ways = (rest[[a[1][2] for a in own] + [obstacle[2]]] - rest[node]) @ np.array([1.0, 1.0j])
            turns = np.angle(ways[:-1] / ways[-1])
            nearest = int(np.argmin(np.abs(turns)))
            pair = (own[nearest][1], obstacle) if turns[nearest] > 0 else (obstacle, own[nearest][1])
            found.append([*pair[0], *pair[1][1:]])
    return found


def _shares() -> Array:
    """Return the shares of the five nodes in α and β at each place, (2, 3, 5)."""
    shares = np.stack([2 * PLACES - 3, 4 * (1 - PLACES), 2 * PLACES - 1], axis=1)
    found = np.zeros((2, len(PLACES), 5))
    found[0][:, [0, 1, 2]] = found[1][:, [0, 3, 4]] = shares
    return found
