"""Stages of growth: the deformed body becomes the stress-free start of the next stage."""

from __future__ import annotations

from dataclasses import replace

from ..checks import instance
from ..errors import MissingFieldError
from ..geometry.body import Body
from ..state import State


def stress_free_restart(body: Body, state: State) -> Body:
    """Return the deformed body as a new one, free of stress: what a stage of growth hands to the next.

    Elements keep their layer and the cortex its nominal thickness; depth and tangents follow the new shape.
    Raises MissingFieldError without a displacement, ValueError for what is no body or state and if a deformed
    element is no valid element of a mesh.
    """
    instance("body", body, Body, "result.scene.body")
    instance("state", state, State, "result.last")
    if "displacement" not in state:
        raise MissingFieldError(
            f"state has no field 'displacement' (it has: {', '.join(sorted(state.fields)) or 'none'}); give "
            "the state of a result, such as result.last."
        )
    return replace(body, mesh=replace(body.mesh, doflocs=body.nodes + state["displacement"]))
