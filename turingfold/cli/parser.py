"""The words of the command line: which commands there are, and what each of them takes."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TypeAlias

from . import arguments
from .kinds import assignment, at_least_one, figure, limits, natural, share, smoothness, task

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

MEASURES = ("gyrification_index", "perimeter", "sulcal_depth", "energy")  # of turingfold sensitivity


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(prog="turingfold", description="Cortical folding in two dimensions.")
    top.add_argument("--version", action="store_true", help="say which version this is")
    commands = top.add_subparsers(metavar="COMMAND")
    common = arguments.common()
    _add_runs(commands, common)
    _add_studies(commands, common)
    _add_cases(commands, common)
    _add_results(commands, common)
    _add_theory(commands, common)
    _add_care(commands, common)
    return top


def _add_runs(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that run scenes and store their results; they share arguments."""
    scenes = [arguments.of_a_case(), arguments.of_results(), arguments.of_earlier_results()]
    kept = [arguments.of_keeping(), arguments.of_answers()]
    every = [*scenes, arguments.of_jobs(), arguments.of_errors()]
    run = commands.add_parser("run", parents=[*every, *kept, common], help="run a case, draw its figure")
    run.add_argument(
        "--accuracy", type=share, metavar="SHARE",
        help="make elements and steps as fine as estimated errors of that size need, such as 3%%",
    )  # fmt: skip
    run.set_defaults(command="run")

    _add_sweep(commands, [*scenes, arguments.of_jobs(), *kept, common])
    accuracy = commands.add_parser(
        "accuracy", parents=[*every, arguments.of_answers(), common], help="error against run time",
        description="Run a case also on finer meshes and with shorter steps; say by how much energy, "
        "gyrification and the pial surface differ from the finest, and what that costs. Table and figure are "
        "in DIR/<case>-accuracy.",
    )  # fmt: skip
    accuracy.add_argument("--meshes", type=natural, default=1, metavar="N", help="refinements, 4 x each (1)")
    accuracy.add_argument("--steps", type=natural, default=1, metavar="N", help="halvings of the steps (1)")
    accuracy.set_defaults(command="accuracy")

    sensitivity = commands.add_parser(
        "sensitivity", parents=[*every, arguments.of_answers(), common], help="which parameters matter",
        description="Run a case; say by how many per cent measures of the end of each scene change with one "
        "per cent of each parameter, from the equilibrium's tangent. Table and figure are in "
        "DIR/<case>-sensitivity.",
    )  # fmt: skip
    sensitivity.add_argument(
        "--to", action="append", default=[], metavar="PARAMETER",
        help="such as TangentialGrowth.cortex or Elastic.gray.mu; may be repeated (all but those that are 0)",
    )  # fmt: skip
    sensitivity.add_argument(
        "--of", action="append", default=[], metavar="MEASURE", choices=MEASURES,
        help=f"{', '.join(MEASURES)}; may be repeated (all)",
    )  # fmt: skip
    sensitivity.set_defaults(command="sensitivity")
    _add_fit(commands, [*scenes, arguments.of_errors(), arguments.of_answers(), common])


