"""Which run a file of a result is of: each says it by a digest of the scene that it was made from."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .codec import Arrays
from .document import read_document
from .files import CorruptFileError, read_arrays, read_head
from .plain import as_plain

RUN = "run"  # in scene.json and summary.json
MARK = ".run"  # among arrays, where no field has such a name
# places in which descriptions of one scene may differ, and which a run that goes on may change
FREE = ("versions", "date", "case", "scene.stepping.seconds", RUN)
DIGITS = 16
COMMENT = re.compile(rb"<!-- run ([0-9a-f]+) -->")


class ForeignFileError(CorruptFileError):
    """A stored file of another run than the scene.json beside it."""


@dataclass(frozen=True)
class Identity:
    """The run of a folder; everywhere: whether all its files say so, as those of earlier versions do not."""

    run: str
    everywhere: bool

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Identity:
        """Return the run that the content of a scene.json is of."""
        found = json.dumps(_without_free(as_plain(dict(document))), sort_keys=True)
        return cls(hashlib.sha256(found.encode()).hexdigest()[:DIGITS], RUN in document)

    @classmethod
    def at(cls, path: Path) -> Identity:
        """Return the run of a folder; raises as `read_document`."""
        return cls.of(read_document(path))

    def check(self, file: Path, found: str | None) -> None:
        """Raise ForeignFileError for a file of another run; found: the one that it names, None for none."""
        if found == self.run or (found is None and not self.everywhere):
            return
        other = "names no run" if found is None else f"is of run {found[:DIGITS]}"
        raise ForeignFileError(
            f"{file} does not belong to the scene.json beside it: it {other}, that is of {self.run}. Put "
            "back the file that was here, or go on with resume=True (--resume), which makes it anew if it "
            "can, or run the scene again (overwrite=True, --overwrite)."
        )

    def mark(self, arrays: Arrays) -> Arrays:
        """Return arrays that say of which run they are."""
        return {**arrays, MARK: np.frombuffer(bytes.fromhex(self.run), np.uint8)}

    def read(self, file: Path) -> Arrays:
        """Return marked arrays; raises CorruptFileError where they are damaged or of another run."""
        arrays = read_arrays(file)
        found = arrays.pop(MARK, None)
        self.check(file, None if found is None else found.tobytes().hex())
        return arrays

    @property
    def comment(self) -> str:
        """By which a file of XML says of which run it is."""
        return f"<!-- run {self.run} -->"

    def check_comment(self, file: Path) -> None:
        """Raise ForeignFileError for a file of XML of another run, CorruptFileError where there is none."""
        found = COMMENT.search(read_head(file))
        self.check(file, found[1].decode() if found else None)


def _without_free(value: Any, name: str = "") -> Any:
    """Return a description without the places that are FREE."""
    if not isinstance(value, dict):
        return value
    paths = {key: f"{name}.{key}" if name else key for key in value}
    return {key: _without_free(value[key], path) for key, path in paths.items() if path not in FREE}
