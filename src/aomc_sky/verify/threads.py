"""Work on blocks by threads, a few blocks ahead of the one whose result is wanted."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from aomc_sky.outputs.chunk_pool import n_cpus

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def in_order(work: Callable[[_Item], _Result], items: Iterable[_Item], threads: int = 0) -> Iterator[_Result]:
    """Yield results in the order of the items; memory holds `threads` + 1 items at a time.

    Parameters
    ----------
    work : callable
        What is done with each item; numpy lets other threads run meanwhile.
    items : iterable
        Read on the caller's thread.
    threads : int
        0 for one per CPU.
    """
    threads = threads or n_cpus()
    waiting: deque[Future[_Result]] = deque()
    with ThreadPoolExecutor(max_workers=threads, thread_name_prefix="aomc-sky") as executor:
        for item in items:
            waiting.append(executor.submit(work, item))
            if len(waiting) > threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
