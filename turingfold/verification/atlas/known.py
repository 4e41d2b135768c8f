"""Which cells of the atlas are known to have a solution, by an argument that runs none of them.

On a mesh, equilibria are the stationary points of an energy of finitely many unknowns. If that is continuous
where it is finite, goes to infinity at the edge of that set and far away, and is finite somewhere, it has a
minimum (Weierstrass; in the continuum Ball 1977, Arch. Ration. Mech. Anal. 63, 337, with contact Ciarlet and
Nečas 1987, Arch. Ration. Mech. Anal. 97, 171). Of the terms of the atlas:

- the solid: as I₁ >= 1/g_z², μ/2 I₁ J*^(-2/3) goes to infinity where J* -> 0; with κ/2 (J* - 1)² it grows at
  least as |F*|^(3/2), since a/b + b³ >= 1.75 a^(3/4) for a = |F*|² and b = J*^(2/3);
- contact: its barriers are not negative, and infinite where walls meet or triangles turn over;
- dead loads are linear, and grow more slowly than the solid; the energy of a line tension, ∫ γ |∂x/∂s| ds, is
  not negative; on a free body both balance;
- inertia and drag: an implicit step adds a convex quadratic function.

The undeformed body has finite energy, or else it is refused. That solution need not be near the last one,
nor valid between the points where the energy looks. Not known are: mixed elements, whose equilibria are
saddles of displacement and pressure; growth in response to stress, which earlier equilibria choose;
stiffness damping, ends of midpoint steps, and bounds on the error of a step; steady patterns beyond their
onset.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...stepping import MIDPOINT
from ...terms.elastic.term import NEARLY_INCOMPRESSIBLE
from .families import FAMILIES
from .run import REFUSED, VALID, Row


def has_solution(kind: str, cell: Mapping[str, Any]) -> bool:
    """Return whether every step of a cell, as drawn or as read from a table, is known to have an end."""
    if kind != "mechanics" and kind not in FAMILIES:
        return False
    mixed = cell["element"] == "mixed" or float(cell["poisson"]) >= NEARLY_INCOMPRESSIBLE - 1e-12
    remembers = cell.get("law") == "stress"
    other = cell.get("moving") == "damped" or cell.get("scheme") == MIDPOINT
    bounded = float(cell.get("off") or 0.0) > 0
    return not (mixed or remembers or other or bounded)


def reached(kind: str, rows: Sequence[Row]) -> tuple[int, int]:
    """Return how many cells of a kind that have a solution for certain reached it, and how many have one."""
    known = [row for row in rows if row["outcome"] != REFUSED and has_solution(kind, row)]
    return sum(row["outcome"] == VALID for row in known), len(known)


def told(counts: tuple[int, int]) -> str:
    """Return such a count as words, "" where no cell is known to have a solution."""
    found, known = counts
    return f"{found} of {known} with a known solution reach it ({100 * found / known:.0f} %)" if known else ""
