"""The server of the app: what it tells, what it refuses, and that runs outlive pages and servers."""

import errno
import io
import json
import math
import os
import shutil
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("uvicorn")
pytest.importorskip("starlette")

from app_site import CASE, Visitor, served

import turingfold.cli.app as command
from turingfold import fold_count, load, simulate
from turingfold.app.runs import Runs
from turingfold.cli.case import load_case
from turingfold.cli.main import main
from turingfold.results.lock import FolderLock
from turingfold.results.vtu import in_cells
from turingfold.turing.kinetics.named import KINETICS

ENDS = ("converged", "interrupted", "stopped", "invalid", "refused")
SLOW = {"steps": 2000, "pattern": False}  # minutes


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    folder = tmp_path_factory.mktemp("app")
    (folder / "tiny.py").write_text(CASE)
    return folder


@pytest.fixture(scope="module")
def visitor(here):
    with served(here / "tiny.py", here / "runs") as found:
        yield found


@pytest.fixture(scope="module")
def done(visitor):
    """The id of a run that has ended, with other values than the case's."""
    run = visitor.begin({"thickness": 9e-3, "cortex": 1.3, "young_gray": 1000})
    assert visitor.wait(run, *ENDS)["status"] == "converged"
    return run


def unpacked(content):
    """Return the arrays that `packed` wrote, read by the words of its docstring."""
    length = int.from_bytes(content[:4], "little")
    found, at = {}, 4 + length
    assert at % 4 == 0
    for entry in json.loads(content[4:at]):
        kind, count = {"f": "<f4", "u": "<u4"}[entry["kind"]], math.prod(entry["shape"])
        found[entry["name"]] = np.frombuffer(content, kind, count, at).reshape(entry["shape"])
        at += 4 * count
    assert at == len(content)
    return found


def test_cases_are_told_with_labels_units_and_ranges(visitor):
    told = visitor.table("cases")
    assert told["first"] == "tiny"
    names = [case["name"] for case in told["cases"]]
    assert names[0] == "tiny"
    assert {"figure2", "figure3", "ferret_malformations", "turing_gallery"} <= set(names)
    assert told["cases"][0]["title"] == "A small brain that grows. A second."
    own = {one["name"]: one for one in told["cases"][0]["parameters"]}
    assert own["thickness"] == {
        "name": "thickness", "kind": "float", "unit": "m", "low": 1e-4, "high": 0.02, "choices": [],
        "label": "thickness of the cortex", "usual": 8e-3, "quick": 8e-3,
    }  # fmt: skip
    assert (own["elements"]["usual"], own["elements"]["quick"]) == (2, 1)
    assert own["pattern"]["kind"] == "bool"
    assert own["kinetics"]["choices"] == list(KINETICS)
    assert visitor.table("cases/tiny/scenes") == ["whole", "half"]
    assert visitor.table("cases/ferret_malformations/scenes")[1] == "PMG: T/4"


def test_a_run_is_the_command_line_it_tells(visitor, here, done):
    told = visitor.table(f"runs/{done}")
    file = here / "tiny.py"
    assert told["command"] == (
        f"turingfold run {file} --set thickness=0.009 --set cortex=1.3 --quick --only whole"
    )  # the usual modulus is not said
    assert told["values"] == {"thickness": 9e-3, "cortex": 1.3}
    described = json.loads((here / f"runs/{done}/tiny/whole/scene.json").read_text())["case"]
    assert described["parameters"]["thickness"] == 9e-3
    assert described["parameters"]["elements"] == 1
    (listed,) = [one for one in visitor.table("runs") if one["id"] == done]
    summary = load(here / f"runs/{done}/tiny/whole").summary()
    assert listed["status"] == "converged"
    assert listed["gyrification_index"] == summary["gyrification_index"]


