"""The photons of a table by hand-written C (hand_written.c), which `emission.py` sets beside the kernels."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from aomc_sky import PhotonSource

COMPILER = shutil.which("gcc")
PROCESSOR = os.environ.get("NUMBA_CPU_NAME", "native")
"""What gcc and numba compile for."""

_REALS = {"float32": ("float", 4), "float64": ("double", 2)}
_FLAGS = ("-O3", f"-march={PROCESSOR}", "-ffp-contract=off", "-fno-math-errno", "-shared", "-fPIC")
_OUTPUTS = ("ux", "uy", "uz", "patch")


class _Band(ctypes.Structure):
    """The tables of a band, as in C."""

    _fields_ = (
        ("n", ctypes.c_uint64),
        ("shift", ctypes.c_uint64 * 2),
        ("step", ctypes.c_uint64 * 2),
        ("guide_shift", ctypes.c_uint64),
        ("key", ctypes.c_uint64 * 3),
        *((name, ctypes.c_void_p) for name in ("cumulative", "place", "guide", "table")),
    )


@cache
def _compiled(precision: str) -> Any:
    real, lane = _REALS[precision]
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "hand_written.so")
        source = Path(__file__).with_suffix(".c")
        defined = (f"-DREAL={real}", f"-DLANE={lane}")
        subprocess.run([str(COMPILER), *_FLAGS, *defined, "-o", library, source], check=True)
        return ctypes.CDLL(str(library))


def by_hand(source: PhotonSource, arrays: dict[str, np.ndarray]) -> Callable[[], object]:
    """What fills arrays with the first photons of the first band by C."""
    from aomc_sky.kernels.arithmetic.constants import NARROW  # here, since other trees of --before may lack it

    table = source._emitter._packed(0)
    is_short = table.cumulative.dtype == table.place.dtype == np.uint32 and table.guide.dtype == np.uint16
    assert is_short, "the C has 32 bits for ranks and 16 for slots"
    are_cells = table.law is None and table.one_disc < 0 and not table.cell_of_slot.size
    assert are_cells, "the C knows cells alone, of which none is empty"
    assert table.azimuth_kernel == NARROW, "the C knows narrow cells alone"
    is_shuffled = table.order.size > 0
    band = _Band(
        source.n_photons(0),
        (ctypes.c_uint64 * 2)(*table.shifts.tolist()),
        (ctypes.c_uint64 * 2)(*table.steps.tolist()),
        int(table.guide_shift),
        (ctypes.c_uint64 * 3)(*table.order[3:].tolist()),
        *(array.ctypes.data for array in (table.cumulative, table.place, table.guide, table.words)),
    )
    band.kept = table, arrays  # alive as long as their addresses
    library = _compiled(str(source.dtype))
    function = library.shuffled if is_shuffled else library.in_order
    sizes = ctypes.c_uint64(0), ctypes.c_uint64(arrays["ux"].size)
    return partial(function, ctypes.byref(band), *sizes, *(ctypes.c_void_p(arrays[k].ctypes.data) for k in _OUTPUTS))
