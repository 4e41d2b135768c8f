"""Notes on scenes before they run: what was changed of their outlines, and of the case by --quick."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from typing import Any

from ..models.declared import QUICK, as_text
from ..scene import Scene
from .case import Case


def note_made(case: Case, given: Mapping[str, Any], scenes: Mapping[str, Scene], *, quick: bool) -> None:
    """Warn of what a user does not expect of scenes made with some parameters given."""
    words = [quick_words(case, given)] if quick else []
    for text in filter(None, [*words, *outline_words(scenes)]):
        warnings.warn(text, stacklevel=2)


def quick_words(case: Case, given: Mapping[str, Any]) -> str:
    """Return which parameters that are not given the quick version changes, or ""."""
    changed = [
        f"{name}={as_text(value)} for {as_text(case.parameters[name].default)}"
        for name, value in getattr(case.module.scenes, QUICK, {}).items()
        if name not in given and value != case.parameters[name].default
    ]
    return f"--quick takes {', '.join(changed)}" if changed else ""


def outline_words(scenes: Mapping[str, Scene]) -> Iterator[str]:
    """Yield what is to be said of the outlines, once for all scenes of which it is the same."""
    told: dict[tuple[str, ...], list[str]] = {}
    for name, scene in scenes.items():
        if scene.body.changes is not None and (remarks := scene.body.changes.remarks()):
            told.setdefault(remarks, []).append(name)
    for remarks, names in told.items():
        of = "" if len(names) == len(scenes) else f" of {', '.join(names)}"
        yield f"outline{of}: {'; '.join(remarks)}"
