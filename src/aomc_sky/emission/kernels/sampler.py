"""Photons for a transport code, one by its index or a range of them; the same photons as `emit` makes in blocks."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from aomc_sky.emission.kernels.emit import direction_of, emit, emit_runs, emit_with
from aomc_sky.emission.kernels.hooks import with_hooks
from aomc_sky.emission.kernels.numbers import numbers_of_photons, three_numbers
from aomc_sky.kernels.arguments import Block, block_arguments
from aomc_sky.kernels.arithmetic.constants import U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import sincos_turned, sincos_turned_any, sincos_turned_narrow, unit
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.cells.blocks import cell_of_table, rank_of_photon, ring_offset_of_table, slot_of_rank, split_place
from aomc_sky.kernels.cells.laws import from_mu, from_mu2, sloped
from aomc_sky.kernels.jit import c_function, inlined, inner, shared, shared_inlined

from numba import carray, from_dtype, types
from numba.core.types import ExternalFunctionPointer
from numba.extending import overload

perez_hook: Any = None
lobes_hook: Any = None
"""None here: `photon_at_with` swaps them in copies of `photon_at`; see `hooks`."""


@inner
def _main_law(h0, h1, h2, h3, t0, t1, u, v, is_in_mu, is_any_width, is_narrow):
    if is_in_mu is not None:
        sine, cosine = sincos_turned_any(t0, t1, h3, v)
        return from_mu(h0, h1, h2, u, sine, cosine)
    if is_any_width is not None:
        sine, cosine = sincos_turned_any(t0, t1, h3, v)
    elif is_narrow is not None:
        sine, cosine = sincos_turned_narrow(t0, t1, h3, v)
    else:
        sine, cosine = sincos_turned(t0, t1, h3, v)
    return from_mu2(h0, h1, h2, u, sine, cosine)


def photon_at(
    i,
    order,
    shifts,
    steps,
    key,
    band,
    jitter,
    cumulative,
    guide,
    guide_shift,
    place,
    words,
    values,
    law,
    perez,
    lobes,
    slopes,
    is_in_mu,
    is_any_width,
    is_narrow,
):
    """Return the travel direction of photon i (uint64) of a band; the other parameters are those of `Band.known`."""
    if order is None:
        rank = i
    else:
        rank = rank_of_photon(i, order)
    slot = slot_of_rank(rank, cumulative, guide, guide_shift)
    head, tail = split_place(place[slot])
    h0, h1, h2, h3, t0, t1 = cell_of_table(values, head, tail)
    if jitter is None:
        a, b = shifts[0] + rank * steps[0], shifts[1] + rank * steps[1]
        u, v = unit(a, h0), unit(b + ring_offset_of_table(words, head, h0), h0)
    else:
        a, b = philox_pair(key, rank, band, ZERO)
        u, v = unit(a, h0), unit(b, h0)
    if slopes is not None:
        u, v = sloped(u, v, slopes[slot])
    if perez_hook is not None:
        u, v, jacobian = perez_hook.tilted(u, v, perez[0][slot])
    if law is None:
        x, y, z = _main_law(h0, h1, h2, h3, t0, t1, u, v, is_in_mu, is_any_width, is_narrow)
    else:
        x, y, z = direction_of(law[slot], (h0, h1, h2, h3, t0, t1), u, v, key, rank, band)
    if perez_hook is not None:
        cell = (h0, h1, h2, h3, t0, t1)
        x, y, z = perez_hook.taken_or_replaced(x, y, z, jacobian, slot, rank, cell, perez, key, band, jitter)
    if lobes_hook is not None and lobes[0][slot] >= 0:
        lx, ly, lz = lobes_hook.lobe_photon(lobes[0][slot], a, b, rank, lobes, key, band, jitter)
        x, y, z = type(h0)(lx), type(h0)(ly), type(h0)(lz)
    return x, y, z


@cache
def photon_at_with(*hooks: str) -> Any:
    """`photon_at` compiled with these hooks."""
    return inlined(with_hooks(photon_at, hooks))


def _index(i: Any) -> Any:
    """The index of a photon as uint64, for compiled code; numbers that are no integers do not compile."""


@overload(_index)
def _compiled_index(i):
    if not isinstance(i, types.Integer):
        raise TypeError(f"the index of a photon is an integer, got {i}")
    return lambda i: U64(i)  # noqa: PLW0108  numba wants a function


def make_sample(hooks: tuple[str, ...], block: Any, n: int, n_numbers: int = 0) -> Any:
    """Return the jitted `sample(i)` of a band with n photons.

    `block` gives the arguments of `three_numbers` after the index, of which there are none without numbers, and those
    of `photon_at`.
    """
    photon, end = photon_at_with(*hooks), np.uint64(n)
    if n_numbers:

        @shared_inlined
        def sample_with_numbers(i):
            if _index(i) >= end:
                raise IndexError("photon index outside the band")
            number_arguments, photon_arguments = block_arguments(block())
            return photon(_index(i), *photon_arguments) + three_numbers(_index(i), *number_arguments)[:n_numbers]

        return sample_with_numbers

    @shared_inlined
    def sample(i):
        if _index(i) >= end:
            raise IndexError("photon index outside the band")
        return photon(_index(i), *block_arguments(block())[1])

    return sample


def make_patch(block: Any, n: int) -> Any:
    """Return the jitted `patch(i)` of a band with n photons; `block` gives `Emitter.patch_arguments`."""
    end = np.uint64(n)

    @shared_inlined
    def patch(i):
        if _index(i) >= end:
            raise IndexError("photon index outside the band")
        order, cumulative, guide, guide_shift, cells = block_arguments(block())[1]
        return _cell_of(_index(i), order, cumulative, guide, guide_shift, cells)

    return patch


@inlined
def _cell_of(i, order, cumulative, guide, guide_shift, cells):
    """The cell of photon i (uint64)."""
    rank = i if order is None else rank_of_photon(i, order)
    slot = slot_of_rank(rank, cumulative, guide, guide_shift)
    return np.int64(slot) if cells is None else np.int64(cells[slot])


def make_fill(next_photons: Any, block: Any, n: int, precision: np.dtype, n_numbers: int = 0) -> Any:
    """Return the jitted `fill(start, out)` of a band with n photons; `next_photons` is the function for its block."""
    rows, end = 3 + n_numbers, np.int64(n)
    refusal = f"out must have the shape ({rows}, n)"

    @shared
    def fill(start, out):
        if start < 0:
            raise IndexError("the first photon has index 0")
        if out.shape[0] != rows:
            raise ValueError(refusal)
        n = min(out.shape[1], end - start)
        if n <= 0:
            return 0
        next_photons(block(), start, n, out[0].ctypes, out[1].ctypes, out[2].ctypes)
        if rows > 3:
            first, second, third = out[3], out[min(4, rows - 1)], out[rows - 1]
            second, third = second[: n if rows > 4 else 0], third[: n if rows > 5 else 0]
            numbers_of_photons(U64(start), first[:n], second, third, *block_arguments(block())[0])
        return n

    fill.compile((types.int64, types.Array(from_dtype(precision), 2, "C")))
    fill.disable_compile()  # the tables are read in this precision alone
    return fill


# A range of photons: the kernel behind an address, for numba's `fill`.

_CHUNK = 16384  # so many cells, which hosts do not get, stay in the cache


def _next(block, start, count, ux, uy, uz):
    """Write the directions of the photons [start, start + count), which the band has; count is above 0."""
    x, y, z = carray(ux, count), carray(uy, count), carray(uz, count)
    cell = np.empty(min(count, _CHUNK), np.int32)
    arguments = block_arguments(block)[1]
    memory = np.zeros(arguments[0], np.uint64)
    for lo in range(0, count, _CHUNK):
        hi = min(lo + _CHUNK, count)
        emit(U64(start + lo), x[lo:hi], y[lo:hi], z[lo:hi], cell[: hi - lo], memory, *arguments[1:])


def next_signature(kinds: Any, precision: np.dtype) -> Any:
    """Numba's signature of `next` for arguments of these types and a precision."""
    pointer = types.CPointer(from_dtype(precision))
    return types.void(Block(kinds), types.int64, types.int64, pointer, pointer, pointer)


def compile_next(kernel: str, hooks: tuple[str, ...], signature: Any) -> Any:
    """Return the function `next(block, start, count, ux, uy, uz)` over a kernel of the emission.

    A block holds the arguments of `numbers_of_photons`, then the words of memory and the arguments of the kernel.
    """
    if kernel == "emit_runs":
        return c_function(with_hooks(_next, ("runs",), emit=emit_runs), signature)  # no slice, but a name of its own
    return c_function(with_hooks(_next, hooks, emit=emit_with(*hooks)), signature)


def _address_of(function: JittedNext) -> int:
    return int(function.compiled.address)


class JittedNext:
    """A compiled function as jitted code calls it: by its address, without compiling it again."""

    def __init__(self, compiled: Any, signature: Any) -> None:
        self.compiled = compiled
        self._numba_type_ = ExternalFunctionPointer(signature, get_pointer=_address_of)
