"""Values as JSON has them."""

from __future__ import annotations

import math
from typing import Any


def as_plain(value: Any) -> Any:
    """Return numbers, texts, lists and tables as JSON has them; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {key: as_plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_plain(item) for item in value]
    if hasattr(value, "dtype"):  # a number of numpy, which need not be imported for it
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
