"""Tables of loads: CSV files with units in their header."""

from __future__ import annotations

from pathlib import Path

from ..geometry.surface_table import Places as Places
from ..geometry.surface_table import SurfaceTable

NEWTONS = {"N/m": 1.0, "mN/m": 1e-3, "kN/m": 1e3, "µN/m": 1e-6, "uN/m": 1e-6}


def read_loads(file: str | Path) -> tuple[Places, tuple[tuple[float, float], ...]]:
    """Return places (shares of the surface, or points in m) and forces in N/m; see BoundaryLoads.read."""
    table = SurfaceTable.read(file)
    name = Path(file).name
    if table.columns != ("fx", "fy"):
        raise ValueError(
            f"{name}: the columns of values are {', '.join(table.columns)}; they must be fx, fy with their "
            'units, such as "x [mm], y [mm], fx [N/m], fy [N/m]".'
        )
    for column, unit in zip(table.columns, table.units, strict=True):
        if unit not in NEWTONS:
            raise ValueError(
                f"{name}: the column {column} has the unit {unit!r}; it must have one of "
                f"{', '.join(NEWTONS)}."
            )
    scale = [NEWTONS[str(unit)] for unit in table.units]
    return table.places, tuple((fx * scale[0], fy * scale[1]) for fx, fy in table.values)
