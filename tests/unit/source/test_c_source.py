"""The C function of a band: the photons of the source to the bit, from any thread, and clear answers to wrong calls."""

import ctypes
import gc
import re
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.kernels.hosts import next_photons
from tests.support.host_scenes import N, directions, source

EACH = [
    ("table", {}),
    ("narrow cells", {"order": "patch", "precision": "float64"}),
    ("everything", {}),
]
CLOSED, BAD_START, BAD_COUNT, NO_ARRAY = -1, -2, -3, -4


def function_of(c_source):
    kind = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 3)
    return kind(c_source.address)


def call(c_source, start, n, out):
    pointers = [row.ctypes.data for row in out]
    return function_of(c_source)(c_source.context, start, n, *pointers)


@pytest.mark.parametrize(("name", "options"), EACH)
def test_same_bits(name, options):
    bands = source(name, [N, 40_000], **options)
    wanted = directions(bands.photons(1))
    with bands.c_source(1) as c_source:
        assert (c_source.n, c_source.band, c_source.precision) == (40_000, 1, bands.dtype)
        out = np.zeros_like(wanted)
        assert call(c_source, 0, 40_000, out) == 40_000
        assert out.tobytes() == wanted.tobytes()
        for start, stop in np.sort(np.random.default_rng(3).integers(0, 40_000, (10, 2)), axis=1):
            part = np.zeros((3, stop - start), bands.dtype)
            assert call(c_source, start, stop - start, part) == stop - start
            assert part.tobytes() == wanted[:, start:stop].tobytes()


def test_threads_take_disjoint_ranges():
    bands = source("table", 500_000)
    out = np.zeros((3, 500_000), np.float32)
    with bands.c_source() as c_source, ThreadPoolExecutor(4) as pool:
        starts = range(0, 500_000, 7919)
        delivered = list(pool.map(lambda k: call(c_source, k, 7919, out[:, k : k + 7919]), starts))
    assert sum(delivered) == 500_000
    assert out.tobytes() == directions(bands.photons()).tobytes()


def test_answers_to_ends_and_wrong_calls():
    bands = source("table", [1000, 0])
    c_source = bands.c_source()
    out = np.full((3, 10), np.float32(7))
    assert call(c_source, 0, 0, out) == call(c_source, 1000, 10, out) == call(c_source, 2**62, 2**62, out) == 0
    assert call(c_source, -1, 10, out) == call(c_source, -(2**63), -1, out) == BAD_START
    assert call(c_source, 0, -1, out) == BAD_COUNT
    assert function_of(c_source)(None, 0, 10, *[row.ctypes.data for row in out]) == CLOSED
    for missing in range(3):
        pointers = [None if k == missing else out[k].ctypes.data for k in range(3)]
        assert function_of(c_source)(c_source.context, 0, 10, *pointers) == NO_ARRAY
    assert np.all(out == 7)
    assert call(c_source, 994, 10, out) == 6
    assert np.all(out[:, 6:] == 7)
    assert call(bands.c_source(1), 0, 10, out) == 0
    with pytest.raises(IndexError, match="bands run from 0 to 1"):
        bands.c_source(2)


def test_closed_and_dropped():
    bands, out = source("table"), np.zeros((3, 4), np.float32)
    first, second, third = (bands.c_source() for _ in range(3))
    assert not first.is_closed
    first.close()
    first.close()
    assert first.is_closed
    assert "closed" in repr(first)
    assert call(first, 0, 4, out) == CLOSED
    function, context = function_of(second), second.context
    del second
    gc.collect()
    assert function(context, 0, 4, *[row.ctypes.data for row in out]) == CLOSED
    del bands
    gc.collect()
    assert call(third, 0, 4, out) == 4


def test_replicates_are_refused():
    bands = source("table", replicates=4)
    for make in (bands.c_source, bands.numba_sampler):
        with pytest.raises(sky.errors.UsageError, match="replicates=1"):
            make()


def test_header_and_fortran_name_the_same_answers():
    header, module = ((include_dir() / name).read_text() for name in ("aomc_sky.h", "aomc_sky.f90"))
    for name in ("CLOSED", "BAD_START", "BAD_COUNT", "NO_ARRAY"):
        value = getattr(next_photons, name)
        assert re.search(rf"AOMC_SKY_{name} = {value}\b", header)
        assert re.search(rf"sky_{name.lower()} = {value}\b", module)