def test_a_page_draws_what_is_stored(visitor, here, done):
    result = load(here / f"runs/{done}/tiny/whole")
    body, told = result.scene.body, visitor.table(f"runs/{done}")
    assert told["curves"]["time"] == [row["time"] for row in result.history]
    assert told["curves"]["energy"] == [row["energy"] for row in result.history]
    assert set(told["curves"]["min_gap"]) == {None}  # no contact
    assert [frame["time"] for frame in told["frames"]] == [state.time for state in result.states]
    assert told["length"] == [1e-3, "mm"]
    assert told["until"] == 1.0
    last, step = told["frames"][-1], told["frames"][-1]["step"]
    assert step == len(result.history)
    assert last["folds"] == fold_count(result.pial(), thickness=body.thickness)
    assert last["sulcal_depth"] == result.summary()["sulcal_depth"]
    mesh = unpacked(visitor.ask(f"/api/runs/{done}/mesh")[2])
    fields = unpacked(visitor.ask(f"/api/runs/{done}/frames/{step}")[2])
    np.testing.assert_array_equal(mesh["triangles"], body.triangles.T)
    np.testing.assert_allclose(mesh["points"][:, :2], body.nodes.T, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(mesh["layer"], body.in_cortex)
    np.testing.assert_allclose(fields["displacement"][:, :2], result.last["displacement"].T, rtol=1e-6)
    stress = in_cells(body, result.observe()["von_mises"])
    np.testing.assert_allclose(fields["von_mises"], stress, rtol=1e-5)
    np.testing.assert_allclose(fields["growth"], np.where(body.in_cortex, 1.3, 1.0), rtol=1e-6)
    activator = body.spread(body.cortex, result.last["activator"])
    np.testing.assert_allclose(fields["activator"], activator, rtol=1e-6)


def test_files_to_keep(visitor, here, done):
    folder, address = here / f"runs/{done}/tiny/whole", f"/api/runs/{done}/files"
    status, headers, content = visitor.ask(f"{address}/history.csv")
    assert (status, content) == (200, (folder / "history.csv").read_bytes())
    assert headers["content-disposition"] == f'attachment; filename="{done}-history.csv"'
    assert visitor.ask(f"{address}/case.py")[2] == CASE.encode()
    archive = zipfile.ZipFile(io.BytesIO(visitor.ask(f"{address}/frames.zip")[2]))
    frames = [f"frames/{file.name}" for file in sorted((folder / "frames").iterdir())]
    assert archive.namelist() == ["frames.pvd", *frames]
    assert visitor.ask(f"{address}/section.pdf?step=5&field=pressure")[2].startswith(b"%PDF")
    assert visitor.refused(f"runs/{done}/files/section.pdf?step=77") == (400, "there is no state of step 77.")
    assert visitor.refused(f"runs/{done}/files/section.pdf?step=5&field=mu")[0] == 400
    assert visitor.refused(f"runs/{done}/files/run.json")[0] == 404


@pytest.mark.slow
def test_a_film_is_made_by_the_command_line(visitor, done):
    status, _, content = visitor.ask(f"/api/runs/{done}/files/film.gif")
    assert status == 200
    assert content.startswith(b"GIF89a")


GOOD = {"case": "tiny", "scene": "whole", "values": {}, "quick": True}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"values": {"thicknes": 1e-3}}, "no parameter thicknes; did you mean thickness?"),
        ({"values": {"thickness": 8}}, "thickness=8 is out of range (0.0001 to 0.02 m"),
        ({"values": {"thickness": "8e-3"}}, "thickness=8e-3 must be a number in m"),
        ({"values": {"thickness": True}}, "must be a number"),
        ({"values": {"thickness": [1e-3]}}, "must be a number"),
        ({"values": {"steps": 1.5}}, "steps=1.5 must be a whole number"),
        ({"values": {"pattern": "on; rm -rf"}}, "must be on or off"),
        ({"values": {"kinetics": "$(id)"}}, "must be one of"),
        ({"values": {"Elastic.gray.mu": 1.0}}, "no parameter Elastic.gray.mu"),
        ({"values": [1]}, "case, scene, values, quick"),
        ({"scene": "../../etc"}, "tiny has no scene '../../etc'"),
        ({"scene": 1}, "case, scene, values, quick"),
        ({"case": "/etc/passwd"}, "there is no case '/etc/passwd' here"),
        ({"quick": "on"}, "case, scene, values, quick"),
        ({"out": "/tmp"}, "case, scene, values, quick"),
    ],
)
def test_a_bad_run_is_refused_in_words(visitor, here, change, words):
    before = set((here / "runs").iterdir())
    status, said = visitor.refused("runs", GOOD | change)
    assert status == 400
    assert words in said
    assert set((here / "runs").iterdir()) == before


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "1" + 4000 * "0", "9" * 5000])
def test_numbers_are_finite(visitor, number):
    body = json.dumps(GOOD).replace('"values": {}', f'"values": {{"thickness": {number}}}')
    assert visitor.refused("runs", body)[0] == 400


