"""turingfold accuracy: what a case's mesh and steps leave as error, against run time."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from .accuracy import Trial, compared, draw, told, trials
from .cli_case import folder_name, load_case
from .cli_run import results_of, run
from .output.files import write_whole
from .results import Result, load
from .scene import Scene

TABLE = "accuracy.csv"


@dataclass(frozen=True)
class Accuracy:
    """Scenes as they are, on finer meshes, and with shorter steps."""

    meshes: int
    steps: int
    command = "accuracy"

    @property
    def arguments(self) -> tuple[str, ...]:
        """The numbers of refinements, as on the command line."""
        return ("--meshes", str(self.meshes), "--steps", str(self.steps))

    def scenes(self, scenes: dict[str, Scene]) -> dict[str, Scene]:
        """Return the trials of each scene."""
        return {
            f"{name}, {own}": trial
            for name, scene in scenes.items()
            for own, trial in trials(scene, meshes=self.meshes, steps=self.steps).items()
        }

    def draw(self, results: dict[str, Result], figure: Any) -> None:
        """Draw differences against run time."""
        draw(figure, of_scenes(results))


def of_scenes(results: Mapping[str, Result]) -> dict[str, dict[str, list[Trial]]]:
    """Return the trials of each scene, from results by the names that `Accuracy.scenes` gives."""
    found: dict[str, dict[str, Result]] = {}
    for name, result in results.items():
        scene, _, own = name.rpartition(", ")
        found.setdefault(scene, {})[own] = result
    return {scene: compared(own) for scene, own in found.items()}


def accuracy(options: argparse.Namespace) -> int:
    """Run the trials of a case's scenes, say how much they differ, and write that as table and figure."""
    options.variation = Accuracy(options.meshes, options.steps)
    status = run(options)
    if status:
        return status
    case = load_case(options.case, options.variation)
    base = results_of(case, options)
    names = case.scenes(quick=options.quick, only=options.only or ())
    scenes = of_scenes({name: load(base / folder_name(name), known=case.known) for name in names})
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("scene", "series", *(field.name for field in fields(Trial))))
    for scene, series in scenes.items():
        print(f"{scene}:")
        for line in told(series):
            print(line)
        for kind, rows in series.items():
            table.writerows((scene, kind, *asdict(row).values()) for row in rows)
    write_whole(base / TABLE, text.getvalue().encode())
    print(f"table: {base / TABLE}")
    return status
