"""This folder shares its name with the function `turingfold.sensitivity`.

Once anything of the folder was imported, Python finds it in the place of the function: so it can be called.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class CallableFolder(ModuleType):
    """The folder, which does what the function does."""

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return the sensitivities of a result; see `forward.sensitivity`."""
        from .forward import sensitivity

        return sensitivity(*given, **named)


sys.modules[__name__.rpartition(".")[0]].__class__ = CallableFolder
