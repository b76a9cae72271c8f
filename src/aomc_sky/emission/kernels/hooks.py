"""One text of a kernel for every plan, with hooks for the slices: a module, or None if the plan does not need it.

numba leaves out the code of `if queue is not None`, so a table neither loads nor compiles Perez and lobes.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import FunctionType
from typing import Any

REJECTION, QUEUE = "rejection", "queue"
_SLICES = {REJECTION: "aomc_sky.skies.perez.kernels.reject", QUEUE: "aomc_sky.skies.lobes.kernels.cells"}


def with_hooks(text: Callable[..., Any], hooks: tuple[str, ...], **others: Any) -> Any:
    """A copy of a text whose globals are the slices of these hooks, and `others`.

    numba caches code by name, so the name has the hooks: two copies with one name would share their code. A closure
    would not do, because the dispatcher in it differs in each process, so its code is never found again.
    """
    slices = {hook: import_module(module) if hook in hooks else None for hook, module in _SLICES.items()}
    name = "_".join([text.__name__, *hooks])
    copy = FunctionType(text.__code__, {**text.__globals__, **slices, **others}, name)
    copy.__qualname__ = name
    return copy
