"""Sources as domes: every patch shows its light over its solid angle, and what has no extent is a mark."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.picture import PHOTONS, RADIANCE, RELATIVE_RADIANCE, Symbol, spread
from aomc_sky.pictures.source import source_picture, sun_mark
from aomc_sky.source.read.table import tabulated_sky
from tests.support.lobes import lobe_sky

GRID = PatchGrid.regular(3, 8)
VALUES = np.arange(48.0).reshape(2, 24)


def table_source(seed):
    table = sky.TabulatedSky(wavelength_nm=[450.0, 550.0], values=VALUES, grid=GRID)
    return sky.Scene(wavebands=[450.0, 550.0], n_photons=10_000, components=table).source(seed)


def source_of(*components, n=10):
    return sky.Scene(wavebands=[500.0], n_photons=n, components=components).source(0)


def symbols(picture, number=0):
    return [mark.symbol for mark in picture.domes[number].marks]


def test_radiance_is_over_projected_solid_angle_and_counts_over_solid_angle():
    picture = source_picture(table_source(0))
    assert picture.quantity is RELATIVE_RADIANCE
    for dome, row in zip(picture.domes, VALUES, strict=True):
        np.testing.assert_allclose(dome.values, row / row.sum() / GRID.projected_solid_angle_sr, rtol=1e-14)
        assert float(dome.values @ GRID.projected_solid_angle_sr) == pytest.approx(1.0)
    source = table_source(7)
    picture = source_picture(source, show="counts")
    assert picture.quantity is PHOTONS
    for band, dome in enumerate(picture.domes):
        found = dome.values * GRID.solid_angle_sr
        np.testing.assert_allclose(found, source.counts[band], rtol=1e-14, atol=1e-9)
        assert "10 000 photons" in dome.title


def test_a_beam_is_a_mark_and_not_in_the_colours():
    beam = sky.DirectBeam(sun_zenith_deg=30.0, sun_azimuth_deg=90.0, strength=3.0)
    source = source_of(beam, sky.UniformSky(strength=1.0), n=1000)
    picture = source_picture(source)
    (mark,) = picture.domes[0].marks
    assert (mark.zenith_deg, mark.azimuth_deg, mark.symbol) == (pytest.approx(30.0), pytest.approx(90.0), Symbol.BEAM)
    assert picture.domes[0].values == pytest.approx([0.25 / np.pi])
    assert "beam 75 % of the light" in picture.domes[0].title
    counts = source_picture(source, show="counts")
    assert "750 in the beam" in counts.domes[0].title
    assert float(counts.domes[0].values[0] * 2 * np.pi) == pytest.approx(250)
    picture = source_picture(source_of(sky.DirectBeam(sun_zenith_deg=30.0)))
    assert picture.domes[0].values.tolist() == [0.0]
    assert symbols(picture) == [Symbol.BEAM]


def test_the_sun_of_a_perez_sky_is_marked_once():
    source = source_of(sky.PerezSky(sun_zenith_deg=40.0, sun_azimuth_deg=250.0, epsilon=3.0, delta=0.2))
    (mark,) = source_picture(source).domes[0].marks
    assert (mark.zenith_deg, mark.azimuth_deg) == (pytest.approx(40.0), pytest.approx(250.0))
    assert mark.symbol is Symbol.SUN
    assert symbols(source_picture(source, sun=sun_mark(95.0, 0.0))) == [Symbol.SUN_BELOW]


@pytest.mark.parametrize(("kind", "params"), [("hg", (0.6, 0.0)), ("ggx", (0.4, 1.2)), ("beckmann", (0.9, 0.3))])
def test_lobes_show_their_radiance(kind, params, monkeypatch):
    monkeypatch.setattr("aomc_sky.pictures.source.LOBE_BINS", (45, 180))
    model = lobe_sky((kind, *params, [0.8, 0.3, -0.2, 0.1]), spectra=2.0)
    picture = source_picture(source_of(model))
    assert picture.quantity is RADIANCE
    grid, fine = picture.domes[0].grid, PatchGrid.regular(180, 720)
    assert (grid.n_zenith, grid.n_azimuth) == (45, 180)
    zenith, azimuth = (np.deg2rad(b.mean(axis=1)) for b in (fine.zenith_bounds_deg, fine.azimuth_bounds_deg))
    light = model.radiance(zenith[:, None], azimuth[None, :], 500.0).ravel() * fine.projected_solid_angle_sr
    want = light.reshape(45, 4, 180, 4).sum(axis=(1, 3)).ravel() / grid.projected_solid_angle_sr
    bright = want > 0.1 * want.max()
    np.testing.assert_allclose(picture.domes[0].values[bright], want[bright], rtol=6e-3)
    assert symbols(picture) == []


def test_a_needle_is_marked_and_its_patches_hold_all_its_light():
    source = source_of(lobe_sky(("ggx", 1e-4, 1e-4, [1.0, 0.2, 0.013, 0.0]), spectra=2.0))
    (dome,) = source_picture(source).domes
    (mark,) = dome.marks
    assert mark.symbol is Symbol.LOBE
    irradiance = source.irradiance(0)["ggx"]
    assert float(dome.values @ dome.grid.projected_solid_angle_sr) == pytest.approx(irradiance, rel=1e-9)
    # the needle lies in few patches, the bright one where the mark stands
    assert dome.grid.patch_of(np.array([mark.zenith_deg]), np.array([mark.azimuth_deg]))[0] == dome.values.argmax()


def test_lobes_and_patches_share_a_grid_that_changes_neither():
    (even,) = lobe_sky(("hg", 0.0, 0.0, [1.0, 0.0, 0.0, 0.0]), spectra=2 * np.pi).lower([500.0])
    grid = PatchGrid.regular(7, 11)  # edges that whole degrees do not meet
    rng = np.random.default_rng(1)
    mass = rng.random((1, grid.n_patches))
    patches = Component(
        name="sky", law=Law.CELL_MU2, strength=np.array([1.0]), mass=mass, cell=cells_of_grid(grid), grid=grid,
        irradiance_W_m2_nm=np.array([1.0]),
    )  # fmt: skip
    (dome,) = source_picture(source_of(patches, even)).domes
    zenith, azimuth = dome.grid.zenith_bounds_deg.mean(axis=1), dome.grid.azimuth_bounds_deg.mean(axis=1)
    patch = grid.patch_of(*np.broadcast_arrays(zenith[:, None], azimuth[None, :]))
    want = 0.5 + (mass[0] / mass.sum() / grid.projected_solid_angle_sr)[patch]
    np.testing.assert_allclose(dome.values.reshape(patch.shape), want, rtol=1e-9)


def test_whole_degrees_of_the_program_are_drawn_as_the_degrees_around_them():
    radiance = np.zeros((1, 90, 361))
    radiance[0, 44, 90], radiance[0, 44, 360], radiance[0, 44, 0] = 3.0, 1.0, 1.0
    table = sky.files.SkyTable(wavelength_nm=np.array([500.0]), radiance=radiance)
    model, _ = tabulated_sky(table, compat="aomc")
    picture = source_picture(source_of(model))
    values = picture.domes[0].values.reshape(90, 360)
    assert sorted(map(tuple, np.argwhere(values > 0).tolist())) == [(44, 0), (44, 90)]
    assert values[44, 90] / values[44, 0] == pytest.approx(1.5)
    assert any("whole degrees" in note for note in picture.notes)


@pytest.mark.parametrize("n", [1, 12, 13, 100])
def test_at_most_twelve_bands_are_chosen_by_themselves(n):
    chosen = spread(range(n))
    assert len(chosen) == min(n, 12)
    assert (chosen[0], chosen[-1], sorted(set(chosen))) == (0, n - 1, chosen)
