"""Points of a study on a cluster, by Dask: a task each, sent as values, which comes back as a row.

Workers need turingfold, and the case file and the study's folder under the paths that they have here. A task
whose worker dies is run again by another one, from its last checkpoint where states are kept.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from ..results.simulate import CoarseMeshWarning
from .outcome import Outcome
from .point import Point, run_point
from .study import ended

if TYPE_CHECKING:
    from distributed import Client

LOCAL = "local"
PATIENCE = "20s"  # for the scheduler's first answer


def run_on_cluster(points: Sequence[Point], address: str, jobs: int) -> Iterator[Outcome]:
    """Run points on the workers of a cluster, or of one with `jobs` processes here, and yield how each ended.

    address: of the scheduler, such as tcp://host:8786, or "local".
    Raises ValueError without distributed, where nobody answers, and for workers of several threads; OSError
    where a worker cannot write.
    """
    if find_spec("distributed") is None:
        raise ValueError('--dask needs distributed: pip install "turingfold[hpc]"')
    from distributed import as_completed

    with ExitStack() as stack:
        client = _client(stack, address, jobs)
        here = [replace(one, case=one.case.resolve(), folder=one.folder.resolve()) for one in points]
        names = {}
        for one in here:
            names[client.submit(run_task, one, pure=False)] = one.name
        for future in as_completed(list(names), loop=client.loop):
            yield _outcome(names.pop(future), future)
            future.release()  # the scheduler forgets it


def run_task(point: Point) -> Outcome:
    """Run a point in a worker, unless one that died has finished it and could not say so any more."""
    if end := ended(point):
        return end
    logging.getLogger("skfem").setLevel(logging.ERROR)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CoarseMeshWarning)
        return run_point(point)


def _client(stack: ExitStack, address: str, jobs: int) -> Client:
    from distributed import Client, LocalCluster

    if address == LOCAL:
        cluster = stack.enter_context(
            LocalCluster(n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None)
        )
        client: Client = stack.enter_context(Client(cluster, set_as_default=False))
        return client
    try:
        client = stack.enter_context(Client(address, timeout=PATIENCE, set_as_default=False))
    except (OSError, ValueError) as error:
        words = "is the scheduler up, and is this the address that it has printed?"
        raise ValueError(f"--dask {address}: no answer ({error}); {words}") from error
    workers = client.scheduler_info(n_workers=-1)["workers"].values()
    if any(worker["nthreads"] > 1 for worker in workers):
        raise ValueError(
            f"--dask {address}: points are run one at a time in a process; start workers by dask worker "
            "--nthreads 1 (--nworkers for several), or with threads_per_worker=1."
        )
    return client


def _outcome(name: str, future: Any) -> Outcome:
    """Return how the point of a task ended; raises what the worker could not do anything about."""
    from distributed import KilledWorker

    if future.cancelled():
        lost = "the cluster has lost its task; start its scheduler again if that has ended."
        return Outcome(name, "killed", lost)
    error = future.exception()
    if isinstance(error, KilledWorker):
        return Outcome(name, "killed", "its workers have died several times; was there enough memory?")
    if isinstance(error, ImportError):
        raise ValueError(f"the workers of the cluster lack something: {error}; install turingfold there too.")
    if error is not None:
        raise error
    outcome: Outcome = future.result()
    return outcome