@pytest.mark.parametrize("body", ["", "[]", "3", "{", '{"case": ', b"\xff\xfe", "[" * 60000])
def test_what_is_no_table_is_refused(visitor, body):
    assert visitor.refused("runs", body) == (400, "a page sends an object in JSON.")


def test_kind_and_size_of_what_a_page_sends(visitor):
    assert visitor.refused("runs", GOOD, kind="text/plain") == (400, "a page sends application/json.")
    assert visitor.refused("runs", '{"case": "' + 70000 * "x" + '"}')[0] == 413


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8765", "127.0.0.1.evil.example", "[bad", ""])
def test_other_names_are_not_answered(visitor, host):
    assert visitor.ask("/api/runs", Host=host)[0] in (400, 403)
    for own in ("localhost", "127.0.0.1:1", "[::1]:8765"):  # a tunnel may have another port
        assert visitor.ask("/api/runs", Host=own)[0] == 200


def test_pages_of_other_sites_are_refused(visitor):
    for origin in ("http://evil.example", "null", "https://localhost:1"):
        assert visitor.ask("/api/runs", GOOD, Origin=origin)[0] == 403
    assert visitor.ask("/api/runs", GOOD, Sec_Fetch_Site="cross-site")[0] == 403
    headers = visitor.ask("/", Origin=f"http://127.0.0.1:{visitor.port}")[1]
    assert headers["content-security-policy"].startswith("default-src 'self';")
    assert headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(
    "name", ["..", "%2e%2e", "../../tiny.py", "..%2f..%2ftiny.py", "20260101-000000-abcdef", "x" * 5000]
)
def test_runs_are_found_by_their_id_alone(visitor, name):
    for more in ("", "/mesh", "/frames/0", "/files/case.py"):
        assert visitor.ask(f"/api/runs/{name}{more}")[0] == 404


def test_links_are_not_followed(visitor, here, done):
    root = here / "runs"
    (root / "20260101-000000-abcdef").symlink_to(root / done)
    copy = root / "20260101-000000-abcde0"
    (copy / "tiny").mkdir(parents=True)
    (copy / "run.json").write_bytes((root / done / "run.json").read_bytes())
    (copy / "tiny/whole").symlink_to(root / done / "tiny/whole")
    try:
        assert visitor.refused("runs/20260101-000000-abcdef")[0] == 404
        assert visitor.refused("runs/20260101-000000-abcde0/mesh")[0] == 404
    finally:
        (root / "20260101-000000-abcdef").unlink()
        (copy / "tiny/whole").unlink()
        (copy / "run.json").unlink()
    (here / "link").symlink_to(root)
    with pytest.raises(ValueError, match="must be a folder, and no link"):
        Runs(here / "link", most=1)


def test_what_only_the_scene_can_refuse_is_told(visitor):
    run = visitor.begin({"thickness": 0.02, "radius": 0.03})
    told = visitor.wait(run, *ENDS)
    assert told["status"] == "refused"
    assert "thickness=0.02 must be at most half of radius=0.03." in told["message"]
    assert visitor.refused(f"runs/{run}/resume", {}) == (
        400, "the run is refused; only one that was stopped can go on.",
    )  # fmt: skip


def test_a_damaged_result_is_told_and_the_others_are_shown(visitor, here, done):
    run = "20260101-000000-abcde1"
    shutil.copytree(here / "runs" / done, here / "runs" / run)
    assert visitor.table(f"runs/{run}")["status"] == "converged"
    file = here / f"runs/{run}/tiny/whole/history.csv"
    lines = file.read_text().splitlines()
    file.write_text("\n".join([lines[0], lines[1].replace("0", "1", 1), *lines[2:], ""]))
    told = visitor.table(f"runs/{run}")
    assert told["status"] == "damaged"
    assert "history.csv" in told["message"]
    assert visitor.table(f"runs/{done}")["status"] == "converged"


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        ({"case": None}, '"case" must be a text, and is null'),
        ({"quick": 1}, '"quick" must be true or false, and is 1'),
        ({"values": [9e-3]}, '"values" must be a table, and is [0.009]'),
        ({"scene": ...}, '"scene" must be a text, and is missing'),
        ({"values": {"thickness": math.nan}}, "Out of range float values"),
        ({"scene": "\ud800"}, "surrogates not allowed"),
        ("{", "is not JSON"),
    ],
)
def test_what_was_asked_for_may_be_edited_by_hand(visitor, here, done, edit, words):
    run = "20260101-000000-abcde3"
    shutil.copytree(here / "runs" / done, here / "runs" / run)
    try:
        file = here / f"runs/{run}/run.json"
        if isinstance(edit, dict):
            edited = {**json.loads(file.read_text()), **edit}
            edit = json.dumps({name: value for name, value in edited.items() if value is not ...})
        file.write_text(edit)
        for path, body in (
            (f"runs/{run}", None),
            (f"runs/{run}/resume", {}),
            (f"runs/{run}/files/case.py", None),
        ):
            status, told = visitor.refused(path, body)
            assert status == 400
            assert str(file) in told
            assert words in told
        listed = {one["id"]: one for one in visitor.table("runs")}
        assert listed[run]["status"] == "damaged"
        assert words in listed[run]["message"]
        assert listed[done]["status"] == "converged"
    finally:
        shutil.rmtree(here / "runs" / run)


