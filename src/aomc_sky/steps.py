"""How far a long loop is, for whoever shows it: the command line does, on a terminal."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")

STEPS = logging.getLogger("aomc_sky.steps")
"""Gets a text for each part of a loop, at the level of debugging, and passes none on: there are thousands."""
STEPS.propagate = False


def counted(parts: Iterable[T], name: str, n: int) -> Iterator[T]:
    """The parts as they come, `n` of them; the number of each is told before it is taken."""
    for k, part in enumerate(parts, start=1):
        STEPS.debug("%s %d of %d", name, k, n)
        yield part
