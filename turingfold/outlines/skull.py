"""The inside of the skull around a section: the convex hull, or the closing, enlarged by the gap of CSF."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import MultiPoint, Polygon

from ..arrays import Array
from ..checks import positive
from ..geometry.body import Body
from .region import closed, even_odd, pieces

CORNER = 32  # pieces of a quarter of a circle


def skull_around(body: Body, *, gap: float, closing: float | None = None) -> Array:
    """Return a closed curve (2, n) around a body, its last point the first, for SelfContact(skull=...).

    gap: between the skull and the convex hull of the whole section, m, filled with cerebrospinal fluid.
    closing: in place of the hull, the section with what is narrower than a disc of this radius filled, m, as
    if the skull followed fissures that are wider.
    Raises ValueError for a section with a base, around which a skull has ends, and for a closing in pieces.
    """
    positive("gap", gap)
    if not all(path.closed for path in body.pial_paths):
        raise ValueError(
            "skull_around is for closed sections; around one with a base give the points of the skull."
        )
    loops = [body.nodes[:, path.nodes] for path in body.pial_paths]
    if closing is None:
        around = MultiPoint(np.concatenate(loops, axis=1).T).convex_hull
    else:
        found = pieces(closed(even_odd(loops), positive("closing", closing)))
        if len(found) != 1:
            raise ValueError(
                f"closing={closing:g} m leaves {len(found)} pieces; one skull needs a larger radius, or "
                "none, for the convex hull."
            )
        around = Polygon(found[0].exterior)
    return np.asarray(shapely.get_coordinates(around.buffer(gap, quad_segs=CORNER).exterior).T)
