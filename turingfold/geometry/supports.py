"""What holds parts of a body in place that no base, mirror or clamped hole holds."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Integers


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
