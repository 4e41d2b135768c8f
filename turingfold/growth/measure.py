"""The one number that says how far a state has grown."""

from __future__ import annotations

from ..state import State


def largest_growth(state: State) -> float:
    """Return the largest tangential growth factor, or 1 where nothing grows."""
    return float(state["growth"][0].max()) if "growth" in state else 1.0
