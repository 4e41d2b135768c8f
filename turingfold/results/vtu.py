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
from ..parts import STRESS_FIELDS
from ..scene import Scene
from ..state import State
from .files import DAMAGE, CorruptFileError
from .units import stored_unit, with_unit, without_unit

if TYPE_CHECKING:
    import meshio

GRID = b"<UnstructuredGrid>"


def frame(scene: Scene, state: State, observed: Mapping[str, Array]) -> bytes:
    """Return a VTU file of `mesh_of`, its fields with their units, and the time.

    Warp By Vector shows the deformed shape.
    """
    mesh = mesh_of(scene.body, state, observed)
    mesh.point_data = {_named(scene, name): values for name, values in mesh.point_data.items()}
    mesh.cell_data = {_named(scene, name): values for name, values in mesh.cell_data.items()}
    with tempfile.TemporaryDirectory() as folder:  # meshio writes files only
        file = Path(folder) / "frame.vtu"
        mesh.write(file, binary=True)
        return file.read_bytes().replace(GRID, GRID + _time(state.time), 1)


def _time(value: float) -> bytes:
    """Return the field by which ParaView knows the time of a file; meshio writes none."""
    array = (
        f'<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{value!r}</DataArray>'
    )
    return f"<FieldData>{array}</FieldData>".encode()


def _named(scene: Scene, field: str) -> str:
    return with_unit(field, stored_unit(scene, field))


def mesh_of(body: Body, state: State, observed: Mapping[str, Array]) -> meshio.Mesh:
    """Return a mesh of quadratic triangles, undeformed, with the fields of a state.

    At nodes: displacement (m, with a third component 0) and the morphogens, NaN outside the cortex. In
    triangles, averaged over the area: observed (q, e), such as von_mises (Pa), the growth factor along the
    tangent, layer (1 gray, 0 white), and of a solid its Cauchy stress (Pa), all nine components.
    """
    import meshio

    points = np.zeros((body.nodes.shape[1], 3))
    points[:, :2] = body.nodes.T
    at_nodes: dict[str, Array] = {"displacement": np.zeros_like(points)}
    at_nodes["displacement"][:, :2] = state["displacement"].T
    in_triangles = {name: [in_cells(body, values)] for name, values in observed.items()}
    if in_triangles.keys() >= set(STRESS_FIELDS):
        in_triangles["cauchy_stress"] = [_tensor(*(in_triangles.pop(name)[0] for name in STRESS_FIELDS))]
    for name, values in state.fields.items():
        if values.shape == body.cortex.nodes.shape:
            at_nodes[name] = body.spread(body.cortex, values)
        elif name == "growth":
            in_triangles[name] = [in_cells(body, values[0])]
    in_triangles["layer"] = [body.in_cortex.astype(np.int32)]
    triangles = [("triangle6", body.triangles.T)]
    return meshio.Mesh(points, triangles, point_data=at_nodes, cell_data=in_triangles)


def _tensor(xx: Array, yy: Array, xy: Array, zz: Array) -> Array:
    """Return all components, row by row, (e, 9)."""
    none = np.zeros_like(xx)
    return np.stack([xx, xy, none, xy, yy, none, none, none, zz], axis=1)


def arrays_of(file: Path) -> dict[str, Array]:
    """Return what `frame` wrote: points (n, 3), triangles (e, 6), fields at nodes and in triangles, no units.

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
