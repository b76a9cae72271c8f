"""Work on threads whose results come in the order of the items, in bounded memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def in_order(
    executor: ThreadPoolExecutor, n_ahead: int, work: Callable[[_Item], _Result], items: Iterable[_Item]
) -> Generator[_Result, None, None]:
    """Yield what `work` makes of every item, in their order, a few ahead of the one that is used.

    Items are read on the caller's thread, `n_ahead` are worked on while one is used. With 1, for a pool of one
    thread, the caller works himself, so that one thread means one core (a worker of a cluster has no more).
    """
    if n_ahead == 1:
        yield from map(work, items)
        return
    waiting: deque[Future[_Result]] = deque()
    try:
        for item in items:
            waiting.append(executor.submit(work, item))
            if len(waiting) > n_ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:  # whoever stops early may close what the work reads
        for future in waiting:
            future.cancel()
        wait(waiting)
