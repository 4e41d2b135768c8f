"""What a case computes of its results, by a function computed(results): arrays by name, stored with them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..results.files import arrays_content, read_arrays, write_whole
from ..results.result import Result
from .case import Case, explained

FILE = "computed.npz"
SOURCE = "source"  # of the case, by hash: another text may compute something else


def compute(case: Case, results: Mapping[str, Result], base: Path, *, keep: bool) -> None:
    """Store what a case computes of its results, if anything; `keep`: not again for the same case."""
    if case.computed is None:
        return
    file, source = base / FILE, np.array(case.sha256)
    if keep and file.is_file() and read_arrays(file).get(SOURCE) == source:
        return
    with explained(case.path):
        found: Any = case.computed(dict(results))
        if not isinstance(found, dict) or SOURCE in found:
            raise ValueError(f"computed(results) must return a dict of arrays by name, none {SOURCE!r}.")
        arrays = {name: np.asarray(values) for name, values in found.items()}
        for name, values in arrays.items():
            if values.dtype.kind not in "biufU":
                raise ValueError(f"computed(results): {name!r} is no array of numbers or of texts.")
    write_whole(file, arrays_content(arrays | {SOURCE: source}))


def read_computed(case: Case, base: Path) -> dict[str, Array]:
    """Return what `compute` stored; raises ValueError where that is not there."""
    if not (base / FILE).is_file():
        raise ValueError(f"{base} lacks what {case.name} computes of its results; run the case first.")
    return {name: values for name, values in read_arrays(base / FILE).items() if name != SOURCE}
