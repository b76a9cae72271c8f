"""Programs over aomc_sky.h, as libraries that the tests call, and sources that between them take every way."""

import ctypes
import dataclasses
import functools
import itertools
import shutil
from typing import get_args

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.component import Law
from aomc_sky.emission.source_file import tables_of
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import OrderWord, PlacementWord, PrecisionWord
from tests.support import fairness
from tests.support.builds import once
from tests.support.host_scenes import WAVEBANDS, components, disc, perez, table
from tests.support.shared import REPOSITORY

DRIVER = REPOSITORY / "tests" / "reference" / "source_driver.c"
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc not installed")
FLAGS_OF_HOST = "-DAOMC_SKY_FLAGS_OF_HOST"
"""Leaves the header's own pragmas out, so that flags of a test have their way."""


RECORDS = 192
"""Where the records of the bands begin in a file."""

STRICT = "-Wall -Wextra -pedantic -Wshadow -Werror"


@functools.cache
def _built(flags, compiler):
    language = ["-x", "c++"] if compiler.endswith("++") else []
    options = [*flags.split(), *STRICT.split(), "-fPIC", f"-I{include_dir()}"]
    compile_it = [compiler, *options, "-c", "-o", "driver.o", *language, str(DRIVER)]
    # linked without the flags: a library linked with -ffast-math makes the process that loads it flush subnormals to 0
    link_it = [compiler, "-shared", "-o", "driver.so", "driver.o", "-lm"]
    return Driver(ctypes.CDLL(str(once(compile_it, link_it) / "driver.so")))


def built(flags="-O2", compiler="gcc"):
    """The driver, which uses the whole header, compiled with flags and without a warning, once a run."""
    return _built(flags, compiler)


@functools.cache
def section_names():
    """Names of the sections in the order of their kinds, which count from 1."""
    emitter = source_of("table", 100)._emitter
    return tuple(tables_of(emitter, 0, emitter._packed(0)))


