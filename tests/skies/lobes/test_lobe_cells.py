"""Photons of lobes: compiled and plain forms agree to the bit, any split gives the same photons, hard points."""

import bisect
import dataclasses
import functools
import itertools

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law
from aomc_sky.errors import SceneError
from aomc_sky.kernels.jit import shared
from aomc_sky.plan.laws import law_of
from aomc_sky.skies.lobes.envelope import LAWS
from aomc_sky.skies.lobes.kernels import law as plain_lobe
from aomc_sky.skies.lobes.law import LobeTables
from tests.support.emitted import empty
from tests.support.lobes import lobe_components
from tests.support.sampled import scene

SCENES = ("one lobe", "lobes", "perez and lobes", "beam, solid angle and lobes")


@functools.cache
def scenes():
    sun = {"sun_zenith_rad": 0.7, "sun_azimuth_rad": 0.2}
    perez = sky.PerezSky(**sun, epsilon=8.0, delta=0.1, grid=sky.PatchGrid.regular(6, 5)).lower(500)
    beam = sky.DirectBeam(sun_zenith_deg=35, sun_azimuth_deg=200).lower(500)
    solid = sky.UniformSky(per_solid_angle=True).lower(500)
    chosen = (components(LOBES[2:3]), components(), (*perez, *components()), (*beam, *components(), *solid))
    return dict(zip(SCENES, chosen, strict=True))


JIT = not numba.config.DISABLE_JIT
N = 20_000 if JIT else 200
LOBES = (
    ("beckmann", 0.3, 0.2, (0.9, 0.3, 0.2, 0.1)),
    ("hg", 0.0, 0.0, (1.0, 0.0, 0.0, 0.0)),
    ("ggx", 0.3, 0.3, (0.8, 0.5, 0.1, 0.2)),
    ("hg", 0.9, 0.0, (1.0, 1.0, 0.0, 0.0)),
    ("hg", 1 - 1e-14, 0.0, (1.0, 1.0, 0.0, 0.0)),
    ("ggx", 1e-4, 1.0, (1.0, 0.9, 0.3, 0.0)),
    ("ggx", 0.1, 1e3, (0.4, 0.9, 0.1, 0.0)),
    ("beckmann", 0.3, 0.3, (0.5, 0.8, 0.1, 0.0)),
    ("hg", 1e-8, 0.0, (0.1, 0.9, 0.1, 0.0)),
)


def components(chosen=LOBES):
    """Lobes with about equally many photons each."""
    columns = dict(zip(("kinds", "param0", "param1", "quaternion"), map(list, zip(*chosen, strict=True)), strict=True))
    names = [f"lobe {i}" for i in range(len(chosen))]
    parts = lobe_components(names=names, irradiance=np.ones((len(chosen), 1)), **columns)
    names = ("name", "law", "mass", "cell", "shared", "bounds")
    return tuple(Component(strength=np.ones(1), **{n: getattr(p, n) for n in names}) for p in parts)


def mean_mu(lobe):
    """Mean cosine over a million photons of each of eight seeds; standard error 3e-5."""
    chosen = scene((lobe,), 10**6)
    return np.mean([-np.mean(chosen.source(seed=s).photons().uz, dtype=np.float64) for s in range(8)])


def test_means_are_exact():
    """The means of the law stand in the cells."""
    for case in LOBES:
        (lobe,) = components((case,))
        exact = scene((lobe,), 10).source().exact_moments(0)
        assert (exact.mean_mu, exact.mean_inverse_mu) == (lobe.cell[0, 0], lobe.cell[0, 2])
        if JIT:
            mu = -scene((lobe,), N).source(seed=2).photons().uz.astype(np.float64)
            assert abs(mu.mean() - exact.mean_mu) < 3 * mu.std() / np.sqrt(N)


@pytest.mark.skipif(not JIT, reason="long without the JIT")
def test_small_asymmetry_is_not_isotropy():
    """A switch to isotropy below 1e-3 would move the mean cosine by 1.5e-4."""
    even, tilted = (components((("hg", g, 0.0, (1.0, 0.0, 0.0, 0.0)),))[0] for g in (0.0, 9e-4))
    assert tilted.cell[0, 0] - even.cell[0, 0] > 1.4e-4
    assert mean_mu(tilted) == pytest.approx(tilted.cell[0, 0], abs=7e-5)
    assert abs(mean_mu(even) - tilted.cell[0, 0]) > 7e-5


EXTREMES = np.array([0, 1, 2**63 - 1, 2**63, 2**64 - 1], np.uint64)


def test_extreme_words_give_directions():
    """Every corner of every bin is a finite direction; no number reaches log(0) or a division by 0."""
    tables = LobeTables.of(scene(components(), 10).source().plan.components).tables
    for lobe in range(len(LOBES)):
        bits = int(tables[0][4 * lobe + 1])
        corners = [(np.uint64(i) << np.uint64(64 - bits)) | (EXTREMES >> np.uint64(bits)) for i in range(1 << bits)]
        first, second = (x.ravel() for x in np.meshgrid(np.concatenate(corners), EXTREMES))
        directions, bound = plain_lobe._fallen(None, first, second, np.full(first.size, lobe), tables)
        np.testing.assert_allclose(np.sqrt(sum(x * x for x in directions)), 1, atol=6e-16)
        assert np.all(-directions[2] <= bound * (1 + 1e-12))


