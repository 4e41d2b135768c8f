"""Frames for ParaView: one VTU file per state, and the PVD index of the series."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..geometry.body import Body
from ..parts import STRESS_FIELDS
from ..scene import Scene
from ..state import State
from .files import DAMAGE, CorruptFileError
from .units import stored_unit, with_unit, without_unit
from .vtu_file import grid, vtu

if TYPE_CHECKING:
    import meshio


class Frames:
    """The VTU files of a scene's states: of their mesh, what is written is made once."""

    def __init__(self, scene: Scene, comment: str = "") -> None:
        self.scene, self._comment = scene, comment
        self._grid = grid(_points(scene.body), scene.body.triangles.T)

    def content(self, state: State, observed: Mapping[str, Array]) -> bytes:
        """Return a VTU file with what `mesh_of` has, its fields with their units, and the time.

        Warp By Vector shows the deformed shape.
        """
        at_nodes, in_triangles = _fields(self.scene.body, state, observed)
        return vtu(self._grid, self._named(at_nodes), self._named(in_triangles), state.time, self._comment)

    def _named(self, fields: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        return {with_unit(name, stored_unit(self.scene, name)): own for name, own in fields.items()}


def mesh_of(body: Body, state: State, observed: Mapping[str, Array]) -> meshio.Mesh:
    """Return a mesh of quadratic triangles, undeformed, with the fields of a state.

    At nodes: displacement (m, with a third component 0) and the morphogens, NaN outside the cortex. In
    triangles, averaged over the area: observed (q, e), such as von_mises (Pa), the growth factor along the
    tangent, layer (1 gray, 0 white), and of a solid its Cauchy stress (Pa), all nine components.
    """
    import meshio

    at_nodes, in_triangles = _fields(body, state, observed)
    cells = {name: [values] for name, values in in_triangles.items()}
    triangles = [("triangle6", body.triangles.T)]
    return meshio.Mesh(_points(body), triangles, point_data=at_nodes, cell_data=cells)


def _points(body: Body) -> Array:
    """Return the nodes, (n, 3)."""
    return np.append(body.nodes.T, np.zeros((body.nodes.shape[1], 1)), axis=1)


def _fields(
    body: Body, state: State, observed: Mapping[str, Array]
) -> tuple[dict[str, Array], dict[str, NDArray[Any]]]:
    """Return fields at nodes, (n,) or (n, 3), and in triangles, (e,) or (e, 9)."""
    at_nodes: dict[str, Array] = {"displacement": np.zeros((body.nodes.shape[1], 3))}
    at_nodes["displacement"][:, :2] = state["displacement"].T
    in_triangles: dict[str, NDArray[Any]] = {n: in_cells(body, values) for n, values in observed.items()}
    if in_triangles.keys() >= set(STRESS_FIELDS):
        in_triangles["cauchy_stress"] = _tensor(*(in_triangles.pop(name) for name in STRESS_FIELDS))
    for name, values in state.fields.items():
        if values.shape == body.cortex.nodes.shape:
            at_nodes[name] = body.spread(body.cortex, values)
        elif name == "growth":
            in_triangles[name] = in_cells(body, values[0])
    in_triangles["layer"] = body.in_cortex.astype(np.int32)
    return at_nodes, in_triangles


def _tensor(xx: Array, yy: Array, xy: Array, zz: Array) -> Array:
    """Return all components, row by row, (e, 9)."""
    none = np.zeros_like(xx)
    return np.stack([xx, xy, none, xy, yy, none, none, none, zz], axis=1)


def arrays_of(file: Path) -> dict[str, Array]:
    """Return what `Frames` wrote: points (n, 3), triangles (e, 6), fields in both, no units.

    Raises CorruptFileError where the file is missing or damaged.
    """
    import meshio

    try:
        mesh = meshio.vtu.read(file)
    except (*DAMAGE, OSError, ElementTree.ParseError, meshio.ReadError) as error:
        raise CorruptFileError(f"{file} cannot be read: {error or type(error).__name__}.") from error
    cells = {name: values[0] for name, values in mesh.cell_data.items()}
    fields = {without_unit(name)[0]: values for name, values in (mesh.point_data | cells).items()}
    return {"points": mesh.points, "triangles": mesh.cells[0].data, **fields}


def in_cells(body: Body, values: Array) -> Array:
    """Return the mean over each triangle (e,) of values at the integration points (q, e)."""
    weights = body.quadrature.weights
    return np.asarray((weights * values).sum(0) / weights.sum(0))


def index(frames: Iterable[tuple[float, str]], comment: str = "") -> bytes:
    """Return the PVD file that lists (time, file) of each frame, with a comment on its second line."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(root, "Collection")
    for time, file in sorted(frames):
        ElementTree.SubElement(collection, "DataSet", timestep=repr(time), group="", part="0", file=file)
    ElementTree.indent(root)
    text: str = ElementTree.tostring(root, encoding="unicode")
    return "".join(f"{line}\n" for line in ('<?xml version="1.0"?>', comment, text) if line).encode()


def entries(content: bytes) -> list[tuple[float, str]]:
    """Return (time, file) of each frame that a PVD file lists."""
    root = ElementTree.fromstring(content)
    return [(float(item.attrib["timestep"]), item.attrib["file"]) for item in root.iter("DataSet")]
