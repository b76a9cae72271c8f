"""A band's photons inside another code's own loop: jitted functions for numba."""

from __future__ import annotations

import threading
from functools import cached_property
from typing import Any

import numpy as np

from aomc_sky.emission.emitter import Emitter
from aomc_sky.errors import UsageError
from aomc_sky.plan.plan import Plan
from aomc_sky.whole_number import as_index

try:
    from aomc_sky.emission.kernels.sampler import (
        JittedNext,
        compile_next,
        make_fill,
        make_patch,
        make_sample,
        next_signature,
    )
    from aomc_sky.kernels.arguments import fixed_block, typed, words_of
    from aomc_sky.kernels.jit import is_off
except (ImportError, AttributeError) as error:
    raise UsageError(
        f"hosts need a name that the installed numba does not have ({error})",
        "take photons in batches, or install numba 0.68",
    ) from error

_kept: list[Any] = []
"""Tables of compiled code. They live as long as the process, because the end of machine code is unknown."""


def _require_host(plan: Plan, *, weighted: bool) -> None:
    """Refuse plans whose weights are no cells' or unknown to the host, and all plans if the compiler is off."""
    if plan.weight_has_mu.any():
        raise UsageError(
            "photons that are launched by solid angle have weights of their own, which no cell has",
            "take photons in batches, or from a source file",
        )
    if plan.weight(0) is not None and not weighted:
        raise UsageError(
            "the photons of this source have weights, without which the light is wrong",
            "write numba_sampler(band, weighted=True), and count photon i with weights[patch(i)]",
        )
    if is_off():
        raise UsageError("hosts need numba's compiler", "unset NUMBA_DISABLE_JIT, or take photons in batches")


def _replicate(plan: Plan, replicate: int | None) -> int:
    """The replicate that a host asks for; a UsageError where there are several and it names none."""
    if replicate is None and plan.replicates > 1:
        raise UsageError(
            f"this source has {plan.replicates} replicates, and a sampler has one",
            f"write numba_sampler(band, replicate=r), 0 to {plan.replicates - 1}",
        )
    found = 0 if replicate is None else as_index(replicate, "replicate")
    if not 0 <= found < plan.replicates:
        raise IndexError(f"replicate {found} does not exist; they run from 0 to {plan.replicates - 1}")
    return found


class _Block:
    """Arguments of two kernels, the numbers and another one, at a fixed address."""

    def __init__(self, number_arguments: tuple[object, ...], photon_arguments: tuple[object, ...]) -> None:
        self.arguments = arguments = (number_arguments, photon_arguments)
        self.kinds = typed(arguments)
        self.words = np.array(words_of(arguments), dtype=np.uint64)

    def as_function(self) -> Any:
        """A jitted function that returns the block, which then lives as long as the process."""
        _kept.append((self.words, self.arguments))
        return fixed_block(self.kinds, int(self.words.ctypes.data))


_lock = threading.Lock()
_compiled: dict[tuple[str, tuple[str, ...], object], JittedNext] = {}


def _range_function(emitter: Emitter, band: int) -> tuple[_Block, JittedNext]:
    """The block of a band and the function that reads it, compiled once per process and set of types."""
    kernel, arguments = emitter.host_arguments(band)
    block = _Block(emitter.number_arguments(band), arguments)
    key = (kernel, emitter.hooks, next_signature(block.kinds, emitter.dtype))
    with _lock:
        if key not in _compiled:
            _compiled[key] = JittedNext(compile_next(*key), key[-1])
        return block, _compiled[key]


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
        Numbers that each photon carries; see `PhotonSource.photons`. [0 to 3]
    replicate : int
        The replicate whose photons these are; they count from its first one.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components="uniform")
    >>> sampler = scene.source(seed=1).numba_sampler(band=0)
    >>> ux, uy, uz = sampler.sample(0)  # as well in a loop that numba compiles
    >>> uz < 0, sampler.n
    (True, 1000)
    """

    def __init__(
        self, emitter: Emitter, band: int, numbers: int = 0, *, weighted: bool = False, replicate: int | None = None
    ) -> None:
        _require_host(emitter.plan, weighted=weighted)
        self._emitter = emitter
        self.band, self.replicate = band, _replicate(emitter.plan, replicate)
        self._number = self.replicate * emitter.plan.n_bands + band
        self.n = emitter.n_photons(self._number)
        self.precision = emitter.dtype
        self.numbers = numbers
        self._weighted = weighted

    def __getstate__(self) -> dict[str, Any]:  # functions hold addresses of this process: another one makes its own
        how = {"weighted": self._weighted, "replicate": self.replicate}
        return {"plan": self._emitter.plan, "band": self.band, "numbers": self.numbers, "how": how}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(Emitter(state["plan"]), state["band"], state["numbers"], **state["how"])  # type: ignore[misc]

    @property
    def weights(self) -> np.ndarray:
        """Weight of the photons of each cell, precision of the source, (n_cell,); 1 without a bias."""
        plan = self._emitter.plan
        weight = plan.weight(self.band)
        return np.ones(plan.n_cells, self.precision) if weight is None else weight.astype(self.precision)

    @cached_property
    def patch(self) -> Any:
        """Jitted ``patch(i) -> int``: the cell of photon i, as `PhotonBatch.patch` has it."""
        block = _Block((), self._emitter.patch_arguments(self._number))
        return make_patch(block.as_function(), self.n)

    def __repr__(self) -> str:
        numbers = f", {self.numbers} numbers each" if self.numbers else ""
        replicate = f", replicate {self.replicate}" if self._emitter.plan.replicates > 1 else ""
        return f"<NumbaSampler: band {self.band}{replicate}, {self.n} photons, {self.precision}{numbers}>"

    @cached_property
    def sample(self) -> Any:
        """Jitted ``sample(i) -> (ux, uy, uz)``: the travel direction of photon i, as `PhotonSource.photons` gives it.

        Its numbers, where the sampler was asked for any, follow: ``(ux, uy, uz, n1, n2)``.
        The index is an integer, 0 to n - 1; any other raises IndexError, a float or bool TypeError
        when it is compiled. Random access, no state, no GIL.
        """
        photon_arguments = self._emitter.photon_arguments(self._number)
        _, *words, jitter = self._emitter.number_arguments(self._number)
        number_arguments = (self.precision.type(0), photon_arguments[0], *words, jitter or None)
        block = _Block(number_arguments if self.numbers else (), photon_arguments)
        return make_sample(self._emitter.hooks, block.as_function(), self.n, self.numbers)

    @cached_property
    def fill(self) -> Any:
        """Jitted ``fill(start, out) -> int``: write the directions of the photons from `start` on; return how many.

        `out` is a C-contiguous array (3 + numbers, n) of the source's precision, whose rows become ux, uy, uz and the
        numbers; another type is a typing error. Beyond the end of the band fewer photons come, and none from there on.
        A negative `start` raises IndexError.
        """
        block, function = _range_function(self._emitter, self._number)
        return make_fill(function, block.as_function(), self.n, self.precision, self.numbers)