def test_a_lobe_has_bounds_and_no_centre():
    with pytest.raises(SceneError, match="lobe 0"):
        scene(components(), 10).source(placement="centre")
    (lobe,) = components(LOBES[:1])
    with pytest.raises(ValueError, match="needs both shared and bounds"):
        Component(name="x", law=Law.HG, strength=np.ones(1), mass=np.ones((1, 1)), cell=lobe.cell, shared=lobe.shared)


def test_the_laws_of_lobes_are_those_with_the_hook():
    assert set(LAWS.values()) == {law for law in Law if law_of(law).hook == "lobes"}


OUTSIDE = {"least b": (0, -1e-6), "b": (0, 0.5), "width": (1, 2.0), "width below 0": (1, -0.1), "a": (2, 0.7)}
OUTSIDE |= {"half a turn": (4, 0.6), "turned back": (4, -0.1), "sine": (5, 1.1), "cosine": (6, -1.1), "bound": (7, 0.0)}
OUTSIDE |= {"no bins": (3, 0.0), "half a bin": (3, 0.5), "bins": (3, 2.0**17), "not a number": (7, np.nan)}


@pytest.mark.parametrize(("column", "value"), OUTSIDE.values(), ids=OUTSIDE)
def test_cells_outside_the_envelope_are_refused(column, value):
    """A plan with b below 0 had photons that were no number; with other ones they had another law."""
    (lobe,) = components(LOBES[2:3])
    bounds = lobe.bounds.copy()
    bounds[1, column] = value
    bad = dataclasses.replace(lobe, bounds=bounds)
    with pytest.raises(sky.InputFileError, match=r"error\[E954\]: bounds_0: "):
        scene((bad,), 10).source()
    with pytest.raises(SceneError, match="lobe 'lobe 0': expected "):
        LobeTables.of((bad,))


def exact_begin(b, n, bits, offset):
    """Photons of a lobe before bin b, in Python's integers: floor(n b / 2^m + offset)."""
    unit = bits + plain_lobe.OFFSET_BITS
    return ((n * b << unit) // 2**bits + offset) >> unit


def falls_of(n, bits, offset, before):
    """`bin_proposals` and `bins_per_photon` of one lobe, from a plan whose lobe has 2^bits bins."""
    word = np.uint64(offset << (64 - bits - plain_lobe.OFFSET_BITS))
    ranges = np.array([0, bits, 0, 0], np.uint64)
    tables = LobeTables(lobe=np.array([-1, 0]), cell=np.array([1]), tables=(ranges,))
    proposals, lines = tables.bin_proposals(np.array([0, before, before + n]), np.array([word], np.uint64))
    assert int(proposals[3]) == offset
    return (*proposals, *lines)


@shared
def _single(rank, before, each, rest, offset, bits, bins_per_photon, begin):
    return plain_lobe.bin_of_rank(rank, before, each, rest, offset, bits, bins_per_photon, begin)


COUNTS = (1, 2, 3, 63, 64, 100, 1023, 1025, 10**6 + 7, 2**32 - 1, 2**40 + 1, 2**53 + 1, 2**62 - 7, 2**62)


@pytest.mark.parametrize("bits", [6, 10, 11, 16])
@pytest.mark.parametrize("n", COUNTS)
def test_bins_of_ranks_are_exact(n, bits):
    """At the first and last rank of bins, for the least, the largest and another offset; plain and compiled."""
    last, size = (1 << bits + plain_lobe.OFFSET_BITS) - 1, 1 << bits
    before = 0 if n > 2**61 else 12345
    for offset in (0, last, last // 3):
        arguments = falls_of(n, bits, offset, before)
        bins = sorted({0, 1, size // 3, size // 2, size - 1, *(b * size // 50 for b in range(50))})
        begins = {exact_begin(b, n, bits, offset) for b in bins}
        ranks = sorted({r for begin in begins for r in (begin - 1, begin, begin + 1) if 0 <= r < n} | {0, n - 1})
        ends = [exact_begin(b + 1, n, bits, offset) for b in range(size)]
        assert ends[-1] == n
        wanted = [bisect.bisect_right(ends, r) for r in ranks]
        assert plain_lobe.bin_of_rank(np.array(ranks, np.uint64) + np.uint64(before), *arguments).tolist() == wanted
        if JIT:
            assert [_single(np.uint64(r + before), *arguments) for r in ranks] == wanted


def test_planted_offset_left_out_moves_bins():
    """With fewer photons than bins, and without an offset, the lobe's first bins are empty for ever."""

    def first_bin(offset):
        return int(plain_lobe.bin_of_rank(np.zeros(1, np.uint64), *falls_of(1, 10, offset, 0))[0])

    assert first_bin(0) == 1023
    assert {first_bin(offset) for offset in range(0, 1 << 40, 1 << 30)} == set(range(1024))


@pytest.mark.parametrize("compiled", [False, True])
def test_any_split_gives_the_same_photons(compiled):
    source = scene(scenes()["lobes"], N).source(seed=4)
    fill = source._emitter.fill_compiled if compiled else source._emitter.fill_plain
    whole, parts = empty(source, N), empty(source, N)
    fill(0, 0, whole)
    for lo, hi in itertools.pairwise((0, 1, 8, N // 7, N // 7 + 3, N // 2, N)):
        fill(0, lo, {name: array[lo:hi] for name, array in parts.items()})
    for name, values in whole.items():
        np.testing.assert_array_equal(values, parts[name])
