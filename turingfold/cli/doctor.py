"""turingfold doctor: what is installed here, what works, and what is missing; made without any of it.

Packages are imported by another process: a wheel that is built for other processors ends the one it is
loaded in.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .browser import has_display
from .status import WIDTH, Answer, say

OWN = "turingfold"
EXTRAS = {  # for those who use it: what each gives
    "fast": "CHOLMOD, which factorises about five times faster than SuperLU",
    "app": "the app in the browser",
    "images": "outlines from NIfTI images",
    "movie": "films as .mp4",
    "notebook": "results as xarray and PyVista objects",
    "hpc": "studies on Dask clusters, tables as Parquet",
}
MODULES = {"scikit-fem": "skfem", "pillow": "PIL"}  # of packages that are imported by another name
WHEELS = {"ipctk": "it has wheels for Linux on x86-64, Windows, and macOS on arm64"}
IMPORT = """
import importlib, sys
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
        print(name, flush=True)
    except Exception as error:
        print(name, f"{type(error).__name__}: {error}".replace("\\n", " "), flush=True)
"""
FACTORISE = """
import numpy as np
from turingfold.solve.linear import solver_for
from turingfold.solve.sparsity import Sparsity
solver = solver_for(Sparsity(2, np.array([0, 1, 3])))
solver.factorize(np.array([2.0, 1.0, 2.0]))
assert np.allclose(solver.solve(np.array([3.0, 3.0])), 1.0), "a wrong solution"
blas = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
print(type(solver).__name__, blas.get("name", ""), blas.get("version", ""))
"""
FACTORISATIONS = {"Cholmod": "CHOLMOD", "SuperLu": "SuperLU"}
GB = 1e9


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: words for people, facts for programs, and what is wrong, if anything."""

    name: str
    words: str
    facts: Any
    wrong: tuple[str, ...] = field(default=())


def doctor() -> Answer:
    """Say what was found; the exit status is 1 where something is wrong."""
    found = list(findings())
    wrong = [words for one in found for words in one.wrong]
    width = max(len(one.name) for one in found) + 2
    for one in found:
        first, *rest = one.words.splitlines()
        say("\n".join([f"{one.name:<{width}}{first}", *(f"{'':<{width}}{line}" for line in rest)]))
    for words in wrong:
        say(f"PROBLEM: {words}")
    say("something is wrong" if wrong else "all that is needed works")
    return Answer(1 if wrong else 0, {**{one.name: one.facts for one in found}, "problems": wrong})


def findings() -> Iterator[Finding]:
    """Yield what there is to say, one after the other."""
    yield _python()
    try:
        asked = requires(OWN) or []
    except PackageNotFoundError:
        words = "not installed, run from its folder"
        yield Finding(OWN, words, None, (f"{OWN} is {words}, so what it needs is not known: pip install .",))
        return
    yield Finding(OWN, version(OWN), version(OWN))
    packages = _packages([words for words in asked if ";" not in words])
    yield packages
    yield _extras(asked)
    yield _factorisation() if not packages.wrong else Finding("factorisation", "not tried", None)
    cores = _cores()
    said = f"{cores}; one thread each scene (--threads), scenes side by side: --jobs"
    yield Finding("processors", said, cores)
    yield _disk(Path())
    shown = has_display()
    words = "turingfold app opens one" if shown else "no display: turingfold app says how to open its page"
    yield Finding("browser", words, shown)
    yield Finding("graphics card", "not needed", "not used")


def _python() -> Finding:
    name, own = platform.python_implementation(), platform.python_version()
    return Finding(
        "python", f"{name} {own}, {platform.system()} on {platform.machine()}",
        {"implementation": name, "version": own, "system": platform.system(), "machine": platform.machine()},
    )  # fmt: skip


