"""How a run stands that has reached its end: whether states are those of a body, and the last a minimum."""

from __future__ import annotations

from collections.abc import Sequence

Row = dict[str, float]

# of states that are none of a body: column of the history, what it counts, and what to try
FAULTS = (
    ("inverted_elements", "triangles that are turned over somewhere", "smaller elements or less growth"),
    ("self_intersections", "a boundary that crosses itself", "SelfContact among the terms, smaller elements"),
)


def ended(history: Sequence[Row], *, moves: bool) -> tuple[str, str]:
    """Return status and message of a run that has reached its end; moves: whether terms resist motion."""
    faults, remedies = [], []
    for column, fault, remedy in FAULTS:
        if found := [row for row in history if row[column] > 0]:
            faults.append(
                f"{len(found)} of {len(history)} states, the first that of t = {found[0]['time']:.6g}, have "
                f"{fault}"
            )
            remedies.append(remedy)
    saddle = _saddle(int(history[-1].get("negative_pivots", 0)) if history else 0, moves)
    if not faults:
        return "converged", saddle
    told = f"The end was reached, but {', and '.join(faults)}; try {', and '.join(remedies)}."
    return "invalid", f"{told} {saddle}".rstrip()


def _saddle(directions: int, moves: bool) -> str:
    """Return what to say of a last state whose energy falls along some directions; nothing of a minimum."""
    if not directions:
        return ""
    energy = "the step's incremental potential" if moves else "the energy"
    falls = "1 direction" if directions == 1 else f"{directions} directions"
    return (
        f"The last state is no minimum of {energy}: it has {falls} in which that falls, so "
        "that a disturbance would lead away from it. A little later (a larger until=) it may have been left."
    )