def _add_fit(commands: Commands, shared: list[argparse.ArgumentParser]) -> None:
    """Add the command that fits a case to outlines."""
    fit = commands.add_parser(
        "fit", parents=shared, help="which growth, moduli or loads made given outlines",
        description="Find the parameters with which a scene comes closest to outlines, starting from those "
        "of the case, by derivatives of its equilibria. The fitted scene, table, figure and fit.json, which "
        "always holds the best so far, are in DIR/<case>-fit.",
    )  # fmt: skip
    fit.add_argument(
        "--target", action="append", default=[], type=assignment, metavar="TIME=FILE", required=True,
        help="outline (CSV, SVG) or folder of a result at a time of the scene, 1 is its end; may be repeated",
    )  # fmt: skip
    fit.add_argument(
        "--to", action="append", default=[], metavar="PARAMETER", required=True,
        help="such as TangentialGrowth.cortex, or GrowthMap.cortex for all its places; may be repeated",
    )  # fmt: skip
    fit.add_argument(
        "--landmarks", action="append", default=[], type=assignment, metavar="TIME=FILE",
        help="points at a target's time: CSV with name, x_a, y_a (on the undeformed one), x_b, y_b",
    )  # fmt: skip
    fit.add_argument("--unit", metavar="UNIT", help="of the files, such as mm, where they state none (m)")
    fit.add_argument(
        "--bounds", action="append", default=[], type=limits, metavar="[PARAMETER=]LOW:HIGH",
        help="of all parameters, or of one or of all places of a map; may be repeated",
    )  # fmt: skip
    fit.add_argument(
        "--smoothness", type=smoothness, default=0.0, metavar="W",
        help="weight of the second differences of a map, or auto: as much as the noise allows (0)",
    )  # fmt: skip
    fit.add_argument("--noise", type=float, metavar="M", help="standard deviation of the outlines, in m")
    fit.set_defaults(command="fit")


def _add_sweep(commands: Commands, shared: list[argparse.ArgumentParser]) -> None:
    """Add the command that runs a case many times."""
    sweep = commands.add_parser(
        "sweep", parents=shared, help="run a case with other parameters",
        description="Run a case with other values of its parameters: all combinations of the listed ones, "
        "the rows of a table, or samples of ranges. Each point has a folder in DIR/<case>-sweep; the table "
        "sweep.csv and the figure there are of the last sweep alone, while the folders of earlier ones stay.",
    )  # fmt: skip
    sweep.add_argument(
        "--vary", action="append", default=[], type=assignment, metavar="NAME=VALUES",
        help="such as thickness=2e-3,3e-3 or cortex=1.5:1.9:3, or of a part of the scenes, "
        "AxonalTension.ramp=0,0.2; more make all combinations; LOW:HIGH is a range to sample",
    )  # fmt: skip
    sweep.add_argument("--points", type=Path, metavar="TABLE.csv", help="a row for each point")
    sampling = sweep.add_mutually_exclusive_group()
    sampling.add_argument("--lhs", type=at_least_one, metavar="N", help="samples of a Latin hypercube")
    sampling.add_argument("--sobol", type=at_least_one, metavar="N", help="samples of Sobol's sequence")
    sweep.add_argument("--seed", type=natural, default=0, metavar="N", help="of the samples (0)")
    sweep.add_argument(
        "--keep", choices=("summary", "last", "all"), default="last",
        help="of each point: its row of the table, also its last state, or all kept states (last)",
    )  # fmt: skip
    sweep.add_argument(
        "--task", type=task, metavar="I/N", help="the I-th of N parts, for array jobs of a scheduler"
    )
    sweep.add_argument(
        "--dask", default="", metavar="ADDRESS",
        help="run on the Dask cluster whose scheduler is there, or on one of --jobs processes here: local",
    )  # fmt: skip
    sweep.set_defaults(command="sweep")


