"""The command line: turingfold run, sweep, accuracy, app, list, draw, animate, stability, buckling, compare.

Exit status: 0 everything asked for was done; 2 bad input; 3 a solve stopped; 4 reading or writing failed; 130
Ctrl-C. Numpy is imported after the number of threads is set, so nothing heavy is imported at the top.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
import traceback
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO, TypeAlias

from .status import BAD_INPUT, INTERRUPTED, IO_FAILED, STOPPED, complain, run_command

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

FIGURES = (".png", ".pdf", ".svg")
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line asks for and return the exit status."""
    options = parser().parse_args(arguments)
    try:
        return _done(options)
    except KeyboardInterrupt:
        return _failed(options, _interrupted(options), INTERRUPTED)


def _done(options: argparse.Namespace) -> int:
    """Do it, in one thread if not asked otherwise, and say in words what fails."""
    for name in THREADS:  # one thread repeats bit for bit, and the matrices are too sparse to gain from more
        os.environ[name] = str(options.threads)
    logging.getLogger("skfem").setLevel(logging.ERROR)  # it reports copies of arrays
    from ..errors import SolveError
    from ..results.files import OutputError

    with warnings.catch_warnings():
        warnings.simplefilter("default", UserWarning)
        warnings.showwarning = _note
        try:
            return int(options.command(options))
        except SolveError as error:
            return _failed(options, str(error), STOPPED)
        except OSError as error:
            named = isinstance(error, OutputError) or error.filename is None
            words = error.strerror or str(error) if named else f"{error.filename}: {error.strerror}"
            return _failed(options, words, IO_FAILED)
        except ValueError as error:
            return _failed(options, str(error), BAD_INPUT)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(prog="turingfold", description="Cortical folding in two dimensions.")
    commands = top.add_subparsers(required=True, metavar="COMMAND")
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--threads", type=_at_least_one, default=1, metavar="N", help="BLAS threads (1)")
    common.add_argument("--debug", action="store_true", help="show the traceback of an error")
    _add_cases(commands, common)
    _add_results(commands, common)
    _add_theory(commands, common)
    return top


