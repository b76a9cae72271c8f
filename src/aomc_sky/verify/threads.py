"""Threads of a verification: numpy and SHA-256 let each other run."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from aomc_sky.outputs.blocks import blocks as ordered
from aomc_sky.outputs.blocks.blocks import n_cpus

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def map_in_order(
    work: Callable[[_Item], _Result], items: Iterable[_Item], threads: int = 0
) -> Generator[_Result, None, None]:
    """Yield what `work` makes of every item, in their order; memory holds `threads` + 1 items at a time.

    Items are read on the caller's thread; 0 threads: one per CPU.
    """
    threads = threads or n_cpus()
    with ThreadPoolExecutor(max_workers=threads, thread_name_prefix="aomc-sky") as executor:
        yield from ordered.in_order(executor, threads, work, items)
