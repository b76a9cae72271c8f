"""A band's photons inside another code's own loop: jitted functions for numba, a C function for the rest."""

from __future__ import annotations

import threading
import weakref
from functools import cached_property
from typing import Any

import numpy as np

from aomc_sky.emission.emitter import Emitter
from aomc_sky.errors import UsageError
from aomc_sky.plan.plan import Plan

try:
    from aomc_sky.emission.kernels.next_photons import (
        OPEN,
        JittedNext,
        compile_next,
        next_signature,
        numbers_signature,
    )
    from aomc_sky.emission.kernels.sampler import make_fill, make_sample
    from aomc_sky.kernels.arguments import fixed_block, typed, words_of
    from aomc_sky.kernels.jit import is_off
except (ImportError, AttributeError) as error:
    raise UsageError(
        f"hosts need a name that the installed numba does not have ({error}); take photons in batches, or install "
        "numba 0.68"
    ) from error

_kept: list[Any] = []
"""Tables of compiled code. They live as long as the process, because the end of machine code is unknown."""


def _require_host(plan: Plan) -> None:
    """Refuse plans with replicates, and all plans if the compiler is off."""
    if is_off():
        raise UsageError("hosts need numba's compiler; unset NUMBA_DISABLE_JIT, or take photons in batches")
    if (replicates := plan.replicates) > 1:
        raise UsageError(
            f"a host takes the photons of one randomisation, and this source has replicates={replicates}; "
            "make one source per seed with replicates=1"
        )


class _Block:
    """Arguments of two kernels, the numbers and another one, at a fixed address."""

    def __init__(self, n: int, of_numbers: tuple[object, ...], of_photons: tuple[object, ...]) -> None:
        self.arguments = arguments = (of_numbers, of_photons)
        self.kinds = typed(arguments)
        self.words = np.array([OPEN, n, *words_of(arguments)], dtype=np.uint64)

    @property
    def address(self) -> int:
        """Address of the first word."""
        return int(self.words.ctypes.data)

    def as_function(self) -> Any:
        """A jitted function that returns the block, which then lives as long as the process."""
        _kept.append((self.words, self.arguments))
        return fixed_block(self.kinds, self.address)


_lock = threading.Lock()
_compiled: dict[tuple[str, tuple[str, ...], object], JittedNext] = {}


def _range_function(emitter: Emitter, band: int) -> tuple[_Block, JittedNext]:
    """The block of a band and the C function for it."""
    kernel, arguments = emitter.host_arguments(band)
    block = _Block(emitter.n_photons(band), emitter.number_arguments(band), arguments)
    return block, _compiled_once(kernel, emitter.hooks, next_signature(block.kinds, emitter.dtype))


