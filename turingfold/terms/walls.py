"""The boundary as chords in ipctk's collision mesh: what is close, and how far walls may move.

The distances are those of incremental potential contact (Li et al. 2020), found by ipctk.
"""

from __future__ import annotations

from collections.abc import Sequence

import ipctk
import numpy as np
from scipy.sparse import kron
from scipy.spatial import cKDTree

from ..arrays import Array, Integers
from ..geometry.quadratic import distance, gap
from .boundary import chords, neighbours

FAR = 0.05  # of the body: on longer ways all chords pass others, so that the near part is seen first

MEETINGS = {
    "body": ("itself", "outlines that keep their distance"),
    "base": ("the line on which its base continues", "base_line=False"),
    "mirror": ("the line of its mirror", "an outline that keeps its distance"),
    "skull": ("the skull", "a wider one"),
}


class Walls:
    """Chords of the boundary's quadratic edges, all moved by the edges' nodes; lengths as the caller's.

    edges: start, middle and end node of each, (3, m).  counts: chords of each, (m,).  rest: nodes, (n, 2),
    of which the first `moving` are the body's.  apart: distance that chords always keep.  near: parts of one
    wall that are closer than this at rest do not repel each other.
    """

    def __init__(
        self, edges: Integers, counts: Integers, rest: Array, moving: int, apart: float, near: float
    ) -> None:
        self.edges, self.counts, self.apart = edges, counts, apart
        self.chords = chords(edges, counts, moving, len(rest))
        at_rest = self.positions(rest)
        self.far = FAR * float(np.ptp(at_rest[: self.chords.moving], axis=0).max())
        self.mesh = ipctk.CollisionMesh(at_rest, np.asfortranarray(self.chords.pieces.astype(np.int32)))
        pairs = neighbours(at_rest, self.chords.pieces, near)
        wall = ipctk.make_sparse_filter(dict.fromkeys(map(tuple, pairs.tolist()), False), True)
        self.mesh.can_collide = ipctk.make_static_obstacle_filter(self.chords.moving) & wall
        # from the displacement of the body's boundary nodes to that of the vertices that move
        self.share = kron(self.chords.share[: self.chords.moving, :moving], np.eye(2), format="csr")

    def positions(self, points: Array) -> Array:
        """Return the vertices of the chords, (v, 2), of nodes at `points`, (n, 2)."""
        positions: Array = np.asfortranarray(self.chords.share @ points)
        return positions

    def collisions(self, positions: Array, within: float) -> ipctk.NormalCollisions:
        """Return the pairs closer than `within`, beside what they keep apart anyway."""
        found = ipctk.NormalCollisions()
        found.use_area_weighting = True
        found.build(self.mesh, positions, within, self.apart, ipctk.SweepAndPrune())
        return found

    def edges_within(self, positions: Array, within: float) -> Integers:
        """Return the edges, (n,), of which a chord is closer than `within`, beside what chords keep apart."""
        found, chords = self.collisions(positions, within), self.chords
        at = [(chords.edge[c.vertex_id], chords.edge_of[c.edge_id]) for c in found.ev_collisions]
        at += [(chords.edge[c.vertex0_id], chords.edge[c.vertex1_id]) for c in found.vv_collisions]
        return np.unique(np.array(at, dtype=np.int64))

    def cross(self, positions: Array) -> bool:
        """Return whether chords cross each other."""
        return bool(ipctk.has_intersections(self.mesh, positions))

    def largest_step(self, start: Array, end: Array) -> float:
        """Return nine tenths of the share of the way at which chords first come too close, at most 1."""
        way = end - start
        share = min(1.0, self.far / max(float(np.abs(way).max()), self.far))
        while (step := self._free_share(start, start + share * way)) == 1.0 and share < 1.0:
            share = min(1.0, 2.0 * share)
        return share * step

    def _free_share(self, start: Array, end: Array) -> float:
        pairs = ipctk.Candidates()
        pairs.build(self.mesh, start, end, 0.5 * self.apart, ipctk.SweepAndPrune())
        if pairs.is_step_collision_free(self.mesh, start, end, self.apart):
            return 1.0
        return 0.9 * float(pairs.compute_collision_free_stepsize(self.mesh, start, end, self.apart))

    def smallest_gap(self, points: Array, within: float) -> float:
        """Return the smallest distance between curved walls closer than `within`, or NaN without any."""
        positions, chords = self.positions(points), self.chords
        found = self.collisions(positions, within)
        if found.empty():
            return float("nan")
        pairs = [(c.vertex_id, *chords.pieces[c.edge_id], c.edge_id) for c in found.ev_collisions]
        pairs += [(c.vertex0_id, *2 * (c.vertex1_id,), -1) for c in found.vv_collisions]
        vertex, start, end, piece = np.array(pairs).T
        gaps = distance(*(positions[k].T for k in (vertex, start, end)))
        one = chords.edge[vertex]
        other = np.where(piece < 0, chords.edge[end], chords.edge_of[piece])
        xi, eta = chords.place[vertex], np.where(piece < 0, chords.place[end], chords.place_of[piece])
        # places on edges with a common node would run together there
        clear = ~(self.edges[:, None, one] == self.edges[:, other]).any((0, 1))
        edges = points[self.edges].transpose(0, 2, 1)
        gaps[clear] = gap(edges[..., one[clear]], edges[..., other[clear]], xi[clear], eta[clear])
        return float(gaps.min())

    def close_edges(self, positions: Array, within: float) -> Integers:
        """Return the pairs of the body's edges, (n, 2), that have vertices closer than `within`."""
        tree = cKDTree(positions[: self.chords.moving])
        pairs = tree.query_pairs(within, output_type="ndarray")
        return np.asarray(np.unique(self.chords.edge[pairs], axis=0))


def check_rest(
    walls: Walls, rest: Array, dhat: float, names: Sequence[str], unit: float, centre: Array
) -> None:
    """Raise ValueError where walls cross at rest or are closer than dhat.

    rest: nodes, (n, 2), in units of `unit` m about `centre`.  names: of what each edge belongs to.
    """
    at_rest = walls.positions(rest)
    if walls.cross(at_rest):
        raise ValueError(
            "SelfContact: the undeformed boundary crosses itself; repair the outline, or use smaller "
            "elements where its walls are close."
        )
    found = walls.collisions(at_rest, dhat)
    if found.empty():
        return
    vertices = [v for v in found[0].vertex_ids(walls.mesh.edges, walls.mesh.faces) if v >= 0]
    met, remedy = MEETINGS[names[walls.chords.edge[vertices].max()]]  # obstacles come last
    x, y = at_rest[min(vertices)] * unit + centre
    raise ValueError(
        f"SelfContact: the undeformed boundary comes closer to {met} than dhat = {dhat * unit:.3g} m, near "
        f"({x:.4g}, {y:.4g}) m; use a smaller gap, or {remedy}."
    )
