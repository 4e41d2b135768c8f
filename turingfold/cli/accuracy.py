"""turingfold accuracy: what a case's mesh and steps leave as error, against run time."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from ..results.result import Result, load
from ..scene import Scene
from ..studies.accuracy import Difference, compared, draw, told, trials
from .case import folder_name, load_case
from .run import results_of, run_case, write_table

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


def of_scenes(results: Mapping[str, Result]) -> dict[str, dict[str, list[Difference]]]:
    """Return the differences by scene, from results by the names that `Accuracy.scenes` gives."""
    found: dict[str, dict[str, Result]] = {}
    for name, result in results.items():
        scene, _, own = name.rpartition(", ")
        found.setdefault(scene, {})[own] = result
    return {scene: compared(own) for scene, own in found.items()}


def accuracy(options: argparse.Namespace) -> int:
    """Run the trials of a case's scenes, say how much they differ, and write that as table and figure."""
    options.variation = Accuracy(options.meshes, options.steps)
    case = load_case(options.case, options.variation)
    status, base = run_case(case, options), results_of(case, options)
    if status:  # table and figure of an earlier run would be of other results
        for stale in (base / TABLE, base / f"{case.name}.png"):
            stale.unlink(missing_ok=True)
        return status
    names = case.scenes(quick=options.quick, only=options.only or ())
    scenes = of_scenes({name: load(base / folder_name(name), known=case.known) for name in names})
    rows = []
    for scene, series in scenes.items():
        print(f"{scene}:")
        for line in told(series):
            print(line)
        rows += [(scene, kind, *asdict(row).values()) for kind, runs in series.items() for row in runs]
    write_table(base / TABLE, ("scene", "series", *(field.name for field in fields(Difference))), rows)
    return status