def _compiled_once(kernel: str, hooks: tuple[str, ...], signature: Any) -> JittedNext:
    """A C function, compiled once per process and set of types."""
    with _lock:
        key = (kernel, hooks, signature)
        if key not in _compiled:
            _compiled[key] = JittedNext(compile_next(*key), signature)
        return _compiled[key]


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
    numbers : int
        Further coordinates that each photon carries; see `PhotonSource.photons`. [0 to 3]

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components="uniform")
    >>> sampler = scene.source(seed=1).numba_sampler(band=0)
    >>> ux, uy, uz = sampler.sample(0)  # as well in a loop that numba compiles
    >>> uz < 0, sampler.n
    (True, 1000)
    """

    def __init__(self, emitter: Emitter, band: int, numbers: int = 0) -> None:
        _require_host(emitter.plan)
        self._emitter = emitter
        self.band = band
        self.n = emitter.n_photons(band)
        self.precision = emitter.dtype
        self.numbers = numbers

    def __repr__(self) -> str:
        numbers = f", {self.numbers} numbers each" if self.numbers else ""
        return f"<NumbaSampler: band {self.band}, {self.n} photons, {self.precision}{numbers}>"

    @cached_property
    def sample(self) -> Any:
        """Jitted ``sample(i) -> (ux, uy, uz)``: the travel direction of photon i, as `PhotonSource.photons` gives it.

        Its numbers, where the sampler was asked for any, follow: ``(ux, uy, uz, n1, n2)``.
        The index is an integer, 0 to n - 1; any other raises IndexError, a float or bool TypeError
        when it is compiled. Random access, no state, no GIL.
        """
        of_photon = self._emitter.photon_arguments(self.band)
        _, *words, jitter = self._emitter.number_arguments(self.band)
        of_numbers = (self.precision.type(0), of_photon[0], *words, jitter or None)
        block = _Block(self.n, of_numbers if self.numbers else (), of_photon)
        return make_sample(self._emitter.hooks, block.as_function(), self.n, self.numbers)

    @cached_property
    def fill(self) -> Any:
        """Jitted ``fill(start, out) -> int``: write the directions of the photons from `start` on; return how many.

        `out` is a C-contiguous array (3 + numbers, n) of the source's precision, whose rows become ux, uy, uz and the
        numbers; another type is a typing error. Beyond the end of the band fewer photons come, and none from there on.
        A negative `start` raises IndexError.
        """
        block, function = _range_function(self._emitter, self.band)
        return make_fill(function, block.as_function(), self.precision, self.numbers)


class CSource:
    """The photons of one band as a C function and its context, declared in ``aomc_sky_embed.h``.

    ``int64_t next(void *context, int64_t start, int64_t n, float *ux, float *uy, float *uz)``

    It writes the travel directions of the photons [start, start + n) of the band. It returns the number of photons:
    fewer at the end of the band, then 0. A negative answer is an error (`AOMC_SKY_CLOSED` and others). It needs neither
    the GIL nor a thread of Python, any number of threads may call it at once, and it costs as much as
    `PhotonSource.photons`. In a source of precision float64 the last three arguments are pointers to double.

    ``int64_t numbers(void *context, int64_t start, int64_t n, float *n1, float *n2, float *n3)``

    It writes up to three further coordinates of the same photons (see `PhotonSource.photons`), with the same answers.
    A pointer is NULL for a coordinate that is not wanted.

    The tables live as long as this object, which therefore must outlive the last call. It closes with `close`,
    at the end of a ``with`` block, or when it is dropped; a later call returns `AOMC_SKY_CLOSED`, one that
    is still running has undefined results.

    Attributes
    ----------
    address, context : int
        The function and its first argument, as addresses of this process.
    numbers_address : int
        The second function; it has the same first argument.
    band : int
        Waveband. [0 to n_bands - 1]
    n : int
        Photons of the band.
    precision : numpy.dtype
        float32 or float64, that of the source.

    Examples
    --------
    >>> import ctypes
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components="uniform")
    >>> out = np.empty((3, 100), np.float32)
    >>> with scene.source(seed=1).c_source(band=0) as c:
    ...     types = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64] + 3 * [
    ...         ctypes.c_void_p
    ...     ]
    ...     fill = ctypes.CFUNCTYPE(ctypes.c_int64, *types)(c.address)
    ...     print(fill(c.context, 950, 100, *(row.ctypes.data for row in out)))
    50
    """

    def __init__(self, emitter: Emitter, band: int) -> None:
        _require_host(emitter.plan)
        self.band = band
        self.n = emitter.n_photons(band)
        self.precision = emitter.dtype
        self._block, function = _range_function(emitter, band)
        _kept.append(self._block.words)  # a few hundred bytes, so that a call after the end finds the word that says so
        self.address = int(function.compiled.address)
        self.context = self._block.address
        self._finalizer = weakref.finalize(self, self._block.words.__setitem__, 0, 0)

    def __repr__(self) -> str:
        return (
            f"<CSource: band {self.band}, {self.n} photons, {self.precision}, {'closed' if self.is_closed else 'open'}>"
        )

    @cached_property
    def numbers_address(self) -> int:
        """Address of the C function of the numbers, which is compiled at the first use."""
        signature = numbers_signature(self._block.kinds, self.precision)
        return int(_compiled_once("numbers", (), signature).compiled.address)

    def __enter__(self) -> CSource:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called."""
        return not self._finalizer.alive

    def close(self) -> None:
        """End the source and drop its tables; calls from now on return `AOMC_SKY_CLOSED`."""
        self._finalizer()
        self._block.arguments = ((), ())
