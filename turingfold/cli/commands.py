"""The commands by name: each makes a frozen request of the options, and hands that on.

What a command needs is imported when it runs.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import replace

from .request import Request, Running, Telling
from .status import Answer, say


def _request(options: argparse.Namespace, *command: str) -> Request:
    out = getattr(options, "out", None)
    only, assigned = (tuple(getattr(options, name, None) or ()) for name in ("only", "assigned"))
    return Request(options.case, options.quick, out, only, assigned, command)


def _pictured(options: argparse.Namespace, *command: str) -> Request:
    """Return the request of a command whose figure is that of the case."""
    return replace(_request(options, *command), figure=options.figure)


def _running(options: argparse.Namespace) -> Running:
    """Return how scenes are run: by the options that the command has, and as usual by the others."""
    names = ("resume", "overwrite", "jobs", "errors", "max_seconds", "frames", "vtu")
    given = {name: getattr(options, name) for name in names if hasattr(options, name)}
    return Running(**given, telling=_telling(options))


def _telling(options: argparse.Namespace) -> Telling:
    quiet, verbose = (getattr(options, name, False) for name in ("quiet", "verbose"))
    return Telling.NOTHING if quiet else Telling.STEPS if verbose else Telling.OVERALL


def _run(options: argparse.Namespace) -> Answer:
    if options.accuracy is not None:
        from .precision import run_to

        return run_to(options.accuracy, _pictured(options, "run"), _running(options))
    from .run import run

    return run(_pictured(options, "run"), _running(options))


def _sweep(options: argparse.Namespace) -> Answer:
    from .design import Design
    from .sweep import Asked, sweep

    method = "lhs" if options.lhs else "sobol" if options.sobol else ""
    samples = options.lhs or options.sobol or 0
    design = Design(tuple(options.vary), options.points, method, samples, options.seed)
    asked = Asked(options.keep, options.task, options.dask)
    request = _pictured(options, "sweep", *design.words(), *asked.words())
    return sweep(request, design, _running(options), asked)


def _collect(options: argparse.Namespace) -> Answer:
    from .sweep import collect

    return collect(options.study)


def _plot(options: argparse.Namespace) -> Answer:
    from .plot import plot

    return plot(options.study, options.x, options.y, options.colour, options.figure)


def _accuracy(options: argparse.Namespace) -> Answer:
    from .accuracy import accuracy

    own = ("--meshes", str(options.meshes), "--steps", str(options.steps))
    asked = _pictured(options, "accuracy", *own)
    return accuracy(asked, _running(options), meshes=options.meshes, steps=options.steps)


def _sensitivity(options: argparse.Namespace) -> Answer:
    from .sensitivity import Asked, sensitivities

    own = [word for name in options.to for word in ("--to", name)]
    own += [word for name in options.of for word in ("--of", name)]
    asked = Asked(tuple(options.to), tuple(options.of))
    return sensitivities(_pictured(options, "sensitivity", *own), _running(options), asked)


def _fit(options: argparse.Namespace) -> Answer:
    from .fit import Asked, fitted

    own = [word for age, file in options.target for word in ("--target", f"{age}={file}")]
    own += [word for age, file in options.landmarks for word in ("--landmarks", f"{age}={file}")]
    own += [word for name in options.to for word in ("--to", name)]
    for name, ends in options.bounds:
        own += ["--bounds", f"{name}{'=' if name else ''}{':'.join(map(repr, ends))}"]
    smoothness = options.smoothness or None
    for name, value in (
        ("unit", options.unit), ("smoothness", smoothness), ("noise", options.noise),
    ):  # fmt: skip
        own += [] if value is None else [f"--{name}", str(value)]
    asked = Asked(
        tuple(options.target), tuple(options.to), options.unit, tuple(options.bounds), options.smoothness,
        options.noise, tuple(options.landmarks),
    )  # fmt: skip
    return fitted(_pictured(options, "fit", *own), _running(options), asked)


def _app(options: argparse.Namespace) -> int:
    from .app import Address, app

    address = Address(options.host, options.port, options.token)
    return app(options.case, options.folder, address, show=not options.no_open)


def _draw(options: argparse.Namespace) -> Answer:
    from .run import draw

    return draw(_pictured(options, "run"))


def _animate(options: argparse.Namespace) -> Answer:
    from ..figures.animation import animate
    from ..results.loading import load
    from .case import named_parts
    from .tools import scene_folder

    folder = scene_folder(options.result)
    file = options.figure or folder / "film.gif"
    result = load(folder, known=named_parts(options.parts))
    film = animate(result, file, field=options.field, rate=options.rate)
    say(f"film: {film}")
    return Answer(0, {"folder": str(folder), "figures": [str(film)]})


def _list(options: argparse.Namespace) -> int:
    from .listing import listing

    return listing(options.cases, parts=options.parts)


def _new(options: argparse.Namespace) -> int:
    from .listing import new_case

    say(new_case(options.file, options.case))
    return 0


def _stability(options: argparse.Namespace) -> Answer:
    from .tools import Stability, stability

    own = tuple(options.param), options.ratio, options.half_waves, options.radius, options.thickness
    return stability(Stability(options.kinetics, *own, options.figure))


def _buckling(options: argparse.Namespace) -> Answer:
    from .buckling import report
    from .follow import follow

    request, telling = _pictured(options, "buckling"), _telling(options)
    return report(request, telling) if options.follow is None else follow(request, telling, options.follow)


def _verify(options: argparse.Namespace) -> Answer:
    from ..verification.registry import checks
    from .verify import verify

    return verify(checks(options.problems, full=options.full), options.out)


def _atlas(options: argparse.Namespace) -> Answer:
    from ..verification.atlas.families import FAMILIES
    from .atlas import atlas

    counts = {"mechanics": options.mechanics, "pattern": options.patterns, "march": options.marches}
    counts |= {family: getattr(options, family) for family in FAMILIES}
    how = {"seed": options.seed, "seconds": options.seconds, "jobs": options.jobs}
    return atlas(options.out, counts, **how, telling=_telling(options))


def _compare(options: argparse.Namespace) -> Answer:
    from .case import named_parts
    from .tools import compare

    known = named_parts(options.parts)
    curves = options.curve_a, options.curve_b
    return compare(options.a, options.b, options.figure, options.landmarks, curves=curves, known=known)


def _doctor(options: argparse.Namespace) -> Answer:
    from .doctor import doctor

    return doctor()


def _completion(options: argparse.Namespace) -> int:
    from .completion import completion

    say(completion(options.shell))
    return 0


COMMANDS: Mapping[str, Callable[[argparse.Namespace], int | Answer]] = {
    "run": _run,
    "sweep": _sweep,
    "collect": _collect,
    "plot": _plot,
    "accuracy": _accuracy,
    "sensitivity": _sensitivity,
    "fit": _fit,
    "app": _app,
    "draw": _draw,
    "list": _list,
    "new": _new,
    "animate": _animate,
    "compare": _compare,
    "stability": _stability,
    "buckling": _buckling,
    "verify": _verify,
    "atlas": _atlas,
    "doctor": _doctor,
    "completion": _completion,
}
