"""BLAS has one thread while a scene runs, and as many as before afterwards."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from small import elastic_scene
from threadpoolctl import threadpool_info, threadpool_limits

from turingfold import simulate
from turingfold.solve.threads import CHOSEN


def threads():
    return {own["num_threads"] for own in threadpool_info() if own["user_api"] == "blas"}


def while_running():
    seen = set()
    simulate(elastic_scene(), progress=lambda row: seen.update(threads()))
    return seen


@pytest.mark.filterwarnings("ignore::turingfold.results.simulate.CoarseMeshWarning")
def test_a_run_has_one_thread(monkeypatch):
    for name in CHOSEN:
        monkeypatch.delenv(name, raising=False)
    simulate(elastic_scene())  # loads what the solver needs
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        assert while_running() == {1}
        assert threads() == before
        assert 2 in before


@pytest.mark.filterwarnings("ignore::turingfold.results.simulate.CoarseMeshWarning")
@pytest.mark.parametrize(("said", "threads"), [("2", 2), ("1", 1), ("", 1)])
def test_what_the_environment_says_holds_also_when_it_is_said_late(monkeypatch, said, threads):
    simulate(elastic_scene())
    for name in CHOSEN:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", said)
    with threadpool_limits(2, user_api="blas"):
        assert max(while_running()) == threads


def alone(script):
    """Return what a script prints in a process whose environment says nothing of threads."""
    here = Path(__file__).parent
    environment = {name: value for name, value in os.environ.items() if name not in CHOSEN}
    environment["PYTHONPATH"] = os.pathsep.join([str(here), str(here.parent)])
    first = "import warnings; warnings.simplefilter('ignore')\nfrom test_threads import *\n"
    done = subprocess.run(
        [sys.executable, "-c", first + script], env=environment, cwd=here.parents[1], capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    return done.stdout.strip()


SIDE_BY_SIDE = """
import threading
begun, ended, seen = threading.Event(), threading.Event(), []
def long(row):
    begun.set()
    assert ended.wait(60)
    seen.append(max(threads()))
other = threading.Thread(target=lambda: simulate(elastic_scene(), progress=long))
other.start()
assert begun.wait(60)
simulate(elastic_scene())
ended.set()
other.join()
print(set(seen))
"""


def test_of_two_runs_side_by_side_none_ends_the_limit_of_the_other():
    assert alone(SIDE_BY_SIDE) == "{1}"


def test_a_library_that_a_run_loads_has_one_thread():
    script = (
        "seen = set(); simulate(elastic_scene(), progress=lambda row: seen.update(threads())); print(seen)"
    )
    assert alone(script) == "{1}"
