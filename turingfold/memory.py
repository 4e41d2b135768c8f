"""How much memory is left, and whether a mesh is solved in it; asked before the mesh is made."""

from __future__ import annotations

from importlib.util import find_spec
from math import log2
from pathlib import Path

STATM, MEMINFO = Path("/proc/self/statm"), Path("/proc/meminfo")
MOST = 1e6  # triangles of a mesh
BYTES = 8.6e3  # per triangle, of a factorisation: 48 entries, each of 1.2 x 150 bytes (solve/memory.py)
MEASURED = 1e5  # unknowns up to which that was measured; the factors grow as n log n


def refuse_too_many(triangles: float, size: float, question: str) -> None:
    """Raise ValueError where a mesh has more triangles than are made, or than memory is left for.

    size: of the elements that is asked for, m.  question: what may have been meant.
    """
    unknowns = 4 * triangles
    need = BYTES * triangles * max(1.0, log2(max(unknowns, 1.0)) / log2(MEASURED))
    left = max(0.0, min(memory_left(), address_space_left()))
    if triangles <= MOST and need <= left:
        return
    bound = f"at most {MOST:.0e} are made" if need <= left else f"{left / 1e9:.2g} GB are left"
    raise ValueError(
        f"size={size:g} m would make about {triangles:.2g} triangles, for which a solve needs about "
        f"{need / 1e9:.2g} GB of memory; {bound}. Use larger elements; or {question}"
    )


def address_space_left() -> float:
    """Return how many bytes this process may still reserve; infinite without a limit."""
    if find_spec("resource") is None or not STATM.exists():
        return float("inf")
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return float("inf")
    return limit - resource.getpagesize() * float(STATM.read_text().split()[0])


def memory_left() -> float:
    """Return how many bytes of memory the system can still give, in which no swap is; infinite if unknown."""
    if not MEMINFO.exists():
        return float("inf")
    rows = dict(line.split(":", 1) for line in MEMINFO.read_text().splitlines() if ":" in line)
    return 1024 * float(rows["MemAvailable"].split()[0]) if "MemAvailable" in rows else float("inf")