def _cores() -> int:
    """Return how many processors this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _packages(asked: Sequence[str]) -> Finding:
    """Return the versions of the packages that are needed, and what is wrong with them."""
    names = [name_of(words) for words in asked]
    versions = {name: installed(name) for name in names}
    present = [name for name, own in versions.items() if own is not None]
    broken = imported([MODULES.get(name, name.replace("-", "_")) for name in present])
    faults = dict(zip(present, broken.values(), strict=True))
    wrong = []
    for words, (name, own) in zip(asked, versions.items(), strict=True):
        remedy = f'pip install "{words}"' + (f" ({WHEELS[name]})" if name in WHEELS else "")
        if own is None:
            wrong.append(f"{name} is missing: {remedy}")
        elif faults[name]:
            wrong.append(f"{name} {own} cannot be loaded ({faults[name]}): {remedy}")
        elif not suits(words, own):
            wrong.append(f"{name} {own} is not {words}: {remedy}")
    listed = [f"{name} {own or 'MISSING'}" for name, own in versions.items()]
    return Finding("packages", _wrapped(listed), versions, tuple(wrong))


def _extras(asked: Sequence[str]) -> Finding:
    """Return which extras are there, and what those that are not would give."""
    lines, facts = [], {}
    for extra, gives in EXTRAS.items():
        names = [name_of(words) for words in asked if words.endswith(f'extra == "{extra}"')]
        versions = {name: installed(name) for name in names}
        missing = [name for name, own in versions.items() if own is None]
        have = ", ".join(f"{name} {own}" for name, own in versions.items() if own is not None)
        how = f'without {", ".join(missing)}: pip install "{OWN}[{extra}]"' if missing else have
        lines.append(f"{extra}: {gives}; {how}")
        facts[extra] = {"gives": gives, "installed": not missing, "packages": versions}
    return Finding("extras", "\n".join(lines), facts)


def _factorisation() -> Finding:
    """Return which factorisation solves equilibria here, after it has solved a small system."""
    done = _run(FACTORISE)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [_death(done.returncode)])[-1]
        remedy = "pip install --force-reinstall cvxopt" if installed("cvxopt") else "reinstall scipy"
        return Finding("factorisation", "fails", None, (f"no factorisation works ({last}): {remedy}",))
    name, *blas = done.stdout.split()
    words = f"{FACTORISATIONS[name]}; BLAS of numpy: {' '.join(blas) or 'unknown'}"
    return Finding("factorisation", words, {"name": name.lower(), "blas": " ".join(blas)})


def _disk(place: Path) -> Finding:
    """Return whether results can be written in a folder, and how much room there is."""
    here, free = place.resolve(), shutil.disk_usage(place).free
    facts = {"folder": str(here), "free": free, "writable": True}
    words = f"{free / GB:.1f} GB free in {here}"
    try:
        with tempfile.TemporaryDirectory(dir=here, prefix=".turingfold-"):
            return Finding("disk", words, facts)
    except OSError as error:
        wrong = f"{here} cannot be written ({error.strerror}): go to another folder, or name one by --out"
        return Finding("disk", words, facts | {"writable": False}, (wrong,))


def name_of(requirement: str) -> str:
    """Return the name of the package in words such as 'ipctk<1.7,>=1.6'."""
    found = re.match(r"[\w.-]+", requirement)
    assert found is not None, requirement
    return found[0]


def installed(name: str) -> str | None:
    """Return the version of a package, None where it is missing."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def suits(requirement: str, own: str) -> bool:
    """Return whether a version is one that is asked for; True where nothing can tell."""
    if find_spec("packaging") is None:
        return True
    from packaging.requirements import Requirement

    return Requirement(requirement).specifier.contains(own, prereleases=True)


def imported(modules: Sequence[str]) -> Mapping[str, str]:
    """Return why each module cannot be imported, "" for those that can; other processes try."""
    found: dict[str, str] = {}
    while left := modules[len(found) :]:
        done = _run(IMPORT, *left)
        for line in done.stdout.splitlines():
            name, _, why = line.partition(" ")
            if name in left:
                found[name] = why
        if len(found) < len(modules):
            found[modules[len(found)]] = _death(done.returncode)
    return found


def _run(code: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-P", "-c", code, *words], capture_output=True, text=True, check=False
    )


def _death(status: int) -> str:
    import signal

    return f"it ends the program by {signal.Signals(-status).name if status < 0 else f'status {status}'}"


def _wrapped(items: Sequence[str]) -> str:
    """Return items side by side, on several lines, none of them broken."""
    import textwrap

    whole = ", ".join(item.replace(" ", "\xa0") for item in items)
    return textwrap.fill(whole, WIDTH - 15, break_on_hyphens=False).replace("\xa0", " ")
