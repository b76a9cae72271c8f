"""The compiled emission equals its plain form to the bit, for every law, order, placement and precision."""

import dataclasses
import functools

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.emission.kernels import batches, plain
from aomc_sky.skies.perez.kernels.cells import tilted
from aomc_sky.skies.perez.law import PerezBounds
from tests.support.emitted import compared

JIT = not numba.config.DISABLE_JIT
N = 9001 if JIT else 150
BANDS = [500.0]


def component(name, law, cell, mass, grid=None):
    cell = np.atleast_2d(cell)
    mass = np.atleast_2d(np.asarray(mass, float))
    return Component(name=name, law=law, strength=np.ones(1), mass=mass, cell=cell, grid=grid)


def grid_component(law, n_zenith=7, n_azimuth=11, name="table"):
    grid = sky.PatchGrid.regular(n_zenith, n_azimuth)
    mass = np.random.default_rng(2).lognormal(0, 2, grid.n_patches)
    mass[3:9] = 0
    return component(name, law, cells_of_grid(grid, law), mass, grid)


def perez_sky(grid, **options):
    """A clear sky with a narrow aureole, whose rejection works hard on coarse cells."""
    sun = {"sun_zenith_rad": 0.7, "sun_azimuth_rad": 0.2}
    return sky.PerezSky(**sun, epsilon=8.0, delta=0.1, grid=grid, **options).lower(500)


def beam():
    return sky.DirectBeam(sun_zenith_deg=35, sun_azimuth_deg=200).lower(500)


def disc(sun_zenith_deg, sun_azimuth_deg):
    return sky.DirectBeam(sun_zenith_deg=sun_zenith_deg, sun_azimuth_deg=sun_azimuth_deg, radius_deg=0.2665).lower(500)


def four():
    tables = (grid_component(Law.CELL_MU), grid_component(Law.CELL_MU2, 3, 2, "coarse"))
    return (*disc(20, 10), *sky.UniformSky().lower(500), *tables)


SCENES = {
    "table": lambda: (grid_component(Law.CELL_MU2),),
    "all cells lit": lambda: (grid_component(Law.CELL_MU2, 1, 6),),
    "solid angle": lambda: (grid_component(Law.CELL_MU),),
    "beam": beam,
    "disc": lambda: disc(20, 10),
    "faint disc": lambda: (dataclasses.replace(disc(20, 10)[0], strength=[0.03]), grid_component(Law.CELL_MU2)),
    "disc and uniform": lambda: (*disc(20, 10), *sky.UniformSky().lower(500)),
    "disc at the horizon": lambda: disc(89.9, 300),
    "uniform": lambda: sky.UniformSky().lower(500),
    "uniform per solid angle": lambda: sky.UniformSky(per_solid_angle=True).lower(500),
    "perez in narrow cells": lambda: perez_sky(sky.PatchGrid.regular(9, 120)),
    "beam and table": lambda: (*beam(), grid_component(Law.CELL_MU2)),
    "beam and perez": lambda: (*beam(), *perez_sky(sky.PatchGrid.regular(6, 2))),
    "perez": lambda: perez_sky(sky.PatchGrid.regular(9, 12)),
    "four components": four,
}


@functools.cache
def components_of(name):
    return SCENES[name]()


def source_of(name, n=N, **options):
    scene = sky.Scene(wavebands=BANDS, n_photons=n, components=components_of(name))
    return scene.source(seed=9, **options)


def many_cells(n_zenith, n):
    """The source of a table with n_zenith^2 patches of different masses."""
    grid = sky.PatchGrid.regular(n_zenith, n_zenith)
    mass = 0.5 + np.random.default_rng(1).random(grid.n_patches)
    many = component("many", Law.CELL_MU2, cells_of_grid(grid), mass, grid)
    return sky.Scene(wavebands=BANDS, n_photons=n, components=(many,)).source()


PRECISIONS, ORDERS, PLACEMENTS = ("float32", "float64"), ("shuffled", "patch"), ("r2", "philox", "centre")


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("name", SCENES)
def test_compiled_equals_plain(name, precision, order, placement):
    source = source_of(name, order=order, placement=placement, precision=precision)
    compared(source, N // 5, N)


@pytest.mark.parametrize("name", ["perez", "perez in narrow cells"])
def test_places_are_moved_along_the_slope(name):
    """In cells that are not too coarse for it; else the tests above would not see how."""
    (component,) = components_of(name)
    assert np.all(np.count_nonzero(component.bounds[:, 2:], axis=0) > 5)


def types_of(arguments):
    return tuple(types_of(a) if isinstance(a, tuple) else numba.typeof(a) for a in arguments)


def test_the_word_of_a_perez_cell_gives_back_its_tilts():
    """u + k u (1 - u), for v alike, with the tilts k of the plan: numpy and the kernels unpack them by one formula."""
    components = source_of("perez").components
    tilts, words = components[0].bounds[:, 2:].T, PerezBounds.of(components).word
    u, v, jacobian = tilted(np.full(words.size, 0.25), np.full(words.size, 0.875), words)
    np.testing.assert_allclose(u, 0.25 + tilts[0] * 0.25 * 0.75, rtol=1e-14)
    np.testing.assert_allclose(v, 0.875 + tilts[1] * 0.875 * 0.125, rtol=1e-14)
    np.testing.assert_allclose(jacobian, (1 + tilts[0] * 0.5) * (1 - tilts[1] * 0.75), rtol=1e-14)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("n", [N // 60, N])
def test_short_and_long_runs(precision, n):
    """Patch order takes a loop per cell where cells hold many photons, the general way where they do not."""
    for name in ("table", "all cells lit"):
        source = source_of(name, n=n, order="patch", precision=precision)
        for start in (0, n // 3):
            compared(source, start, n)


def test_counts_of_emitted_cells_are_the_counts():
    for name in SCENES:
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
    source = many_cells(n_zenith, n)
    for start in (0, n - 5000):
        compared(source, start, start + 5000)


def test_more_words_than_16_bits():
    """Cells that share neither ring nor column need 32-bit positions in the table of parameters."""
    n = 33_000 if JIT else 40
    zenith = np.linspace(1, 80, n)
    near, far = np.deg2rad(zenith), np.deg2rad(zenith + 0.001)
    growth = np.sin(far - near) * np.sin(far + near)
    azimuth = np.linspace(0, 6, n)
    columns = np.sin(near) ** 2, growth, np.cos(far) ** 2, np.full(n, 0.01), np.sin(azimuth), np.cos(azimuth)
    cell = np.column_stack(columns)
    scattered = component("scattered", Law.CELL_MU2, cell, np.ones(n))
    source = sky.Scene(wavebands=BANDS, n_photons=2 * n, components=(scattered,)).source()
    compared(source, 0, 2 * n)


@pytest.mark.parametrize("form", [batches, plain])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_sums_are_those_of_one_after_the_other(precision, form):
    """In float64 and in their order, whatever the precision of the photons."""
    rng = np.random.default_rng(1)
    uz, weight = (-rng.uniform(1e-3, 1.0, 999)).astype(precision), rng.lognormal(size=999).astype(precision)
    mu, w = -uz.astype(np.float64), weight.astype(np.float64)
    assert form.block_sums(uz) == (np.cumsum(mu)[-1], np.cumsum(1.0 / mu)[-1])
    assert form.weighted_block_sums(uz, weight) == (np.cumsum(w)[-1], np.cumsum(w / mu)[-1])
