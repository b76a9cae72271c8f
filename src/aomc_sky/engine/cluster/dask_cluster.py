"""A Dask cluster: the connection to one or a new one here, and work that is handed to its workers."""

from __future__ import annotations

import contextlib
import signal
import tempfile
import threading
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from aomc_sky.errors import OutputError
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.source.photon_source import PhotonSource

CONNECT_SECONDS = 30
"""How long a scheduler may take to answer. [s]"""

_RESUME = "the same command goes on from what is finished"


@contextlib.contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Ignore SIGINT here and in the processes that are started meanwhile, in these for good."""
    if threading.current_thread() is not threading.main_thread():  # where Python lets nobody change it
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def cluster_client(distributed: Any, scheduler: str | None, n_workers: int) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster of processes here that ends with the context."""
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="aomc-sky-dask-"))
            with _interrupts_ignored():  # a terminal interrupts the workers too, which must not print tracebacks
                cluster = distributed.LocalCluster(
                    n_workers=n_workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,
                    local_directory=scratch,
                    silence_logs=50,  # workers that die are our business, and told by us
                )
            scheduler = stack.enter_context(cluster)
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=CONNECT_SECONDS))
        except (OSError, TimeoutError, ValueError) as error:
            raise OutputError(f"no Dask scheduler answers at {scheduler} ({error})") from error
        yield client


class Tasks:
    """Work handed to the workers; what is still waiting is withdrawn in the end.

    A context, inside that of the scheduler's client.
    """

    def __init__(self, distributed: Any, client: Any, folder: RunFolder, source: PhotonSource) -> None:
        self._distributed, self._client = distributed, client
        self._run = (str(folder.path), source.plan.sha256)
        self._results = distributed.as_completed(loop=client.loop)
        self._futures: list[Any] = []

    @property
    def n_workers(self) -> int:
        """Tasks that are worked on at a time. [1 or more]"""
        return max(1, sum(self._client.nthreads().values()))

    def __enter__(self) -> Tasks:
        return self

    def __exit__(self, *error: object) -> None:
        self._client.cancel(self._futures, force=True)

    def add(self, task: Any, arguments: Sequence[Any]) -> None:
        """Hand tasks over, one for each argument."""
        futures = self._client.map(partial(task, *self._run), arguments, pure=False)
        self._futures += futures
        self._results.update(futures)

    def results(self) -> Iterator[Any]:
        """Yield what the tasks return as they end, in any order; tasks may be added meanwhile."""
        try:
            for future in self._results:
                yield future.result()
        except self._distributed.KilledWorker as error:
            raise OutputError(f"Dask workers died again and again on one task ({error}); {_RESUME}") from error
        except (self._distributed.CancelledError, self._distributed.comm.CommClosedError) as error:
            raise OutputError(f"the Dask scheduler went away ({error}); {_RESUME}") from error
