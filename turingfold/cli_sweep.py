"""turingfold sweep: a case's scenes with other values of some parameters, side by side."""

from __future__ import annotations

import argparse
import csv
import io

from .cli_case import folder_name, load_case
from .cli_run import results_of, run
from .output.files import write_whole
from .results import load

TABLE = "sweep.csv"
NUMBERS = (
    "growth", "folds", "gyrification_index", "sulcal_depth", "registration", "energy", "min_jacobian",
    "self_intersections", "steps", "newton_iterations", "seconds",
)  # fmt: skip


def sweep(options: argparse.Namespace) -> int:
    """Run the variations of a case's scenes, draw them side by side, and write their numbers in one table.

    Table and figure are of this sweep alone: results of earlier ones stay in their folders, but are not read.
    """
    status = run(options)
    case = load_case(options.case, options.vary)
    base = results_of(case, options)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("scene", *NUMBERS))
    for name in case.scenes(quick=options.quick, only=options.only or ()):
        folder = base / folder_name(name)
        if (folder / "states").is_dir():
            summary = load(folder, known=case.known).summary()
            table.writerow((name, *(summary[number] for number in NUMBERS)))  # None is written as nothing
    write_whole(base / TABLE, text.getvalue().encode())
    print(f"table: {base / TABLE}")
    return status
