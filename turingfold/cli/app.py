"""turingfold app: serve the page in which cases are changed and run, until Ctrl-C."""

from __future__ import annotations

import os
import secrets
import socket
import webbrowser
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from ..models.declared import values_of
from .browser import has_display
from .case import Case, find_case, load_case
from .files import shipped
from .status import complain, say

if TYPE_CHECKING:
    from ..app.choices import Choice

NEEDED = ("starlette", "uvicorn")
PORT = 8765
HERE = "127.0.0.1"


@dataclass(frozen=True)
class Address:
    """Where the page is: port None is the usual one or, where that is taken, a free one."""

    host: str | None = None
    port: int | None = None
    token: bool = False

    def bound(self) -> socket.socket:
        """Return a socket that is bound there; raises ValueError where it cannot be."""
        if self.port is not None:
            return self._bound(self.port)
        with suppress(ValueError):
            return self._bound(PORT)
        return self._bound(0)

    def _bound(self, port: int) -> socket.socket:
        host = self.host or HERE
        made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, os.name == "posix")
        try:
            made.bind((host, port))
        except (OSError, OverflowError) as error:
            made.close()
            words = f"{host}, port {port} cannot be had ({error}); choose another by --port."
            raise ValueError(words) from error
        return made


def app(case: str, folder: Path, address: Address, *, show: bool) -> int:
    """Serve until Ctrl-C; show: whether a browser is opened.

    Raises ValueError for a case or folder that cannot be used, for an address that cannot be had, and where
    the extra is missing.
    """
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        raise ValueError(f'the app needs {" and ".join(missing)}: pip install "turingfold[app]"')
    import uvicorn

    from ..app.runs import Runs
    from ..app.server import application

    first = find_case(case)
    choices = dict(choices_of(first, case))
    runs = Runs(folder, most=max(2, os.cpu_count() or 1))
    token = secrets.token_urlsafe(24) if address.token or address.host is not None else None
    site = application(choices, runs, first=first.name, token=token)
    with address.bound() as listening:
        name, port = listening.getsockname()[:2]
        name = {"0.0.0.0": socket.gethostname(), "::": socket.gethostname()}.get(name, name)
        link = f"http://{f'[{name}]' if ':' in name else name}:{port}/" + (f"?token={token}" if token else "")
        listening.listen()  # what the browser asks before the server is up waits
        say(f"turingfold app: {link}\nresults: {folder}; Ctrl-C ends the app")
        if address.port is None and port != PORT:
            say(f"port {PORT} is taken, by another turingfold app perhaps: this one is at port {port}")
        if show:
            _open(link, port)
        server = uvicorn.Server(uvicorn.Config(site, log_level="warning", server_header=False))
        with suppress(KeyboardInterrupt):  # the usual end
            server.run(sockets=[listening])
    return 0


def choices_of(first: Case, given: str) -> Iterator[tuple[str, Choice]]:
    """Yield the cases that come with the package, and first the one that was asked for."""
    yield first.name, _choice(first, str(first.path) if Path(given).suffix else given)
    for name, path in shipped().items():
        if name != first.name:
            try:
                yield name, _choice(load_case(path), name)
            except ValueError as error:  # the others can be shown all the same
                complain(str(error))


def _choice(case: Case, given: str) -> Choice:
    from ..app.choices import Choice

    usual = {quick: values_of(case.module.scenes, {}, quick=quick) for quick in (True, False)}
    scenes = partial(_scenes, case)
    return Choice(case.name, case.title, given, case.path, case.parameters, usual, scenes, case.known)


def _scenes(case: Case) -> list[str]:
    try:
        return list(case.scenes({}, quick=True))
    except OSError as error:
        raise ValueError(f"{case.name} needs a file that is not here: {error.strerror or error}") from error


def _open(link: str, port: int) -> None:
    """Open a browser, or say how to come by one where there is none."""
    if not (has_display() and webbrowser.open(link)):
        say(
            "there is no browser here: open the address in one on this machine, or on your own after "
            f"ssh -N -L {port}:{HERE}:{port} {socket.gethostname()}"
        )