def aligned(data):
    memory = np.zeros(len(data) + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    memory[begin : begin + len(data)] = np.frombuffer(data, np.uint8)
    return memory[begin : begin + len(data)]


class Driver:
    """tests/reference/source_driver.c as functions of arrays."""

    def __init__(self, library):
        self.library = library
        for name in ("fill", "numbers", "n", "fill_weighted", "positions", "stream"):
            if hasattr(library, f"driver_{name}"):  # the driver of a GPU lacks some
                getattr(library, f"driver_{name}").restype = ctypes.c_int64
        if hasattr(library, "driver_photon_light"):
            library.driver_photon_light.restype = ctypes.c_double
        library.driver_checksum.restype = ctypes.c_uint64
        library.driver_message.restype = ctypes.c_char_p
        self._data = np.zeros(0, np.uint8)

    def view(self, data):
        """Take the bytes of a file; returns the code."""
        self._data = aligned(data)
        return int(self.library.driver_view(_address(self._data), ctypes.c_uint64(len(data))))

    def load(self, path):
        return int(self.library.driver_load(str(path).encode()))

    def open(self, source, band=0):
        """Take a source and one of its bands."""
        code = self.view(source if isinstance(source, bytes) else source.to_bytes())
        assert code == 0, self.message(code)
        assert self.band(band) == 0

    def band(self, band):
        return int(self.library.driver_band(ctypes.c_int32(band)))

    def weighted_band(self, band):
        return int(self.library.driver_weighted_band(ctypes.c_int32(band)))

    @property
    def photon_light(self):
        return float(self.library.driver_photon_light())

    def replicate(self, band, replicate, *, weighted=False):
        numbers = ctypes.c_int32(band), ctypes.c_int32(replicate)
        return int(self.library.driver_replicate(*numbers, ctypes.c_int(weighted)))

    def weights(self, uz, patch):
        """Weights of photons one by one, float64, from their directions and patches."""
        patch, uz, weight = np.ascontiguousarray(patch, np.int32), np.ascontiguousarray(uz), np.empty(patch.size)
        is_double, n = ctypes.c_int(uz.dtype == np.float64), ctypes.c_int64(patch.size)
        self.library.driver_weight(is_double, n, *map(_address, (uz, patch, weight)))
        return weight

    def components(self, patch):
        """Numbers of the components of patches."""
        return np.array([self.library.driver_component(ctypes.c_int32(one)) for one in patch.tolist()])

    def fill_weighted(self, start, rows, patch, weight, count=None):
        """Directions from `start` on into the rows (3, n), with patches and weights; either may be None."""
        columns = *rows, patch, weight
        return self._into(self.library.driver_fill_weighted, start, rows, count, columns)

    @property
    def n(self):
        return int(self.library.driver_n())

    @property
    def witness(self):
        return int(self.library.driver_witness())

    def fill(self, start, rows, count=None):
        """Directions from `start` on into the rows (3, n)."""
        return self._into(self.library.driver_fill, start, rows, count)

    def numbers(self, start, rows, count=None):
        """Numbers from `start` on into the rows (3, n)."""
        return self._into(self.library.driver_numbers, start, rows, count)

    def _into(self, function, start, rows, count, columns=None):
        size = rows.shape[1] if count is None else count
        is_double = ctypes.c_int(rows.dtype == np.float64)
        columns = rows if columns is None else columns
        return int(function(is_double, ctypes.c_int64(start), ctypes.c_int64(size), *map(_address, columns)))

    def take_bands(self, *files):
        """Take the bands of files, one file after the other, for a stream."""
        self._kept = []
        for data in files:
            assert self.view(data) == 0
            assert self.library.driver_take_bands(len(self._kept)) == 0
            self._kept.append(self._data)

    def stream(self, start, stop, room):
        """Particles of a stream over these bands: (6, n) floats and (4, n) integers, or a code; then their total."""
        floats, whole = np.full((6, room), np.nan), np.full((4, room), -9, np.int64)
        bounds, total = map(ctypes.c_int64, (start, stop, room)), ctypes.c_int64(-9)
        n = int(self.library.driver_stream(*bounds, _address(floats), _address(whole), ctypes.byref(total)))
        made = (floats[:, :n], whole[:, :n]) if n >= 0 else n
        return made, total.value

    def positions(self, start, x, y, count=None):
        """Positions from `start` on into columns; either may be None."""
        one = y if x is None else x
        return self._into(self.library.driver_positions, start, one[np.newaxis], count, (x, y))

    def position(self, index, dtype):
        """Positions (n, 2) of single photons."""
        xy = np.empty((index.size, 2), dtype)
        is_double, index = ctypes.c_int(xy.dtype == np.float64), np.ascontiguousarray(index, np.int64)
        self.library.driver_position(is_double, _address(index), ctypes.c_int64(index.size), _address(xy))
        return xy

    def at(self, index, dtype):
        """Directions and numbers (6, n) of single photons, and their patches."""
        rows, patch = np.empty((6, index.size), dtype), np.empty(index.size, np.int32)
        is_double, index = ctypes.c_int(rows.dtype == np.float64), np.ascontiguousarray(index, np.int64)
        self.library.driver_at(is_double, _address(index), ctypes.c_int64(index.size), _address(rows), _address(patch))
        return rows, patch

    def checksum(self, data):
        return int(self.library.driver_checksum(data, ctypes.c_uint64(len(data))))

    def message(self, code):
        return bytes(self.library.driver_message(ctypes.c_int64(code))).decode()


def _address(array):
    return None if array is None else ctypes.c_void_p(array.ctypes.data)


def same_bits(one, other):
    return np.ascontiguousarray(one).tobytes() == np.ascontiguousarray(other).tobytes()


def compare(driver, source, n=20_000):
    """Assert that `fill`, `at` and `numbers` give the photons of every band; returns how many were compared."""
    assert driver.view(source.to_bytes()) == 0
    done, rng = 0, np.random.default_rng(source.total)
    for band in range(source.n_bands):
        assert driver.band(band) == 0
        total = source.n_photons(band)
        assert driver.n == total
        m = min(n, total)
        start = int(rng.integers(0, total - m + 1))
        batch = source.photons(band, start, start + m, numbers=3)
        expected = np.stack([batch.ux, batch.uy, batch.uz]), np.ascontiguousarray(batch.numbers.T)
        rows = np.empty((3, m), source.dtype)
        assert driver.fill(start, rows) == m
        assert same_bits(rows, expected[0])
        assert driver.numbers(start, rows) == m
        assert same_bits(rows, expected[1])
        single, patch = driver.at(np.arange(start, start + m), source.dtype)
        assert same_bits(single, np.concatenate(expected))
        assert same_bits(patch, batch.patch)
        done += m
    return done


def _sloped():
    flat, rng = table(Law.CELL_MU2, 6, 9), np.random.default_rng(5)
    return (dataclasses.replace(flat, law=Law.CELL_SLOPED, slope=rng.uniform(-0.99, 0.99, (2, 54, 2))),)


def _with_lobes():
    """A Perez sky, a table, a disc and lobes of every kind, in two bands."""
    lobes = [
        dataclasses.replace(one, name=name, strength=np.ones(2), mass=np.ones((2, 1)), irradiance_W_m2_nm=None)
        for name in ("cloud edge", "glow", "band", "at the horizon")
        for one in [fairness.component(fairness.LOBES[name])]
    ]
    return (*perez(6, 5), table(Law.CELL_MU2, 6, 9), *lobes, *disc(20))


MORE = {
    "sloped": _sloped,
    "disc at the horizon": lambda: disc(89.9),
    "wide disc at the horizon": lambda: disc(88, 4.0),
    "wide disc": lambda: disc(30, 4.0),
    "perez in narrow cells": lambda: perez(9, 120),
    "lobes and all": _with_lobes,
    "lobes": lambda: tuple(c for c in _with_lobes() if law_of(c.law).hook == "lobes"),
}
HOST_SCENES = ("table", "narrow cells", "sparse", "wide cells", "solid angle", "disc and table", "everything", "perez")
SCENES = (*HOST_SCENES, *MORE)
LOBES = ("lobes and all", "lobes")
OPTIONS = tuple(get_args(words) for words in (PrecisionWord, OrderWord, PlacementWord))
"""Precisions, orders and placements."""
WAYS = [(name, *way) for name, *way in itertools.product(SCENES, *OPTIONS) if name not in LOBES or way[2] != "centre"]


@functools.cache
def _components(name):
    return MORE[name]() if name in MORE else components(name)


def biased(name, n=20_011, **options):
    """The same with a share for the first component, and an importance of patches."""
    parts, rng = _components(name), np.random.default_rng(6)
    share = {parts[0].name: 0.3} if len(parts) > 1 else None
    importance = {one.name: rng.lognormal(0, 1, one.n_cells) for one in parts if one.grid is not None}
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=n, components=parts)
    return scene.source(seed=9, bias=share, importance=importance or None, **options)


def source_of(name, n=20_011, **options):
    return sky.Scene(wavebands=WAVEBANDS, n_photons=n, components=_components(name)).source(seed=9, **options)
