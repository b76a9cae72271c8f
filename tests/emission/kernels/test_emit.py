"""The compiled emission equals its plain form to the bit, for every law, order, placement and precision."""

import dataclasses
import itertools

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.emission.kernels import batches, plain
from aomc_sky.skies.perez.kernels.cells import tilted
from aomc_sky.skies.perez.law import PerezBounds
from tests.support import source_files
from tests.support.emitted import compared
from tests.support.host_scenes import WAVEBANDS, disc, perez, table
from tests.support.source_files import LOBES, OPTIONS, SCENES, WAYS

JIT = not numba.config.DISABLE_JIT
N = 9001 if JIT else 150
BANDS = [500.0]


MORE = {
    "beam": lambda: disc(35, None),
    "beam and perez": lambda: (*disc(35, None), *perez(6, 2)),
    "faint disc": lambda: (dataclasses.replace(disc(20)[0], strength=np.full(2, 0.03)), table(Law.CELL_MU2, 7, 11)),
    "all cells lit": lambda: (table(Law.CELL_MU2, 1, 3),),
}
"""Beside those of all hosts."""


def source_of(name, n=N, **options):
    if name not in MORE:
        return source_files.source_of(name, n, **options)
    return sky.Scene(wavebands=WAVEBANDS, n_photons=n, components=MORE[name]()).source(seed=9, **options)


def cells_source(cell, mass, n, grid=None):
    many = Component(name="many", law=Law.CELL_MU2, strength=[1.0], mass=mass[None], cell=cell, grid=grid)
    return sky.Scene(wavebands=BANDS, n_photons=n, components=(many,)).source()


COVERING = [
    ("table", "float32", "shuffled", "r2"),
    ("table", "float32", "patch", "r2"),
    ("sloped", "float32", "shuffled", "philox"),
    ("everything", "float64", "patch", "philox"),
    ("lobes", "float32", "shuffled", "r2"),
]
"""Of every kernel and hook one variant: others differ in their types, and take as long to compile."""
OTHERS = [way for way in (*WAYS, *itertools.product(MORE, *OPTIONS)) if way not in COVERING]


@pytest.mark.parametrize(
    ("name", "precision", "order", "placement"),
    [*COVERING, *(pytest.param(*way, marks=pytest.mark.slow) for way in OTHERS)],
)
def test_compiled_equals_plain(name, precision, order, placement):
    source = source_of(name, order=order, placement=placement, precision=precision)
    compared(source, N // 5, N)


def test_the_word_of_a_perez_cell_gives_back_its_tilts():
    """u + k u (1 - u), for v alike, with the tilts k of the plan: numpy and the kernels unpack them by one formula."""
    components = source_of("perez").components
    tilts, words = components[0].bounds[:, 2:].T, PerezBounds.of(components).word
    for cells in (tilts, source_of("perez in narrow cells").components[0].bounds[:, 2:].T):
        assert np.all(np.count_nonzero(cells, axis=1) > 5)  # else the tests above would not see how places are moved
    u, v, jacobian = tilted(np.full(words.size, 0.25), np.full(words.size, 0.875), words)
    np.testing.assert_allclose(u, 0.25 + tilts[0] * 0.25 * 0.75, rtol=1e-14)
    np.testing.assert_allclose(v, 0.875 + tilts[1] * 0.875 * 0.125, rtol=1e-14)
    np.testing.assert_allclose(jacobian, (1 + tilts[0] * 0.5) * (1 - tilts[1] * 0.75), rtol=1e-14)


@pytest.mark.parametrize("precision", ["float32", pytest.param("float64", marks=pytest.mark.slow)])
@pytest.mark.parametrize("n", [N // 60, N])
def test_short_and_long_runs(precision, n):
    """Patch order takes a loop per cell where cells hold many photons, the general way where they do not."""
    for name in ("table", "all cells lit"):
        source = source_of(name, n=n, order="patch", precision=precision)
        for start in (0, n // 3):
            compared(source, start, n)


def test_counts_of_emitted_cells_are_the_counts():
    for name in (*MORE, *SCENES):
        source = source_of(name)
        patches = np.bincount(source.photons().patch, minlength=source.counts.shape[1])
        np.testing.assert_array_equal(patches, source.counts[0])


@pytest.mark.skipif(not JIT, reason="long without the JIT")
@pytest.mark.parametrize(
    ("n_zenith", "n"),
    [
        (300, 2**40 + 12345),  # both; each alone is code of its own
        pytest.param(7, 2**40 + 12345, marks=pytest.mark.slow),
        pytest.param(300, 10**6, marks=pytest.mark.slow),
    ],
)
def test_more_photons_than_32_bits_and_more_cells_than_16_bits(n_zenith, n):
    grid = sky.PatchGrid.regular(n_zenith, n_zenith)
    mass = 0.5 + np.random.default_rng(1).random(grid.n_patches)
    source = cells_source(cells_of_grid(grid), mass, n, grid)
    for start in (0, n - 5000):
        compared(source, start, start + 5000)


# both are code of their own; the gate's leg without the JIT runs them as Python
@pytest.mark.slow
@pytest.mark.parametrize("name", LOBES)
def test_lobes_of_2_to_the_62_photons(name):
    source = source_of(name, 2**62)
    for start in (0, 2**61 + 12345, 2**62 - 500):
        compared(source, start, start + 500)
    assert source.n_photons(0) == 2**62


@pytest.mark.slow
def test_more_words_than_16_bits():
    """Cells that share neither ring nor column need 32-bit positions in the table of parameters."""
    n = 33_000 if JIT else 40
    zenith = np.linspace(1, 80, n)
    near, far = np.deg2rad(zenith), np.deg2rad(zenith + 0.001)
    growth = np.sin(far - near) * np.sin(far + near)
    azimuth = np.linspace(0, 6, n)
    columns = np.sin(near) ** 2, growth, np.cos(far) ** 2, np.full(n, 0.01), np.sin(azimuth), np.cos(azimuth)
    cell = np.column_stack(columns)
    compared(cells_source(cell, np.ones(n), 2 * n), 0, 2 * n)


@pytest.mark.parametrize("form", [batches, plain])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_sums_are_those_of_one_after_the_other(precision, form):
    """In float64 and in their order, whatever the precision of the photons."""
    rng = np.random.default_rng(1)
    uz, weight = (-rng.uniform(1e-3, 1.0, 999)).astype(precision), rng.lognormal(size=999).astype(precision)
    mu, w = -uz.astype(np.float64), weight.astype(np.float64)
    assert form.block_sums(uz) == (np.cumsum(mu)[-1], np.cumsum(1.0 / mu)[-1])
    assert form.weighted_block_sums(uz, weight) == tuple(np.cumsum(part)[-1] for part in (w, w * mu, w / mu))
