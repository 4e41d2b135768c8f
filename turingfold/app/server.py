"""The server of the app: it starts and stops runs, and hands pages what is stored of them."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from threading import Lock
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from ..results.files import CorruptFileError
from .choices import Choice
from .guard import Guard
from .runs import BusyError, Run, Runs, UnknownRunError
from .views import Views, frames_archive

PAGE = Path(__file__).parent / "page"
LARGEST = 1 << 16  # bytes of what a page may send
FILM = 600  # s that a film may take
BYTES = "application/octet-stream"


class TooLargeError(ValueError):
    """A page sent more than it may."""


class Server:
    """Answers pages about the cases that may be run, by name, and their runs; `first` is shown first."""

    def __init__(self, choices: Mapping[str, Choice], runs: Runs, first: str) -> None:
        self.choices, self.runs, self.first = choices, runs, first
        self.views = Views()
        self._scenes: dict[str, list[str]] = {}
        self._filming = Lock()  # one film at a time

    def routes(self) -> list[Route | Mount]:
        """Return what is answered, by address."""
        posts, run = ["POST"], "/api/runs/{id}"
        return [
            Route("/api/cases", self.cases),
            Route("/api/cases/{case}/scenes", self.scenes),
            Route("/api/runs", self.listed),
            Route("/api/runs", self.begin, methods=posts),
            Route(run, self.progress),
            Route(f"{run}/stop", self.stop, methods=posts),
            Route(f"{run}/resume", self.resume, methods=posts),
            Route(f"{run}/mesh", self.mesh),
            Route(f"{run}/frames/{{step:int}}", self.frame),
            Route(f"{run}/files/{{name}}", self.file),
            Mount("/", StaticFiles(directory=PAGE, html=True)),
        ]

    def cases(self, request: Request) -> Response:
        """Return the cases with their parameters, and which one is shown first."""
        described = [one.described() for one in self.choices.values()]
        return JSONResponse({"first": self.first, "cases": described})

    def scenes(self, request: Request) -> Response:
        """Return the scenes of a case; some cases take seconds to make them, the first time."""
        choice = self._choice(request.path_params["case"])
        if choice.name not in self._scenes:
            self._scenes[choice.name] = list(choice.scenes())
        return JSONResponse(self._scenes[choice.name])

    def listed(self, request: Request) -> Response:
        """Return the runs, newest first."""
        return JSONResponse(self.runs.listed())

    async def begin(self, request: Request) -> Response:
        """Start a run of {"case", "scene", "values", "quick"} and return its id."""
        asked = await _table(request)
        kinds = {"case": str, "scene": str, "values": dict, "quick": bool}
        if asked.keys() != kinds.keys() or any(type(asked[name]) is not kinds[name] for name in kinds):
            raise ValueError(f"a run is asked for by {', '.join(kinds)}, and nothing else.")
        return await run_in_threadpool(self._begun, asked)

    def _begun(self, asked: Mapping[str, Any]) -> Response:
        choice = self._choice(asked["case"])
        known = self._scenes.get(choice.name) or list(choice.scenes())
        if asked["scene"] not in known:
            names = ", ".join(known)
            raise ValueError(f"{choice.name} has no scene {asked['scene'][:60]!r}; it has: {names}.")
        name = self.runs.begin(choice, asked["scene"], asked["values"], quick=asked["quick"])
        return JSONResponse({"id": name}, 201)

    def progress(self, request: Request) -> Response:
        """Return what was asked of a run, how it stands, and how far it has come."""
        run = self._run(request)
        status, message = self.runs.status(run)
        found = {**run.asked, "id": run.id, "status": status, "message": message}
        if run.result is not None:
            try:
                found |= self.views.progress(run.result, self._known(run))
            except CorruptFileError as error:
                found |= {"status": "damaged", "message": str(error)}
        return JSONResponse(found)

    async def stop(self, request: Request) -> Response:
        """Tell a run to stop."""
        await _table(request)
        await run_in_threadpool(self.runs.stop, self._run(request))
        return JSONResponse({})

    async def resume(self, request: Request) -> Response:
        """Go on with a run that was stopped."""
        await _table(request)
        run = self._run(request)
        await run_in_threadpool(self.runs.resume, run, self._choice(run.asked["case"]))
        return JSONResponse({})

    def mesh(self, request: Request) -> Response:
        """Return the mesh of a run."""
        return Response(self.views.mesh(self._result(self._run(request))), media_type=BYTES)

    def frame(self, request: Request) -> Response:
        """Return the fields of a state of a run."""
        folder = self._result(self._run(request))
        return Response(self.views.frame(folder, request.path_params["step"]), media_type=BYTES)

    def file(self, request: Request) -> Response:
        """Return a file to keep: case.py, history.csv, frames.zip, section.pdf or film.gif."""
        run, name = self._run(request), request.path_params["name"]
        makers: dict[str, Callable[[], bytes]] = {
            "case.py": lambda: self._choice(run.asked["case"]).file.read_bytes(),
            "history.csv": lambda: _plain(self._result(run) / "history.csv"),
            "frames.zip": lambda: frames_archive(self._result(run)),
            "section.pdf": lambda: self._section(run, request),
            "film.gif": lambda: self._film(run),
        }
        if name not in makers:
            raise UnknownRunError(f"a run has no file {name[:40]!r}; it has: {', '.join(makers)}.")
        heading = {"Content-Disposition": f'attachment; filename="{run.id}-{name}"'}
        return Response(makers[name](), media_type=BYTES, headers=heading)

    def _section(self, run: Run, request: Request) -> bytes:
        step = request.query_params.get("step", "")
        if not (step.isascii() and step.isdecimal() and len(step) < 10):
            raise ValueError("step must be a whole number.")
        field = request.query_params.get("field", "von_mises")
        return self.views.section(self._result(run), self._known(run), int(step), field)

    def _film(self, run: Run) -> bytes:
        choice, folder = self._choice(run.asked["case"]), self._result(run)
        with self._filming, tempfile.TemporaryDirectory() as place:
            film = Path(place) / "film.gif"
            command = ["animate", str(folder), "--figure", str(film), "--with", str(choice.file)]
            done = subprocess.run(
                [sys.executable, "-P", "-m", "turingfold", *command], capture_output=True, text=True,
                stdin=subprocess.DEVNULL, timeout=FILM, check=False,
            )  # fmt: skip
            if done.returncode:
                raise ValueError(done.stderr.strip())
            return film.read_bytes()

    def _choice(self, name: str) -> Choice:
        if name not in self.choices:
            raise ValueError(f"there is no case {name[:60]!r} here; there are: {', '.join(self.choices)}.")
        return self.choices[name]

    def _run(self, request: Request) -> Run:
        return self.runs.find(request.path_params["id"])

    def _result(self, run: Run) -> Path:
        if run.result is None:
            raise UnknownRunError("the run has no result yet.")
        return run.result

    def _known(self, run: Run) -> tuple[Any, ...]:
        choice = self.choices.get(str(run.asked.get("case")))
        return choice.known if choice else ()


def application(
    choices: Mapping[str, Choice], runs: Runs, *, first: str, token: str | None = None
) -> Starlette:
    """Return the server; first: name of the case that is shown first.

    token: what visitors must know, if anything. When it ends, the runs that it started are stopped.
    """

    @asynccontextmanager
    async def life(_: Starlette) -> Any:
        yield
        await run_in_threadpool(runs.close)

    return Starlette(
        routes=Server(choices, runs, first).routes(),
        middleware=[Middleware(Guard, token=token)],
        lifespan=life,
        exception_handlers={
            UnknownRunError: _refusal(404),
            TooLargeError: _refusal(413),
            BusyError: _refusal(429),
            ValueError: _refusal(400),
            OSError: _refusal(500),
        },
    )


def _refusal(status: int) -> Callable[[Request, Exception], Response]:
    return lambda request, error: JSONResponse({"error": str(error)}, status)


def _plain(file: Path) -> bytes:
    if file.is_symlink():
        raise CorruptFileError(f"{file} is a link.")
    return file.read_bytes()


async def _table(request: Request) -> dict[str, Any]:
    """Return the JSON object that a page sent; raises ValueError for anything else."""
    if request.headers.get("content-type", "").partition(";")[0] != "application/json":
        raise ValueError("a page sends application/json.")
    content = b""
    async for piece in request.stream():
        content += piece
        if len(content) > LARGEST:
            raise TooLargeError(f"a page sends at most {LARGEST} bytes.")
    try:
        found = json.loads(content, parse_int=float)  # as in the page: no whole number is too long
    except (ValueError, RecursionError) as error:
        raise ValueError("a page sends an object in JSON.") from error
    if not isinstance(found, dict):
        raise ValueError("a page sends an object in JSON.")
    return found
