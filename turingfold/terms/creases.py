"""Walls that fold together about a node: what keeps two boundary edges with a common end from crossing.

Seen from their common node, the places ξ of both edges lie in the directions α = (x(ξ) - x(0))/ξ and β alike;
outside the body the angle between them is θ, half a turn on a smooth surface and zero where both walls meet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Booleans, Integers

PLACES = np.array([0.0, 0.2, 0.4])  # ξ; farther from the node, chords of the two edges repel each other
LEVERS = np.array([0.05, 0.2, 0.4])  # of an edge: at which walls push there
SHARE = 0.15  # of an edge that each place stands for
NARROW = 0.75  # times `gap`: angle below which walls repel, and not above half of that at rest
QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class Creases:
    """Pairs of edges with a common node: barrier Σ w b(θ/θ₀) with b(z) = -(z - 1)² ln z for z < 1.

    nodes: the common one, middle and end of the edge from which θ is measured clockwise, and of the other,
    (5, c).  narrow: θ₀, (c,).  weight: w by place and pair, (3, c); lengths and energies as the caller's.
    """

    nodes: Integers
    narrow: Array
    weight: Array

    def directions(self, points: Array) -> Array:
        """Return α and β at each place, (2, 3, c, 2), of nodes at `points` (n, 2)."""
        return np.asarray(np.einsum("apk,kcx->apcx", _FROM_NODES, points[self.nodes]))

    def at(self, points: Array) -> Crease:
        """Return those of the pairs that repel each other where the nodes are at `points`, (n, 2)."""
        directions = self.directions(points)
        angle = np.arctan2(_cross(directions), _dot(directions))
        place, pair = np.nonzero((angle > 0) & (angle < self.narrow))
        return Crease(
            nodes=self.nodes[:, pair],
            place=place,
            directions=directions[:, place, pair],
            z=angle[place, pair] / self.narrow[pair],
            narrow=self.narrow[pair],
            weight=self.weight[place, pair],
        )

    def largest_step(self, start: Array, end: Array) -> float:
        """Return nine tenths of the share of the way at which two walls first meet, at most 1; exactly."""
        first, last = self.directions(start), self.directions(end)
        constant, square = _cross(first), _cross(last - first)
        linear = _cross(last) - constant - square
        # roots of c + l t + q t² by the form that does not cancel
        root = np.sqrt(np.maximum(linear**2 - 4 * square * constant, 0.0))
        half = -0.5 * (linear + np.copysign(root, linear))
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = np.stack([half / square, constant / half])
        real = linear**2 >= 4 * square * constant
        steps = np.where(real & (steps > 0) & (steps <= 1) & np.isfinite(steps), steps, np.inf)
        t = np.where(np.isfinite(steps), steps, 0.0)[..., None]
        closing = linear + 2 * square * t[..., 0] <= 0
        facing = _dot(first[:, None] + t * (last - first)[:, None]) > 0
        return min(1.0, 0.9 * float(np.min(steps, initial=np.inf, where=closing & facing)))


@dataclass(frozen=True, eq=False)
class Crease:
    """Those pairs and places at which walls repel each other, k of them; z = θ/θ₀ in (0, 1)."""

    nodes: Integers
    place: Integers
    directions: Array
    z: Array
    narrow: Array
    weight: Array

    @property
    def empty(self) -> bool:
        """Whether there are none."""
        return not self.z.size

    @property
    def energy(self) -> float:
        """Σ w b(z)."""
        return float(-self.weight @ ((self.z - 1) ** 2 * np.log(self.z)))

    def add_forces(self, forces: Array) -> None:
        """Add the gradient of the energy to that of the nodes, (n, 2)."""
        slope = self.weight / self.narrow * _slope(self.z)
        by_node = np.einsum("k,akx,akn->nkx", slope, self._turned(), _FROM_NODES[:, self.place])
        np.add.at(forces, self.nodes, by_node)

    def hessian(self, definite: bool) -> tuple[Integers, Integers, Array]:
        """Return rows, columns (2 n + x) and values of the second derivatives, (k, 10, 10).

        definite: whether the negative eigenvalues of each pair, in terms of α and β, are set to zero.
        """
        turned = self._turned()  # ∂θ/∂α and ∂θ/∂β
        flat = turned.transpose(1, 0, 2).reshape(-1, 4)
        outer = np.einsum("k,ki,kj->kij", self.weight * _curvature(self.z) / self.narrow**2, flat, flat)
        slope = self.weight * _slope(self.z) / self.narrow
        for arm, sign in enumerate((1.0, -1.0)):
            # of an angle arg α: -(α ⊗ Jα + Jα ⊗ α)/|α|⁴, and Jα/|α|² is its first derivative
            away = self.directions[arm] / np.sum(self.directions[arm] ** 2, axis=-1)[:, None]
            mixed = np.einsum("kx,ky->kxy", away, sign * turned[arm])
            block = slice(2 * arm, 2 * arm + 2)
            outer[:, block, block] -= (sign * slope)[:, None, None] * (mixed + mixed.swapaxes(1, 2))
        if definite:
            values, vectors = np.linalg.eigh(outer)
            outer = np.einsum("kie,ke,kje->kij", vectors, np.maximum(values, 0.0), vectors)
        share = _FROM_NODES[:, self.place]
        by_node = np.einsum("akn,kaxby,bkm->knxmy", share, outer.reshape(-1, 2, 2, 2, 2), share)
        dofs = (2 * self.nodes.T[..., None] + np.arange(2)).reshape(-1, 10)
        rows, columns = (np.broadcast_to(d, (len(dofs), 10, 10)) for d in (dofs[:, :, None], dofs[:, None]))
        return rows, columns, by_node.reshape(-1, 10, 10)

    def _turned(self) -> Array:
        """Return the derivatives of θ = arg α - arg β in α and β, (2, k, 2)."""
        away = self.directions / np.sum(self.directions**2, axis=-1, keepdims=True)
        return np.asarray(away @ QUARTER_TURN.T * np.array([1.0, -1.0])[:, None, None])


def creases(edges: Integers, left: Booleans, rest: Array, gap: float, stiffness: float) -> Creases:
    """Return the pairs of edges (start, middle, end), (3, m), that have a node of the body in common.

    left: of the body's edges, which come before those of obstacles: whether tissue is left of the way along.
    rest: the nodes at rest, (n, 2).  stiffness: traction, about, where θ is half of θ₀.
    """
    nodes = np.array(_pairs(edges, left, rest), dtype=np.int64).reshape(-1, 5).T
    directions = np.einsum("apk,kcx->apcx", _FROM_NODES, rest[nodes])
    at_rest = np.arctan2(_cross(directions), _dot(directions)).min(axis=0)
    narrow = NARROW * gap * np.ones(nodes.shape[1])
    narrow = np.where(at_rest > 0, np.minimum(narrow, 0.5 * at_rest), narrow)
    lengths = 0.5 * sum(np.hypot(*(rest[nodes[k]] - rest[nodes[0]]).T) for k in (2, 4))
    weight = SHARE * stiffness * LEVERS[:, None] * lengths**2 * narrow / -_slope(0.5)
    return Creases(nodes, narrow, weight)


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


def _from_nodes() -> Array:
    """Return the shares of the five nodes in α and β at each place, (2, 3, 5)."""
    shares = np.stack([2 * PLACES - 3, 4 * (1 - PLACES), 2 * PLACES - 1], axis=1)
    found = np.zeros((2, len(PLACES), 5))
    found[0][:, [0, 1, 2]] = found[1][:, [0, 3, 4]] = shares
    return found


_FROM_NODES = _from_nodes()


def _cross(directions: Array) -> Array:
    """Return β × α = |α| |β| sin θ."""
    alpha, beta = directions
    return np.asarray(beta[..., 0] * alpha[..., 1] - beta[..., 1] * alpha[..., 0])


def _dot(directions: Array) -> Array:
    """Return α · β."""
    return np.asarray(np.sum(directions[0] * directions[1], axis=-1))


def _slope(z: Array | float) -> Array:
    """Return b'(z)."""
    return np.asarray(-2 * (z - 1) * np.log(z) - (z - 1) ** 2 / z)


def _curvature(z: Array) -> Array:
    """Return b''(z)."""
    return np.asarray(-2 * np.log(z) - 4 * (z - 1) / z + (z - 1) ** 2 / z**2)
