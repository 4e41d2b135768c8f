"""Results as objects of other libraries: a PyVista mesh of a state, an xarray Dataset of all states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..state import State
from .vtu import mesh_of


def as_pyvista(body: Body, state: State, observed: Mapping[str, Array]) -> Any:
    """Return a state as a PyVista grid of quadratic triangles, undeformed."""
    _need("pyvista")
    import pyvista

    return pyvista.wrap(mesh_of(body, state, observed))


def as_xarray(body: Body, states: Sequence[State], rows: Sequence[Mapping[str, float]]) -> Any:
    """Return states and history as an xarray Dataset.

    Fields by state: dimensions "time", "node", "axis"; "point" and "triangle" for integration points (q, e);
    "cortex_node" for nodes of the cortex.  Numbers of the history: "step", as "history_<name>".
    """
    _need("xarray")
    import xarray

    known = {
        body.nodes.shape[1:]: ("node",),
        body.quadrature.weights.shape: ("point", "triangle"),
        body.cortex.nodes.shape: ("cortex_node",),
    }
    found: dict[str, Any] = {}
    for name in sorted(set.intersection(*(set(state.fields) for state in states))):
        values = np.stack([state[name] for state in states])
        inner = next((dims for shape, dims in known.items() if values.shape[-len(shape) :] == shape), ())
        free = values.ndim - 1 - len(inner)
        axes = ("axis",) if name == "displacement" else tuple(f"{name}_{k}" for k in range(free))
        found[name] = (("time", *axes, *inner), values)
    for name in rows[0] if rows else ():
        found[f"history_{name}"] = ("step", np.array([row.get(name, np.nan) for row in rows]))
    places = {axis: ("node", along) for axis, along in zip("xy", body.nodes, strict=True)}
    coords = {"time": [state.time for state in states], **places}
    made = xarray.Dataset(found, coords=coords)
    for name in ("x", "y", "displacement"):
        made[name].attrs["units"] = "m"
    return made


def _need(package: str) -> None:
    if find_spec(package) is None:
        raise ModuleNotFoundError(f"this needs {package}: pip install {package}", name=package)