def _add_studies(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that show what comes of a sweep."""
    printed = arguments.of_answers(steps=False, pictured=False)
    collect = commands.add_parser(
        "collect", parents=[printed, common], help="the table of a study from the records of its points"
    )
    collect.add_argument("study", type=Path, metavar="STUDY", help="folder of the study")
    collect.set_defaults(command="collect")

    plot = commands.add_parser(
        "plot", parents=[printed, common], help="a phase diagram of a study",
        description="Draw a measure of a study's points in colours over two of its columns, as cells where "
        "the points are a grid; without --y, its percentiles along x.",
    )  # fmt: skip
    plot.add_argument("study", type=Path, metavar="STUDY", help="folder of the study")
    plot.add_argument(
        "--x", metavar="NAME", help="a parameter that is varied, or a measure (the only one that is varied)"
    )
    plot.add_argument("--y", metavar="NAME", help="another one")
    plot.add_argument("--colour", metavar="NAME", help="a measure, such as gyrification_index (folds)")
    plot.add_argument("--figure", type=figure, metavar="FILE", help="draw it there (STUDY/plot.png)")
    plot.set_defaults(command="plot")


def _add_cases(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that show, name and copy cases."""
    app = commands.add_parser(
        "app", parents=[common], help="fold brains in the browser",
        description="Serve a page in which the parameters of cases are changed, and what is run is drawn "
        "while it folds. It answers this machine only; with --host or --token visitors must know a token.",
    )  # fmt: skip
    app.add_argument("case", nargs="?", default="figure3", metavar="CASE", help="shown first (figure3)")
    app.add_argument("--port", type=natural, metavar="N", help="of the address (8765, or a free one)")
    app.add_argument("--host", metavar="NAME", help="answer other machines too, such as 0.0.0.0 for all")
    app.add_argument("--token", action="store_true", help="visitors must know a token, which is printed")
    app.add_argument("--no-open", action="store_true", help="open no browser")
    app.add_argument(
        "--folder", type=Path, default=Path("results/app"), metavar="DIR", help="of the runs (results/app)"
    )
    app.set_defaults(command="app")

    shared = [arguments.of_a_case(chosen=False), arguments.of_results(), arguments.of_answers(steps=False)]
    draw = commands.add_parser("draw", parents=[*shared, common], help="draw stored results")
    draw.set_defaults(command="draw")

    names = commands.add_parser("list", parents=[common], help="name cases, their scenes and parameters")
    names.add_argument("cases", nargs="*", metavar="CASE", help="names, files or folders (all)")
    names.add_argument(
        "--parts", action="store_true", help="also the values of the parts of their scenes that --set takes"
    )
    names.set_defaults(command="list")

    new = commands.add_parser("new", parents=[common], help="a case file of your own, from another")
    new.add_argument("file", type=Path, metavar="FILE.py", help="the new file")
    new.add_argument(
        "--from", default="figure3", metavar="CASE", dest="case", help="it is a copy of (figure3)"
    )
    new.set_defaults(command="new")


def _add_results(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that show stored results."""
    printed = arguments.of_answers(steps=False, pictured=False)
    film = commands.add_parser("animate", parents=[printed, common], help="a film of a stored result")
    film.add_argument("result", type=Path, metavar="FOLDER", help="of the results of a scene")
    film.add_argument("--figure", type=Path, metavar="FILE", help=".gif or .mp4 (FOLDER/film.gif)")
    film.add_argument("--field", default="von_mises", metavar="NAME", help="von_mises, pressure or jacobian")
    film.add_argument("--rate", type=at_least_one, default=8, metavar="N", help="states per second (8)")
    _add_parts(film)
    film.set_defaults(command="animate")

    compare = commands.add_parser(
        "compare", parents=[printed, common], help="morphometry of two brains side by side"
    )
    compare.add_argument("a", type=Path, metavar="A", help="folder of a result, or an outline (CSV, SVG)")
    compare.add_argument("b", type=Path, metavar="B", help="another one")
    compare.add_argument(
        "--landmarks", type=Path, metavar="FILE", help="CSV: name, x_a, y_a, x_b, y_b, such as x_a (mm)"
    )
    for own in "ab":
        compare.add_argument(
            f"--curve-{own}", metavar="CURVE",
            help=f"which of several curves of {own.upper()}: its number, or its name in a drawing",
        )  # fmt: skip
    compare.add_argument("--figure", type=figure, metavar="FILE", help="draw one on the other")
    _add_parts(compare)
    compare.set_defaults(command="compare")


def _add_parts(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--with", action="append", default=[], type=Path, dest="parts", metavar="FILE.py",
        help="that defines parts of the scene that are not turingfold's; it is run",
    )  # fmt: skip


def _add_theory(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that say what theory expects of kinetics and cases."""
    printed = arguments.of_answers(steps=False, pictured=False)
    stability = commands.add_parser(
        "stability", parents=[printed, common], help="Turing conditions of a kinetics"
    )
    stability.add_argument("kinetics", metavar="KINETICS", help="such as Schnakenberg")
    stability.add_argument(
        "--param", action="append", default=[], type=assignment, metavar="NAME=VALUE", help="repeatable"
    )
    stability.add_argument("--ratio", type=float, metavar="D", help="d_inhibitor / d_activator")
    stability.add_argument("--half-waves", type=at_least_one, metavar="N", help="on a semi-circle")
    stability.add_argument("--radius", type=float, default=0.0404, metavar="M", help="of it, in m (0.0404)")
    stability.add_argument("--thickness", type=float, default=2.5e-3, metavar="M", help="of cortex (0.0025)")
    stability.add_argument("--figure", type=figure, metavar="FILE", help="draw the dispersion relation")
    stability.set_defaults(command="stability")

    told = arguments.of_answers(pictured=False)
    buckling = commands.add_parser(
        "buckling", parents=[arguments.of_a_case(), told, common], help="critical growth and mode of a case"
    )
    what = buckling.add_mutually_exclusive_group()
    what.add_argument("--figure", type=figure, metavar="FILE", help="draw the modes")
    what.add_argument("--follow", type=Path, metavar="DIR", help="paths through limit points: CSV, figure")
    buckling.set_defaults(command="buckling")

    verify = commands.add_parser(
        "verify", parents=[printed, common], help="problems with known answers",
        description="Solve problems whose answers are known; say by how much each number is off. The exit "
        "status is 3 if one is beyond its tolerance.",
    )  # fmt: skip
    verify.add_argument("problems", nargs="*", metavar="WORD", help="in the names of problems (all)")
    verify.add_argument("--full", action="store_true", help="also orders of convergence and slow problems")
    verify.add_argument("--out", type=Path, metavar="FILE.csv", help="write the table there")
    verify.set_defaults(command="verify")

    atlas = commands.add_parser(
        "atlas", parents=[told, common],
        help="where the program works: random scenes, judged independently",
        description="Run random scenes within a time limit each, judge what is said to be valid by code that "
        "is not the solver's, and draw where they are valid and where they stop. A later call goes on with "
        "the folder's tables. The exit status is 3 for a result that says it is valid and is not, for an "
        "untyped error, and for a scene that hangs.",
    )  # fmt: skip
    for word, count, said in (
        ("mechanics", 300, "folding scenes"), ("patterns", 120, "steady patterns"),
        ("marches", 60, "patterns in time"), ("ordinary", 51, "scenes inside the ranges of use"),
        ("dynamic", 44, "such with inertia or drag"), ("stepping", 34, "such with odd steps and tolerances"),
        ("extreme", 211, "scenes far outside"),
    ):  # fmt: skip
        atlas.add_argument(f"--{word}", type=natural, default=count, metavar="N", help=f"{said} ({count})")
    atlas.add_argument("--seed", type=natural, default=0, metavar="N", help="of what is drawn (0)")
    atlas.add_argument("--seconds", type=at_least_one, default=20, metavar="S", help="for each scene (20)")
    atlas.add_argument("-j", "--jobs", type=at_least_one, default=1, metavar="N", help="scenes at a time")
    atlas.add_argument("--out", type=Path, default=Path("results/atlas"), metavar="DIR", help="results/atlas")
    atlas.set_defaults(command="atlas")


def _add_care(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that look at what is installed, and make the shell know the others."""
    doctor = commands.add_parser(
        "doctor", parents=[common], help="what is installed here, and whether it works",
        description="Say which packages and extras are here, whether they work, which factorisation is used, "
        "and whether results can be written. The exit status is 1 if something is wrong.",
    )  # fmt: skip
    doctor.add_argument("--json", action="store_true", help="as one JSON object")
    doctor.set_defaults(command="doctor")

    completion = commands.add_parser(
        "completion", parents=[common], help="completion of words by Tab, for a shell",
        description='Print what a shell is to run; in ~/.bashrc: eval "$(turingfold completion bash)".',
    )  # fmt: skip
    completion.add_argument("shell", choices=("bash", "zsh", "fish"), help="bash, zsh or fish")
    completion.set_defaults(command="completion")
