"""Fields of the state at a body's integration points."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..state import State


def at_points(body: Body, state: State, name: str, *components: int) -> Array | None:
    """Return a field at the integration points, (*components, q, e), or None if no process writes it.

    Raises ValueError for a field of another shape.
    """
    values = state.fields.get(name)
    wanted = (*components, *body.quadrature.weights.shape)
    if values is not None and np.shape(values) != wanted:
        raise ValueError(
            f"the field {name!r} has shape {np.shape(values)}; it must be {wanted}: values at each "
            "integration point, see body.quadrature."
        )
    return values
