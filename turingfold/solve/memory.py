"""Whether a factorisation fits into the memory that is left: the solvers end badly where it does not.

Short of memory, the BLAS that CHOLMOD calls ends the whole program, and SuperLU tries for minutes.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

from ..errors import OutOfMemoryError
from ..memory import address_space_left, memory_left

SPARE = 1.2  # times what was measured


class Need(NamedTuple):
    """Bytes that were taken by one factorisation of half discs, 11 000 to 98 000 unknowns (VmSize, VmRSS).

    once: when the library is loaded.  reserved, touched: per entry of the lower triangle.
    """

    library: str
    once: float
    reserved: float
    touched: float


CHOLMOD = Need("cvxopt", 2.0e8, 170.0, 150.0)
SUPERLU = Need("scipy", 0.0, 3100.0, 500.0)  # it reserves for many more entries than come


def check_memory(unknowns: int, entries: int, need: Need) -> None:
    """Raise OutOfMemoryError where a factorisation does not fit; where memory cannot be told, do nothing."""
    once = 0.0 if need.library in sys.modules else need.once
    for kind, per_entry, left in (
        ("address space (ulimit -v)", need.reserved, address_space_left()),
        ("memory", need.touched, memory_left()),
    ):
        wanted = SPARE * (once + per_entry * entries)
        if wanted > left:
            raise OutOfMemoryError(
                f"the factorisation of {unknowns} unknowns needs about {wanted / 1e6:.0f} MB of {kind}, and "
                f"{max(left, 0.0) / 1e6:.0f} MB are left; use larger elements, or a machine with more memory"
            )