def _add_cases(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that run cases and draw what came of them."""
    stored = argparse.ArgumentParser(add_help=False)
    stored.add_argument("case", type=Path, metavar="CASE.py", help="a file with scenes() and draw()")
    stored.add_argument("--quick", action="store_true", help="the small version, kept apart")
    stored.add_argument("--out", type=Path, metavar="DIR", help="results in DIR/<case>/<scene> (results)")

    running = argparse.ArgumentParser(add_help=False)
    running.add_argument("--only", action="append", metavar="SCENE", help="only this scene; may be repeated")
    there = running.add_mutually_exclusive_group()
    there.add_argument("--resume", action="store_true", help="go on where an earlier run was stopped")
    there.add_argument("--overwrite", action="store_true", help="replace results that are there")
    running.add_argument("-j", "--jobs", type=_at_least_one, default=1, metavar="N", help="scenes at a time")

    run = commands.add_parser("run", parents=[stored, running, common], help="run a case, draw its figure")
    run.set_defaults(command=_run, variation=None)

    sweep = commands.add_parser(
        "sweep", parents=[stored, running, common], help="run a case with other values of its parameters",
        description="Run a case with other values of its parameters. Each combination has a folder in "
        "DIR/<case>-sweep; the table sweep.csv and the figure there are of the last sweep alone, while the "
        "folders of earlier ones stay.",
    )  # fmt: skip
    sweep.add_argument(
        "--vary", action="append", required=True, type=_assignment, metavar="PART.NAME=VALUES",
        help="such as TangentialGrowth.cortex=1.5:1.9:3, AxonalTension=on,off; more make all combinations",
    )  # fmt: skip
    sweep.set_defaults(command=_sweep)

    accuracy = commands.add_parser(
        "accuracy", parents=[stored, running, common], help="error of mesh and steps against run time",
        description="Run a case also on finer meshes and with shorter steps; say by how much energy, "
        "gyrification and the pial surface differ from the finest, and what that costs. Table and figure are "
        "in DIR/<case>-accuracy.",
    )  # fmt: skip
    accuracy.add_argument("--meshes", type=_number, default=1, metavar="N", help="refinements, 4 x each (1)")
    accuracy.add_argument("--steps", type=_number, default=1, metavar="N", help="halvings of the steps (1)")
    accuracy.set_defaults(command=_accuracy)

    app = commands.add_parser("app", parents=[common], help="change a case's parameters in a window")
    app.add_argument("case", type=Path, metavar="CASE.py", help="a file with scenes()")
    app.add_argument("--quick", action="store_true", help="the small version")
    app.add_argument("--only", action="append", metavar="SCENE", help="only this scene; may be repeated")
    app.set_defaults(command=_app)

    draw = commands.add_parser("draw", parents=[stored, common], help="draw a figure from stored results")
    draw.set_defaults(command=_draw, variation=None)

    names = commands.add_parser("list", parents=[common], help="name cases and their scenes")
    names.add_argument("cases", type=Path, nargs="*", default=[Path("cases")], help="files or folders")
    names.set_defaults(command=_list)


def _add_results(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that show stored results."""
    film = commands.add_parser("animate", parents=[common], help="a film of a stored result")
    film.add_argument("result", type=Path, metavar="FOLDER", help="of one scene's result")
    film.add_argument("--figure", type=Path, metavar="FILE", help=".gif or .mp4 (FOLDER/film.gif)")
    film.add_argument("--field", default="von_mises", metavar="NAME", help="von_mises, pressure or jacobian")
    film.add_argument("--rate", type=_at_least_one, default=8, metavar="N", help="states per second (8)")
    film.set_defaults(command=_animate)

    compare = commands.add_parser("compare", parents=[common], help="morphometry of two brains side by side")
    compare.add_argument("a", type=Path, metavar="A", help="folder of a result, or an outline (CSV, SVG)")
    compare.add_argument("b", type=Path, metavar="B", help="another one")
    compare.add_argument("--figure", type=_figure, metavar="FILE", help="draw one on the other")
    compare.set_defaults(command=_compare)


def _add_theory(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the commands that say what theory expects of kinetics and cases."""
    stability = commands.add_parser("stability", parents=[common], help="Turing conditions of a kinetics")
    stability.add_argument("kinetics", metavar="KINETICS", help="such as Schnakenberg")
    stability.add_argument("--param", action="append", default=[], metavar="NAME=VALUE", help="repeatable")
    stability.add_argument("--ratio", type=float, metavar="D", help="d_inhibitor / d_activator")
    stability.add_argument("--half-waves", type=_at_least_one, metavar="N", help="on a semi-circle")
    stability.add_argument("--radius", type=float, default=0.0404, metavar="M", help="of it, in m (0.0404)")
    stability.add_argument("--thickness", type=float, default=2.5e-3, metavar="M", help="of cortex (0.0025)")
    stability.add_argument("--figure", type=_figure, metavar="FILE", help="draw the dispersion relation")
    stability.set_defaults(command=_stability)

    buckling = commands.add_parser("buckling", parents=[common], help="critical growth and mode of a case")
    buckling.add_argument("case", type=Path, metavar="CASE.py", help="a file with scenes()")
    buckling.add_argument("--quick", action="store_true", help="of the small version")
    buckling.add_argument("--only", action="append", metavar="SCENE", help="only this scene; may be repeated")
    what = buckling.add_mutually_exclusive_group()
    what.add_argument("--figure", type=_figure, metavar="FILE", help="draw the modes")
    what.add_argument("--follow", type=Path, metavar="DIR", help="paths through limit points: CSV, figure")
    buckling.set_defaults(command=_buckling)


def _run(options: argparse.Namespace) -> int:
    from .run import run

    return run(options)


def _sweep(options: argparse.Namespace) -> int:
    from .sweep import sweep

    return sweep(options)


def _accuracy(options: argparse.Namespace) -> int:
    from .accuracy import accuracy

    return accuracy(options)


def _app(options: argparse.Namespace) -> int:
    from .app import app

    return app(options)


def _draw(options: argparse.Namespace) -> int:
    from .case import load_case
    from .run import draw

    print(f"figure: {draw(load_case(options.case), options)}")
    return 0


def _animate(options: argparse.Namespace) -> int:
    from ..figures.animation import animate
    from ..results.result import load

    file = options.figure or options.result / "film.gif"
    print(f"film: {animate(load(options.result), file, field=options.field, rate=options.rate)}")
    return 0


def _list(options: argparse.Namespace) -> int:
    from .case import find_cases, load_case

    status = 0
    for path in find_cases(options.cases):
        try:
            case = load_case(path)
            names = list(case.scenes(quick=True))
        except ValueError as error:  # the other cases are listed all the same
            status = _failed(options, str(error), BAD_INPUT)
            continue
        print(f"{path}: {case.title}")
        for name in names:
            print(f"    {name}")
    return status


def _stability(options: argparse.Namespace) -> int:
    from .tools import stability

    print(stability(options))
    return 0


def _buckling(options: argparse.Namespace) -> int:
    from .buckling import report
    from .follow import follow

    print(report(options) if options.follow is None else follow(options))
    return 0


def _compare(options: argparse.Namespace) -> int:
    from .tools import compare

    print(compare(options.a, options.b, options.figure))
    return 0


def _at_least_one(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number of at least 1")
    return int(text)


def _number(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number of at least 0")
    return int(text)


def _assignment(text: str) -> tuple[str, str]:
    name, sign, values = text.partition("=")
    if not (name and sign and values):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form PART.NAME=VALUES")
    return name, values


def _figure(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in FIGURES:
        raise argparse.ArgumentTypeError(f"{text!r} must end with {', '.join(FIGURES[:-1])} or {FIGURES[-1]}")
    return path


def _interrupted(options: argparse.Namespace) -> str:
    if not (hasattr(options, "resume") and hasattr(options, "variation")):  # or before it began
        return "stopped."
    jobs = ["--jobs", str(options.jobs)] if options.jobs > 1 else []
    again = run_command(options, options.only or [], *jobs, "--resume")
    return f"stopped; nothing before the last checkpoint is lost. Go on with: {again}"


def _failed(options: argparse.Namespace, message: str, status: int) -> int:
    if options.debug:
        traceback.print_exc()
    complain(message)
    return status


def _note(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
    line: str | None = None,
) -> None:  # fmt: skip
    print(f"turingfold: note: {message}", file=sys.stderr)
