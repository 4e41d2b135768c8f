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
def test_what_the_environment_says_stays(monkeypatch):
    simulate(elastic_scene())
    for name in CHOSEN:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with threadpool_limits(2, user_api="blas"):
        assert 2 in while_running()


def test_a_library_that_a_run_loads_has_one_thread():
    script = (
        "import warnings; warnings.simplefilter('ignore')\n"
        "from test_threads import threads, elastic_scene, simulate\n"
        "seen = set(); simulate(elastic_scene(), progress=lambda row: seen.update(threads())); print(seen)"
    )
    here = Path(__file__).parent
    environment = {name: value for name, value in os.environ.items() if name not in CHOSEN}
    environment["PYTHONPATH"] = os.pathsep.join([str(here), str(here.parent)])
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment,
        cwd=here.parents[1],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "{1}"
