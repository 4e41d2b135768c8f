"""turingfold sweep: a case's scenes with other values of some parameters, side by side."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any

from ..results.result import Result, load
from ..scene import Scene
from ..studies.sweep import read_values, value_of, varied
from .case import folder_name, load_case
from .run import results_of, run_case, write_table

TABLE = "sweep.csv"
NUMBERS = (
    "growth", "folds", "gyrification_index", "sulcal_depth", "registration", "energy", "min_jacobian",
    "self_intersections", "steps", "newton_iterations", "seconds",
)  # fmt: skip
SIDE_BY_SIDE = 4  # variations in a row


@dataclass(frozen=True)
class Sweep:
    """Scenes with other values of parameters, which are given as text."""

    vary: tuple[tuple[str, str], ...]
    command = "sweep"

    @property
    def arguments(self) -> tuple[str, ...]:
        """The values, as on the command line."""
        return tuple(word for name, values in self.vary for word in ("--vary", f"{name}={values}"))

    def scenes(self, scenes: dict[str, Scene]) -> dict[str, Scene]:
        """Return each scene with each combination of values."""
        parameters = [parameter for parameter, _ in self.vary]
        for parameter in parameters:
            if parameters.count(parameter) > 1:
                raise ValueError(f"{parameter} is varied twice; list all its values in one --vary.")
        found = {}
        for name, scene in scenes.items():
            values = {parameter: read_values(text, scene, parameter) for parameter, text in self.vary}
            for own, changed in varied(scene, values).items():
                found[f"{name}, {own}" if len(scenes) > 1 else own] = changed
        return found

    def draw(self, results: dict[str, Result], figure: Any) -> None:
        """Draw the last state of each result, with its numbers."""
        from ..figures.grids import grid

        columns = min(len(results), SIDE_BY_SIDE)
        grid(figure, {name: (result, -1) for name, result in results.items()}, columns=columns)


def sweep(options: argparse.Namespace) -> int:
    """Run the variations of a case's scenes, draw them side by side, and write their numbers in one table.

    Table and figure are of this sweep alone: results of earlier ones stay in their folders, but are not read.
    """
    options.variation = Sweep(tuple(options.vary))
    case = load_case(options.case, options.variation)
    status, base = run_case(case, options), results_of(case, options)
    rows, parameters = [], [parameter for parameter, _ in options.vary]
    for name, scene in case.scenes(quick=options.quick, only=options.only or ()).items():
        folder = base / folder_name(name)
        if (folder / "states").is_dir():
            summary = load(folder, known=case.known).summary()
            values = [value_of(scene, parameter) for parameter in parameters]
            rows.append((name, *values, *(summary[number] for number in NUMBERS)))
    write_table(base / TABLE, ("scene", *parameters, *NUMBERS), rows)
    return status
