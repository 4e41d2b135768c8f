"""How runs end, and the exit status that follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .status import BAD_INPUT, STOPPED

STATUSES = {  # of runs
    "converged": 0, "invalid": STOPPED, "interrupted": STOPPED, "stopped": STOPPED, "killed": STOPPED,
    "failed": STOPPED, "refused": BAD_INPUT,
}  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """How a run ended, and why.

    status: of its result; or "refused" (bad input), "killed", or "failed" by an error in the program.
    summary: the numbers of its last state, of a point of a study.
    """

    name: str
    status: str
    message: str = ""
    summary: Mapping[str, Any] = field(default_factory=dict)
