"""Studies on a Dask cluster: rows as without one, and a killed worker that costs only what it ran."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from turingfold.cli.main import main

distributed = pytest.importorskip("distributed")

CASE = '''"""A coarse patch of cortex that grows. Less than a second."""
from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle
from turingfold import parameters as p


def scenes(quick=False, *, cortex: p.Cortex = 1.05):
    body = semicircle(radius=0.03, thickness=0.01, elements=1, base="roller")
    solid, steps = Elastic(gray=NeoHookean.from_young(1e3, 0.4)), Stepping(first=0.05, largest=0.05)
    grow = TangentialGrowth(cortex=cortex)
    return {"only": Scene(body=body, terms=(solid,), processes=(grow,), stepping=steps)}
'''
STUDY = Path("results/patch-sweep")
WORDS = ["sweep", "patch", "--keep", "summary", "--vary", "cortex=1.05:1.5:10"]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)


def rows():
    with (STUDY / "sweep.csv").open(newline="") as file:
        return {row["scene"]: row for row in csv.DictReader(file)}


def finished():
    return {file.parent.name: file.stat().st_mtime_ns for file in STUDY.glob("*/point.json")}


def wait_for(count, driver):
    deadline = time.monotonic() + 300
    while len(finished()) < count:
        assert driver.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.slow
def test_a_killed_worker_costs_only_the_points_that_it_ran(tmp_path):
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        command = [sys.executable, "-m", "turingfold", *WORDS, "--dask", cluster.scheduler_address]
        driver = subprocess.Popen(command, cwd=tmp_path)
        wait_for(3, driver)
        before = finished()
        workers = client.run(os.getpid)
        os.kill(min(workers.values()), signal.SIGKILL)
        assert driver.wait(timeout=300) == 0
        assert set(client.run(os.getpid).values()) != set(workers.values())  # it was replaced
    found = rows()
    assert len(found) == 10
    assert {row["status"] for row in found.values()} == {"converged"}
    assert before.items() <= finished().items()  # none was run again
    lines = (STUDY / "sweep.csv").read_bytes()
    assert main([*WORDS, "--resume"]) == 0
    assert (STUDY / "sweep.csv").read_bytes() == lines
    assert main([*WORDS[:-1], "cortex=1.5", "--overwrite"]) == 0  # without a cluster
    (alone,) = rows().values()
    assert {**alone, "seconds": ""} == {**found["cortex=1.5"], "seconds": ""}


@pytest.mark.slow
def test_a_killed_driver_goes_on_with_what_its_cluster_has_finished(tmp_path):
    command = [sys.executable, "-m", "turingfold", *WORDS, "--dask", "local", "-j", "2"]
    driver = subprocess.Popen(command, cwd=tmp_path)
    wait_for(3, driver)
    driver.kill()
    driver.wait()
    time.sleep(5)  # its workers see that it is gone
    before = finished()
    assert main([*WORDS, "--resume", "--dask", "local"]) == 0
    assert before.items() <= finished().items()
    assert {row["status"] for row in rows().values()} == {"converged"}
    assert len(rows()) == 10


def scheduled(folder, name, *words):
    command = [sys.executable, "-m", f"distributed.cli.dask_{name}", "--scheduler-file", "cluster.json"]
    return subprocess.Popen([*command, "--no-dashboard", *words], cwd=folder, stderr=subprocess.DEVNULL)


@pytest.mark.slow
def test_a_killed_scheduler_costs_at_most_the_points_that_ran(tmp_path, capsys):
    words = [*WORDS[:-1], "cortex=1.05:1.5:40"]
    scheduler = scheduled(tmp_path, "scheduler", "--port", "0", "--host", "127.0.0.1")
    workers = [scheduled(tmp_path, "worker", "--nthreads", "1") for _ in range(2)]
    try:
        with distributed.Client(scheduler_file="cluster.json", timeout="60s", set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        command = [sys.executable, "-m", "turingfold", *words, "--dask", address]
        driver = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
        wait_for(3, driver)
        scheduler.kill()
        _, said = driver.communicate(timeout=120)
        assert driver.returncode == 3
        assert "start its scheduler again" in " ".join(said.split())
        assert said.count("--resume") == 1  # it is the same of every point
        for worker in workers:
            worker.wait(timeout=120)  # they end what they run, and themselves
    finally:
        for process in (scheduler, *workers):
            process.kill()
    before = finished()
    assert 3 <= len(before) < 40
    told = {name for name, row in rows().items() if row["status"] == "converged"}
    assert 1 <= len(told) <= len(before)  # of those that ran, the driver has heard nothing
    assert main([*words, "--resume"]) == 0
    assert before.items() <= finished().items()
    assert {row["status"] for row in rows().values()} == {"converged"}
    assert len(rows()) == 40


@pytest.mark.slow
def test_clusters_that_cannot_be_used_are_refused(capsys):
    options = {"n_workers": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(threads_per_worker=2, **options) as cluster:
        assert main([*WORDS, "--dask", cluster.scheduler_address]) == 2
    assert "one at a time in a process" in " ".join(capsys.readouterr().err.split())


def test_without_distributed_the_remedy_is_said(monkeypatch, capsys):
    monkeypatch.setattr("turingfold.cli.cluster.find_spec", lambda name: None)
    assert main([*WORDS, "--dask", "local"]) == 2
    assert 'pip install "turingfold[hpc]"' in " ".join(capsys.readouterr().err.split())
