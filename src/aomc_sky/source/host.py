"""A band's photons inside another code's own loop: jitted functions for numba, a C function for the rest."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numba
import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.kernels.host_sampler import make_empty, make_fill, make_sample
from aomc_sky.kernels.host_tables import block_reader, fixed_address, is_compiled, kinds_of, words_of
from aomc_sky.source.emitter import Emitter
from aomc_sky.source.plan import Plan

_kept: list[Any] = []
"""Tables that compiled code reads. Nobody can say when machine code is dropped, so they live as long as the process."""


def _check_compiled() -> None:
    if not is_compiled():
        raise UsageError("hosts need numba's compiler; unset NUMBA_DISABLE_JIT, or take photons in batches")


def _check_plan(plan: Plan) -> None:
    replicates = int(plan.options.get("replicates", 1))
    if replicates > 1:
        raise UsageError(
            f"a host takes the photons of one randomisation, and this source has replicates={replicates}; "
            "make one source per seed with replicates=1"
        )


class _Block:
    """Arguments of a kernel in memory that stays where it is."""

    def __init__(self, arguments: tuple[object, ...]) -> None:
        self.words = np.array(words_of(arguments), dtype=np.uint64)
        self.read = block_reader(kinds_of(arguments), first=0)
        self.address = fixed_address(self.words.ctypes.data)
        _kept.append((self.words, arguments))


class NumbaSampler:
    """The photons of one band as functions that numba compiles into your own loop.

    Take the functions out before the loop is compiled: ``sample = source.numba_sampler(0).sample``.
    Each is compiled once per sampler, at its first use (about a second); its tables, up to a megabyte,
    live as long as the process. A function that calls one is never cached on disk, because the
    tables stand at an address of this process.

    Attributes
    ----------
    band : int
        Waveband. [0 to n_bands - 1]
    n : int
        Photons of the band.
    precision : numpy.dtype
        float32 or float64, that of the source.
    """

    def __init__(self, emitter: Emitter, band: int) -> None:
        _check_compiled()
        _check_plan(emitter.plan)
        self._emitter = emitter
        self.band = band
        self.n = emitter.n_photons(band)
        self.precision = emitter.dtype

    def __repr__(self) -> str:
        return f"<NumbaSampler: band {self.band}, {self.n} photons, {self.precision}>"

    @cached_property
    def sample(self) -> Any:
        """Jitted ``sample(i) -> (ux, uy, uz)``: the travel direction of photon i, as `PhotonSource.photons` gives it.

        The index is an integer, 0 to n - 1; any other raises IndexError. Random access, no state, no GIL.
        """
        if self.n == 0:
            return make_empty(self.precision.type(0))[0]
        block = _Block(self._emitter.photon_arguments(self.band))
        return make_sample(block.read, block.address, self.n)

    @cached_property
    def fill(self) -> Any:
        """Jitted ``fill(start, out) -> int``: write the directions of the photons from `start` on; return how many.

        `out` is a C-contiguous array (3, n) of the source's precision, whose rows become ux, uy and uz;
        another type is a typing error. Beyond the end of the band fewer photons come, and none from there on.
        A negative `start` raises IndexError.
        """
        if self.n == 0:
            fill = make_empty(self.precision.type(0))[1]
        else:
            kernel, arguments = self._emitter.kernel_arguments(self.band)
            block = _Block(arguments)
            fill = make_fill(kernel, block.read, block.address, self.n)
        directions = numba.types.Array(numba.from_dtype(self.precision), 2, "C")
        fill.compile((numba.types.int64, directions))
        fill.disable_compile()  # the tables are read in this precision alone
        return fill
