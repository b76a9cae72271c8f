"""Shares of cells in zones: those of a cell add up to 1, and they are the masses that finer grids give."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.grid import PatchGrid
from aomc_sky.verify.zones import ZoneShares, choose_zones, fixed_directions, zone_shares
from tests.support.shared import INPUTS


def source_of(*components, n=1000, **options):
    return sky.Scene(wavebands=[550.0], n_photons=n, components=components).source(1, **options)


def omega_of(law, grid):
    return grid.solid_angle_sr if law is Law.CELL_MU else grid.projected_solid_angle_sr


def even(law, grid):
    """A sky of constant radiance as a component of a law."""
    cell = cells_of_grid(grid, law)
    return Component(name="sky", law=law, strength=np.ones(1), mass=omega_of(law, grid)[None], cell=cell, grid=grid)


@pytest.mark.parametrize("law", [Law.CELL_MU2, Law.CELL_MU])
@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (7, 7), (45, 180)])
@pytest.mark.parametrize("zones", [(1, 1), (4, 6), (16, 16)])
def test_even_skies_cut_anywhere(law, shape, zones):
    source = source_of(even(law, PatchGrid.regular(*shape)))
    grid = PatchGrid.regular(*zones)
    shares, omega = zone_shares(source, grid), omega_of(law, grid)
    assert np.allclose(shares.expected(source.mass(0)), omega / omega.sum(), rtol=1e-12, atol=0)
    assert np.allclose(np.bincount(shares.cell, shares.share), 1.0, rtol=1e-13)


def test_loose_photons_are_binomial_and_those_of_whole_cells_are_fixed():
    """Cell 0 lies in zone 0 by a quarter and in zone 1 by the rest, cell 1 is zone 2."""
    cells, zones = np.array([0, 0, 1]), np.arange(3)
    shares = ZoneShares(cell=cells, zone=zones, share=np.array([0.25, 0.75, 1.0]), n_zones=3)
    assert shares.loose(np.array([1600.0, 500.0])).tolist() == [300.0, 300.0, 0.0]


def test_weights_that_carry_the_cosine_make_it_flux():
    source = source_of(even(Law.CELL_MU, PatchGrid.regular(1, 1)))
    grid = PatchGrid.regular(4, 2)
    flux = zone_shares(source, grid, is_flux=True).expected(np.ones(1))
    assert np.allclose(flux, grid.projected_solid_angle_sr / np.pi, rtol=1e-13)


def test_patches_that_begin_before_azimuth_zero():
    source, zones = source_of(even(Law.CELL_MU2, PatchGrid.whole_degrees())), PatchGrid.regular(6, 8)
    omega = zones.projected_solid_angle_sr
    expected = zone_shares(source, zones).expected(source.mass(0))
    assert np.allclose(expected, omega / omega.sum(), rtol=1e-12)


@pytest.mark.parametrize("zones", [(5, 7), (16, 16)])
def test_perez_patches_cut_anywhere(zones):
    model = sky.PerezSky(sun_zenith_rad=0.9, sun_azimuth_rad=0.3, epsilon=6.0, delta=0.1, grid=PatchGrid.regular(4, 6))
    source, grid = source_of(model), PatchGrid.regular(*zones)
    mass = model.patch_mass(grid)
    expected = zone_shares(source, grid).expected(source.mass(0))
    assert np.allclose(expected, mass / mass.sum(), rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("sun_deg", [0.0, 0.1, 0.2])
def test_a_disc_around_the_zenith(sun_deg):
    """At the zenith it is even in azimuth; beside it azimuth is not cut."""
    source = source_of(sky.DirectBeam(sun_zenith_deg=sun_deg, sun_azimuth_deg=70.0, radius_deg=0.3), n=400_000)
    zones = choose_zones(source)
    assert (zones.n_azimuth > 1) == (sun_deg == 0)
    zenith, azimuth = (np.rad2deg(x) for x in sky.directions.sky_from_travel(source.photons(0).directions))
    found = np.bincount(zones.patch_of(zenith, azimuth), minlength=zones.n_patches)
    assert np.allclose(zone_shares(source, zones).expected(np.ones(1)), found / found.sum(), atol=2e-4)


@pytest.mark.parametrize("name", ["beam_only", "clear_day", "document_example", "sparse_sky", "overcast"])
def test_zones_keep_clear_of_fixed_directions(name):
    source = sky.read_scene(INPUTS / name / "amc.inp", iterations=100).source(0)
    zones = choose_zones(source)
    assert zones.zenith_bounds_deg[0, 0] == 0
    assert zones.zenith_bounds_deg[-1, 1] == 90
    edges = zones.azimuth_bounds_deg
    assert edges[-1, 1] - edges[0, 0] == pytest.approx(360)
    assert np.array_equal(edges[1:, 0], edges[:-1, 1])
    fixed = fixed_directions(source.components, is_centred=False)
    inner = zones.zenith_bounds_deg[1:, 0]
    for low, high in fixed[:, :2]:
        assert high - low > 1.9e-4
        assert not np.any((inner >= low) & (inner <= high))


@pytest.mark.parametrize("sun_deg", [45.0, 0.0, 0.00005, 359.99995])
def test_a_sun_on_the_edges_of_patches(sun_deg):
    """Sun and patches both stand at whole degrees: no zone ends there, and photons fall where they are expected."""
    grid = PatchGrid.regular(90, 360)
    beam = sky.DirectBeam(sun_zenith_deg=30.0, sun_azimuth_deg=sun_deg, strength=1.0)
    source = source_of(even(Law.CELL_MU2, grid), beam, n=50_000)
    zones = choose_zones(source)
    assert not np.any(np.isclose(zones.zenith_bounds_deg, 30.0))
    assert not np.any(np.abs(np.mod(zones.azimuth_bounds_deg - sun_deg + 180, 360) - 180) < 1e-4)
    zenith, azimuth = sky.directions.sky_from_travel(source.photons(0).directions)
    found = np.bincount(zones.patch_of(np.rad2deg(zenith), np.rad2deg(azimuth)), minlength=zones.n_patches)
    expected = zone_shares(source, zones).expected(source.counts[0].astype(float))
    assert np.abs(found - expected).max() <= 2  # photons that rounding moves over an edge
