"""Whether a browser can be opened on this machine."""

from __future__ import annotations

import os
import sys


def has_display() -> bool:
    """Return whether windows can be shown: on Linux only where a display is named."""
    return sys.platform != "linux" or bool({"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ))
