"""Frames for ParaView: one VTU file per state through meshio, and the PVD index of the series."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..state import State
from .files import DAMAGE, CorruptFileError

if TYPE_CHECKING:
    import meshio


def frame(body: Body, state: State, observed: Mapping[str, Array]) -> bytes:
    """Return a VTU file of `mesh_of`; Warp By Vector shows the deformed shape."""
    with tempfile.TemporaryDirectory() as folder:  # meshio writes files only
        file = Path(folder) / "frame.vtu"
        mesh_of(body, state, observed).write(file, binary=True)
        return file.read_bytes()


def mesh_of(body: Body, state: State, observed: Mapping[str, Array]) -> meshio.Mesh:
    """Return a mesh of quadratic triangles, undeformed, with the fields of a state.

    At nodes: displacement (m, with a third component 0) and the morphogens, NaN outside the cortex. In
    triangles, averaged over the area: observed (q, e), such as von_mises (Pa), the growth factor along the
    tangent, and layer (1 gray, 0 white).
    """
    import meshio

    points = np.zeros((body.nodes.shape[1], 3))
    points[:, :2] = body.nodes.T
    at_nodes: dict[str, Array] = {"displacement": np.zeros_like(points)}
    at_nodes["displacement"][:, :2] = state["displacement"].T
    in_triangles = {name: [in_cells(body, values)] for name, values in observed.items()}
    for name, values in state.fields.items():
        if values.shape == body.cortex.nodes.shape:
            at_nodes[name] = body.spread(body.cortex, values)
        elif name == "growth":
            in_triangles[name] = [in_cells(body, values[0])]
    in_triangles["layer"] = [body.in_cortex.astype(np.int32)]
    triangles = [("triangle6", body.triangles.T)]
    return meshio.Mesh(points, triangles, point_data=at_nodes, cell_data=in_triangles)


def arrays_of(file: Path) -> dict[str, Array]:
    """Return what `frame` wrote: points (n, 3), triangles (e, 6), and the fields at nodes and in triangles.

    Raises CorruptFileError where the file is missing or damaged.
    """
    import meshio

    try:
        mesh = meshio.vtu.read(file)
    except (*DAMAGE, OSError, ElementTree.ParseError, meshio.ReadError) as error:
        raise CorruptFileError(f"{file} cannot be read: {error or type(error).__name__}.") from error
    cells = {name: values[0] for name, values in mesh.cell_data.items()}
    return {"points": mesh.points, "triangles": mesh.cells[0].data, **mesh.point_data, **cells}


def in_cells(body: Body, values: Array) -> Array:
    """Return the mean over each triangle (e,) of values at the integration points (q, e)."""
    weights = body.quadrature.weights
    return np.asarray((weights * values).sum(0) / weights.sum(0))


def index(frames: Iterable[tuple[float, str]]) -> bytes:
    """Return the PVD file that lists (time, file) of each frame."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(root, "Collection")
    for time, file in sorted(frames):
        ElementTree.SubElement(collection, "DataSet", timestep=repr(time), group="", part="0", file=file)
    ElementTree.indent(root)
    text: str = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0"?>\n{text}\n'.encode()


def entries(content: bytes) -> list[tuple[float, str]]:
    """Return (time, file) of each frame that a PVD file lists."""
    root = ElementTree.fromstring(content)
    return [(float(item.attrib["timestep"]), item.attrib["file"]) for item in root.iter("DataSet")]