def test_stop_and_go_on_is_the_run_without_a_stop(visitor, here):
    values = {"thickness": 9e-3, "cortex": 1.3, "steps": 60, "pattern": False}
    run = visitor.begin(values)
    visitor.wait(run, "running", until=lambda told: len(told.get("frames", ())) > 2)
    visitor.table(f"runs/{run}/stop", {})
    told = visitor.wait(run, *ENDS)
    assert told["status"] == "interrupted"
    assert 0 < told["curves"]["time"][-1] < 1

    def resumed(_):
        return visitor.ask(f"/api/runs/{run}/resume", {})[0] < 300

    with ThreadPoolExecutor(4) as pool:  # a double click, or two pages
        assert sum(pool.map(resumed, range(4))) == 1
    assert visitor.wait(run, "converged")["curves"]["time"][-1] == 1.0
    whole = simulate(load_case(here / "tiny.py").scenes(values, quick=True)["whole"])
    again = load(here / f"runs/{run}/tiny/whole").last
    np.testing.assert_array_equal(again["displacement"], whole.last["displacement"])


def test_a_stop_that_the_system_forbids_is_said(visitor, here, done, monkeypatch):
    run = "20260101-000000-abcde2"
    shutil.copytree(here / "runs" / done, here / "runs" / run)

    def forbidden(process, number):
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    def ended(process, number):
        lock.release()
        raise ProcessLookupError(errno.ESRCH, os.strerror(errno.ESRCH))

    lock = FolderLock(here / f"runs/{run}/tiny/whole")  # as another user's process would
    monkeypatch.setattr(os, "kill", forbidden)
    for _ in range(2):
        status, words = visitor.refused(f"runs/{run}/stop", {})
        assert status == 500
        assert f"forbids this server to stop its process {os.getpid()} (Operation not permitted)" in words
    monkeypatch.setattr(os, "kill", ended)
    assert visitor.table(f"runs/{run}/stop", {}) == {}


@pytest.mark.slow
def test_two_visitors_have_runs_of_their_own_and_no_more_than_may_be(here):
    with served(here / "tiny.py", here / "few", most=2) as one:
        runs = [one.begin(SLOW), one.begin(SLOW, scene="half")]
        assert one.refused("runs", GOOD)[0] == 429
        one.wait(runs[1], "running")
        one.table(f"runs/{runs[0]}/stop", {})
        one.table(f"runs/{runs[0]}/stop", {})  # an impatient visitor
        assert one.wait(runs[0], *ENDS)["status"] == "interrupted"
        assert one.wait(runs[1], "running")["status"] == "running"
    with served(here / "tiny.py", here / "few") as again:  # the server has stopped what it had started
        told = again.wait(runs[1], *ENDS)
        assert told["status"] == "interrupted"
        assert {one["id"] for one in again.table("runs")} == set(runs)


