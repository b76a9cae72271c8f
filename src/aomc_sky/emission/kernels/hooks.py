"""One text of a kernel for every plan, with a hook for each slice: its module, or None if the plan does not need it.

The globals `perez_hook` and `lobes_hook` of `emit` and `sampler` are SWAPPED HERE. In those modules both are None.
`with_hooks` copies a kernel and gives the copy the modules of the slices as these globals. numba leaves out the code
of `if lobes_hook is not None`, so a table neither loads nor compiles Perez and lobes.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import FunctionType
from typing import Any

_SLICES = {"perez": "aomc_sky.skies.perez.kernels.reject", "lobes": "aomc_sky.skies.lobes.kernels.cells"}
"""Name of a hook, as `CellLaw.hook` has it -> the module of its slice."""


def with_hooks(text: Callable[..., Any], hooks: tuple[str, ...], **others: Any) -> Any:
    """A copy of a text whose globals are the slices of these hooks, and `others`.

    numba caches code by name, so the name has the hooks: two copies with one name would share their code. A closure
    would not do, because the dispatcher in it differs in each process, so its code is never found again.
    """
    slices = {f"{hook}_hook": import_module(module) if hook in hooks else None for hook, module in _SLICES.items()}
    name = "_".join([text.__name__, *hooks])
    copy = FunctionType(text.__code__, {**text.__globals__, **slices, **others}, name)
    copy.__qualname__ = name
    return copy
