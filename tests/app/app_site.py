"""A small case, and a server of the app in a thread, for tests."""

import http.client
import json
import signal
import socket
import threading
import time
from contextlib import contextmanager

import uvicorn

from turingfold.app.runs import Runs
from turingfold.app.server import application
from turingfold.cli.app import choices_of
from turingfold.cli.case import find_case

CASE = '''"""A small brain that grows. A second.

More words.
"""

from turingfold import AxonalTension, Elastic, NeoHookean, Scene, Schnakenberg, Stepping, TangentialGrowth
from turingfold import Turing, parameters as p, semicircle


@p.quick(elements=1)
def scenes(
    quick=False, *, radius: p.Radius = 0.04, thickness: p.Thickness = 8e-3, elements: p.Elements = 2,
    young_gray: p.YoungGray = 1000.0, cortex: p.Cortex = 1.2, steps: p.Steps = 5, pattern: p.Pattern = True,
    kinetics: p.Kinetics = "Schnakenberg",
):
    if thickness > radius / 2:
        raise ValueError(f"thickness={thickness:g} must be at most half of radius={radius:g}.")
    body = semicircle(radius=radius, thickness=thickness, elements=elements)
    solid, grow = Elastic(gray=NeoHookean.from_young(young_gray, 0.45)), TangentialGrowth(cortex=cortex)
    pull = (Turing(Schnakenberg(), half_waves=4),) if pattern else ()
    terms = (solid, AxonalTension(strength=0.1)) if pattern else (solid,)
    stepping = Stepping(first=1 / steps, largest=1 / steps)
    options = {"body": body, "terms": terms, "processes": (*pull, grow), "stepping": stepping}
    return {"whole": Scene(**options), "half": Scene(**options, until=0.5)}
'''


class Visitor:
    """Asks a server, and takes what it answers."""

    def __init__(self, port):
        self.port = port

    def ask(self, path, body=None, *, method=None, kind="application/json", **headers):
        """Return status, headers and content; a body that is no text is sent as JSON."""
        link = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        sent = body if body is None or isinstance(body, (str, bytes)) else json.dumps(body)
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        if sent is not None:
            named["Content-Type"] = kind
        link.request(method or ("GET" if body is None else "POST"), path, sent, named)
        reply = link.getresponse()
        content = reply.read()
        link.close()
        return reply.status, dict(reply.getheaders()), content

    def table(self, path, body=None):
        """Return the JSON of an answer that is no refusal."""
        status, _, content = self.ask(f"/api/{path}", body)
        assert status < 300, content
        return json.loads(content)

    def refused(self, path, body=None, **options):
        """Return status and words of a refusal."""
        status, _, content = self.ask(f"/api/{path}", body, **options)
        return status, json.loads(content)["error"]

    def begin(self, values=None, *, scene="whole", quick=True):
        """Start a run of the small case and return its id."""
        asked = {"case": "tiny", "scene": scene, "values": values or {}, "quick": quick}
        return self.table("runs", asked)["id"]

    def wait(self, run, *ends, seconds=90, until=lambda told: True):
        """Return what is told of a run once it stands as one of `ends`."""
        for _ in range(10 * seconds):
            told = self.table(f"runs/{run}")
            if told["status"] in ends and until(told):
                return told
            time.sleep(0.1)
        raise AssertionError(f"the run is {told['status']}: {told['message']}")


@contextmanager
def served(case, root, *, token=None, most=4):
    """Serve a case in a thread; yields a visitor."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in a shell's background: runs would not hear Stop
        signal.signal(signal.SIGINT, signal.default_int_handler)
    first = find_case(str(case))
    runs = Runs(root, most=most)
    site = application(dict(choices_of(first, str(case))), runs, first=first.name, token=token)
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        server = uvicorn.Server(uvicorn.Config(site, log_level="error"))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            yield Visitor(listening.getsockname()[1])
        finally:
            server.should_exit = True
            thread.join()