@pytest.mark.slow
def test_a_run_outlives_a_server_that_is_killed_and_obeys_the_next(here):
    words = ["app", "tiny.py", "--no-open", "--port", "0", "--folder", "crash"]
    server = subprocess.Popen(
        [sys.executable, "-m", "turingfold", *words], cwd=here, stdout=subprocess.PIPE, text=True
    )
    try:
        first = Visitor(int(server.stdout.readline().rpartition(":")[2].strip("/\n")))
        run = first.begin(SLOW)
        first.wait(run, "running", until=lambda told: told.get("frames"))
    finally:
        server.kill()
        server.communicate()
    with served(here / "tiny.py", here / "crash") as second:
        assert second.wait(run, "running")["scene"] == "whole"
        second.table(f"runs/{run}/stop", {})
        assert second.wait(run, *ENDS)["status"] == "interrupted"


def test_a_token_is_asked_for_and_kept_as_a_cookie(here):
    with served(here / "tiny.py", here / "runs", token="right") as visitor:
        for path in ("/", "/?token=wrong", "/page.js", "/api/runs"):
            assert visitor.ask(path)[0] == 401
        assert visitor.ask("/api/runs", Cookie="turingfold=wrong")[0] == 401
        status, headers, _ = visitor.ask("/?token=right")
        assert (status, headers["location"]) == (303, "./")
        cookie, *rules = headers["set-cookie"].split("; ")
        assert "HttpOnly" in rules
        assert visitor.ask("/", Cookie=cookie, Host="hub.example")[0] == 200
        assert visitor.ask("/api/runs", GOOD, Cookie=cookie, Origin="http://evil.example")[0] == 403


def test_every_address_of_the_page_is_its_own(visitor):
    """Behind a notebook's proxy the page is not at the root, and no other machine is asked."""
    page = Path(command.__file__).parents[1] / "app/page"
    for file in page.iterdir():
        assert visitor.ask(f"/{file.name}")[2] == file.read_bytes()
        text = file.read_text().replace("http://www.w3.org/2000/svg", "")
        assert "http" not in text
        assert not [sign for sign in ('src="/', 'href="/', 'fetch("/', "fetch(`/", 'from "/') if sign in text]
    assert visitor.ask("/../server.py")[0] == 404
    assert visitor.ask("/%2e%2e/server.py")[0] == 404


def test_the_command_says_what_is_missing(here, monkeypatch, capsys):
    monkeypatch.chdir(here)
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    assert main(["app"]) == 2
    assert 'the app needs starlette and uvicorn: pip install "turingfold[app]"' in capsys.readouterr().err


def test_the_command_serves_where_it_says(here, monkeypatch, capsys):
    monkeypatch.chdir(here)
    served_at, opened = [], []
    run = lambda self, sockets: served_at.append(sockets[0].getsockname())  # noqa: E731
    monkeypatch.setattr("uvicorn.Server.run", run)
    monkeypatch.setattr("webbrowser.open", lambda link: opened.append(link) or True)
    monkeypatch.setenv("DISPLAY", ":0")
    assert main(["app", "tiny.py", "--port", "0", "--folder", "mine"]) == 0
    host, port = served_at.pop()
    assert host == "127.0.0.1"
    assert opened == [f"http://127.0.0.1:{port}/"]
    assert capsys.readouterr().out.startswith(f"turingfold app: http://127.0.0.1:{port}/\nresults: mine;")
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if os.name == "posix":
        assert main(["app", "tiny", "--port", "0", "--folder", "mine", "--token"]) == 0
        out = capsys.readouterr().out
        assert "?token=" in out
        assert "there is no browser here" in out
        assert "ssh -N -L" in out
        assert len(opened) == 1


def test_a_port_that_is_taken(here, visitor, monkeypatch, capsys):
    monkeypatch.chdir(here)
    monkeypatch.setattr("uvicorn.Server.run", lambda self, sockets: None)
    monkeypatch.setattr(command, "PORT", visitor.port)
    assert main(["app", "tiny.py", "--no-open"]) == 0
    assert f"port {visitor.port} is taken, by another turingfold app perhaps: this one is at port" in (
        capsys.readouterr().out
    )
    assert main(["app", "tiny.py", "--port", str(visitor.port), "--no-open"]) == 2
    assert "choose another by --port" in " ".join(capsys.readouterr().err.split())
