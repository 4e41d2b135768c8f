"""Parameters that are given and change nothing: a strength of a tension that is off."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping
from typing import Any

from ..errors import SolveError
from ..models.declared import as_text
from ..results.document import stored
from .case import Case


def idle_words(case: Case, given: Mapping[str, Any], others: Mapping[str, Any], only: Collection[str]) -> str:
    """Return which of the values given change nothing in the scenes `only` (all, if empty), or "".

    others: another value by name, for each parameter to be asked. The quick version answers, at once.
    """
    if not others:
        return ""
    made = _scenes(case, given, only)
    if made is None:
        return ""
    found = [name for name, value in others.items() if _scenes(case, {**given, name: value}, only) == made]
    if not found:
        return ""
    words = ", ".join(f"{name}={as_text(given[name])}" for name in found)
    verb = "changes" if len(found) == 1 else "change"
    return f"{words} {verb} nothing with the other parameters as they are (turingfold list {case.name})"


def unusual(case: Case, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the default of each value given that differs from it; "auto" is no value to compare with."""
    usual = {name: case.parameters[name].default for name in given}
    return {name: value for name, value in usual.items() if value is not None and value != given[name]}


def _scenes(case: Case, given: Mapping[str, Any], only: Collection[str]) -> dict[str, Any] | None:
    """Return what would be stored of the scenes of the quick version; None where there can be none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            made = case.scenes(given, quick=True)
        except (ValueError, SolveError):
            return None
    return {name: stored(scene)[0] for name, scene in made.items() if not only or name in only}
