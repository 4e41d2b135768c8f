"""Who called: warnings name the line outside of the package that led to them."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

INSIDE = (str(Path(__file__).parents[1]) + os.sep, contextlib.__file__)  # the latter runs what `with` enters


def level_outside() -> int:
    """Return the `stacklevel` at which a warning of the function that asks names the first line outside.

    That of the outermost line where all are inside.
    """
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(INSIDE):
        level, frame = level + 1, frame.f_back
    return level
