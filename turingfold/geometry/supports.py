"""What holds a body in place: clamped and sliding lines, and what else each of its parts needs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Integers
from .paths import Path


def components(triangles: Integers) -> Integers:
    """Return for each node of triangles (6, e), all of them used, the number of its connected part; (n,)."""
    first = np.broadcast_to(triangles[0], triangles.shape)
    count = int(triangles.max()) + 1
    links = coo_matrix((np.ones(triangles.size), (first.ravel(), triangles.ravel())), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1])


def holds(points: Array, part: Integers, supported: Integers) -> Integers:
    """Return degrees of freedom 2·node + component that prevent rigid motions which nothing else prevents.

    points: (2, n).  part: number of the connected part of each node, (n,); each part is held by itself, near
    its middle. Without loads from outside and contact with other parts what holds it carries no force.
    """
    found: list[int] = []
    for k in range(int(part.max()) + 1):
        own = np.flatnonzero(part == k)
        dofs = supported[part[supported // 2] == k]
        x, y = points[:, own]
        middle = int(np.argmin((x - x.mean()) ** 2 + (y - y.mean()) ** 2))
        free_x, free_y = (not (dofs % 2 == i).any() for i in (0, 1))
        node = 2 * int(own[middle])
        if free_x and free_y:
            far = int(own[np.argmax(y - np.abs(x - x[middle]))])
            found += [node, node + 1, 2 * far]
        elif free_x or free_y:
            found.append(node + (0 if free_x else 1))
    return np.array(sorted(found), dtype=np.int64)


def clamped(paths: Iterable[Path]) -> Integers:
    """Return both degrees of freedom 2·node + component of all nodes along some lines."""
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *(path.nodes for path in paths)])
    return np.union1d(2 * nodes, 2 * nodes + 1)


def sliding(points: Array, paths: Iterable[Path], name: str, within: float) -> Integers:
    """Return degrees of freedom 2·node + component across straight lines on which a body slides.

    points: (2, n).  within: distance in m by which a line may deviate from a horizontal or vertical one;
    ValueError, with the boundary's name, if it deviates more.
    """
    dofs = [np.zeros(0, dtype=np.int64)]
    for path in paths:
        spread = np.ptp(points[:, path.nodes], axis=1)
        axis = int(np.argmin(spread))
        if spread[axis] > within:
            raise ValueError(
                f"boundary {name!r} is not a horizontal or vertical line (it spreads {spread[axis]:.3g} m), "
                'so it cannot slide on rollers; use base="clamped" or "free", or turn the body.'
            )
        dofs.append(2 * path.nodes + axis)
    return np.unique(np.concatenate(dofs))
