"""Points of the pial surface whose places are known at an age, beside its outline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, Booleans, Integers
from ..checks import finite_array
from ..geometry.body import Body
from ..geometry.surface_table import Places, arcs_of, checked_places
from ..results.surface import mirror_line
from .targets import FAR


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Landmarks of one age on a body.

    nodes, shares: of each on the surface, (3, k), the nodes of its edge and what each counts.
    mirrored: whether it lies on the image of half a body, (k,).  targets: where they are, (2, k); m.
    """

    body: Body
    nodes: Integers
    shares: Array
    mirrored: Booleans
    targets: Array

    def apart(self, x: Array) -> Array:
        """Return how far the landmarks are from their targets at a displacement (2 n_nodes,), (2, k); m."""
        there = self._of(self.body.nodes + x.reshape(-1, 2).T)
        line = mirror_line(self.body) if self.mirrored.any() else 0.0
        there[0] += np.where(self.mirrored, 2 * line, 0.0)
        return np.asarray(there - self.targets)

    def moved(self, x: Array) -> Array:
        """Return what a displacement (2 n_nodes,) moves the landmarks by, (2, k)."""
        return self._of(x.reshape(-1, 2).T)

    def _of(self, at_nodes: Array) -> Array:
        found = np.einsum("ak,iak->ik", self.shares, at_nodes[:, self.nodes])
        found[0] *= np.where(self.mirrored, -1.0, 1.0)
        return np.asarray(found)


def landmarks_of(body: Body, age: float, given: Sequence[tuple[Any, Any]]) -> Landmarks:
    """Return landmarks as (place, point): where one is on the undeformed surface, and at that age, in m.

    A place is a share of the pial surface's length, of a closed outline from its first point, or a point in
    m. On half a body it is a share of the whole surface's: up to 0.5 on the half, from where its own begins,
    the others on its image.
    Raises ValueError for places off the surface, what are no pairs, and bodies that nothing supports.
    """
    what = f"landmarks[{age:g}]"
    if not body.supported.size:
        raise ValueError(f"{what}: nothing supports the body, which is laid on its target; give it a base.")
    try:
        places, points = zip(*given, strict=True)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be pairs of place and point, such as (0.25, (0.01, 0.04)).") from None
    targets = finite_array(what, points, (len(points), 2)).T
    far = float(np.abs(targets - body.nodes.mean(axis=1, keepdims=True)).max())
    if far > FAR * body.length:
        raise ValueError(
            f"{what} is {far:.3g} m from the body's middle, the body {body.length:.3g} m long: are both in m?"
        )
    curve, length = body.pial_curve, body.pial_curve.length
    whole = length * (2.0 if body.mirror else 1.0)
    known, mirrored = _on_the_half(body, checked_places(places, len(points), what))
    arc = arcs_of(known, body.pial_curves, whole, body.thickness)
    if np.ndim(known) == 1 and curve.closed:
        arc = (arc + body.first_arcs[0]) % length
    mirrored |= arc > length
    arc = np.where(arc > length, whole - arc, arc)
    ends = np.append(curve.arc, length) if curve.closed else curve.arc
    pial = np.append(body.pial, body.pial[0]) if curve.closed else body.pial
    edge = np.clip(np.searchsorted(ends[::2], arc, side="right") - 1, 0, len(ends) // 2 - 1)
    nodes = 2 * edge[None] + np.arange(3)[:, None]
    low, middle, high = ends[nodes]
    xi = np.where(arc < middle, (arc - middle) / (middle - low), (arc - middle) / (high - middle))
    shares = np.stack([0.5 * xi * (xi - 1), (1 - xi) * (1 + xi), 0.5 * xi * (xi + 1)])
    return Landmarks(body, pial[nodes], shares, mirrored, targets)


def _on_the_half(body: Body, places: Places) -> tuple[Places, Booleans]:
    """Return places of which points on the image of half a body are put on the half, and which these are."""
    found = np.array(places)
    if not body.mirror or found.ndim == 1:
        return places, np.zeros(len(found), dtype=bool)
    line = mirror_line(body)
    beyond = np.asarray((found[:, 0] - line) * (body.nodes[0].mean() - line) < 0)
    found[beyond, 0] = 2 * line - found[beyond, 0]
    return tuple((x, y) for x, y in found.tolist()), beyond


def checked_landmarks(
    body: Body, targets: Mapping[float, Array], given: Mapping[float, Sequence[tuple[Any, Any]]]
) -> dict[float, Landmarks]:
    """Return the landmarks by age; raises ValueError for an age without an outline."""
    if not isinstance(given, Mapping):
        raise ValueError(f"landmarks is {type(given).__name__}; give them by age, {{1.0: [(0.25, (x, y))]}}.")
    for age in given:
        if float(age) not in targets:
            raise ValueError(f"landmarks has the age {age:g}, and targets no outline of it.")
    return {float(age): landmarks_of(body, age, marks) for age, marks in given.items()}
