"""Scenes for the statistical tests, and where photons lie in their cell, worked out from the directions alone."""

import numpy as np

import aomc_sky as sky
from aomc_sky.component import cells_of_grid

BAND = [500.0]
TWO_BANDS = [450.0, 550.0]


def scene(components, n, bands=BAND, **more):
    return sky.Scene(wavebands=bands, n_photons=n, components=components, **more)


def cell_component(law, zenith_deg, azimuth_deg):
    grid = sky.PatchGrid(zenith_bounds_deg=[zenith_deg], azimuth_bounds_deg=[azimuth_deg])
    cell = cells_of_grid(grid, law)
    return (
        sky.component.Component(name="cell", law=law, strength=np.ones(1), mass=np.ones((1, 1)), cell=cell, grid=grid),
    )


def grid_of_edges(zenith_deg, azimuth_deg):
    """A grid from the edges of its rings and columns, one more than there are."""
    zenith, azimuth = (np.column_stack([edges[:-1], edges[1:]]) for edges in (zenith_deg, azimuth_deg))
    return sky.PatchGrid(zenith_bounds_deg=zenith, azimuth_bounds_deg=azimuth)


def table_of(values, nm=(500.0,), **more):
    """A sky of values (n_zenith, n_azimuth) in a regular grid, or of so many for each wavelength."""
    values = np.reshape(values, (np.size(nm), *np.shape(values)[-2:]))
    grid, is_spectral = sky.PatchGrid.regular(*values.shape[1:]), np.size(nm) > 1
    return sky.TabulatedSky(wavelength_nm=nm, values=values, grid=grid, has_wavelength=is_spectral, **more)


def uneven_sky(n_zenith=18, n_azimuth=24, seed=11):
    """A sky of patches whose masses differ, none like its mirror image."""
    return table_of(np.random.default_rng(seed).lognormal(0, 1, (n_zenith, n_azimuth)))


def sky_angles(batch):
    """mu, sin^2 of the zenith angle and azimuth [deg, 0 to 360) that photons come from, float64."""
    x, y, z = (-np.asarray(getattr(batch, name), dtype=np.float64) for name in ("ux", "uy", "uz"))
    return z, x * x + y * y, np.mod(np.rad2deg(np.arctan2(y, x)), 360.0)


def azimuth_place(azimuth_deg, bounds_deg):
    """Place between two azimuths, 0 at the first; far outside [0, 1] for photons beyond."""
    start, end = bounds_deg
    turned = np.mod(azimuth_deg - start + 180.0 - (end - start) / 2, 360.0) - 180.0 + (end - start) / 2
    return turned / (end - start)


def zenith_place_mu2(mu, sin2, bounds_deg):
    """Share of the flux between the near edge and the photon, from whichever of mu, sin^2 is the sharper."""
    near, far = np.deg2rad(bounds_deg)
    width = np.sin(far - near) * np.sin(far + near)
    return (sin2 - np.sin(near) ** 2) / width if bounds_deg[1] <= 45 else 1 - (mu**2 - np.cos(far) ** 2) / width


def zenith_place_mu(mu, sin2, bounds_deg):
    """Share of the solid angle between the near edge and the photon."""
    near, far = np.deg2rad(bounds_deg)
    width = 2 * np.sin((far - near) / 2) * np.sin((far + near) / 2)
    if bounds_deg[1] <= 45:
        return (sin2 / (1 + mu) - 2 * np.sin(near / 2) ** 2) / width
    return 1 - (mu - np.cos(far)) / width


def clipped(place, slack):
    """Places without the rounding beyond the edges; more than that stays outside and fails."""
    place = np.where((place < 0) & (place > -slack), 0.0, place)
    return np.where((place > 1) & (place < 1 + slack), 1.0, place)


def square_counts(s, t, n=16):
    return np.histogram2d(s, t, bins=n, range=[[0, 1], [0, 1]])[0]


def even(n_photons, n_cells):
    return np.full(n_cells, n_photons / n_cells)
