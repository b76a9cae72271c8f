"""One text of a kernel for every plan, with hooks for what a slice does: its module, or None where the plan needs none.

numba leaves out what stands behind `if queue is not None`; so a table neither loads nor compiles Perez and lobes.
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

    Its name says which, for numba keeps code by name: of two copies with one name the second would run the first one's
    code. Globals are not part of that name; what a closure holds is, and a dispatcher differs in each process.
    """
    slices = {hook: import_module(module) if hook in hooks else None for hook, module in _SLICES.items()}
    name = "_".join([text.__name__, *hooks])
    copy = FunctionType(text.__code__, {**text.__globals__, **slices, **others}, name)
    copy.__qualname__ = name
    return copy
