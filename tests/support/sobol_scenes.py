"""Scenes of every kind for the tests of the Sobol method."""

from __future__ import annotations

import functools

import numpy as np

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid

BAND = sky.Wavebands(wavelength_nm=np.array([500.0]))


def grid_component(law, n_zenith=7, n_azimuth=11, name="table", mass=None):
    """Patches of a law whose masses differ, some of them dark."""
    grid = sky.PatchGrid.regular(n_zenith, n_azimuth)
    if mass is None:
        mass = np.random.default_rng(2).lognormal(0, 2, grid.n_patches)
        mass[3:9] = 0
    mass = np.asarray(mass, dtype=float).reshape(1, -1)
    return Component(name=name, law=law, strength=np.ones(1), mass=mass, cell=cells_of_grid(grid, law), grid=grid)


def perez_sky(grid, **options):
    """A clear sky with a narrow aureole."""
    model = sky.PerezSky(sun_zenith_rad=0.7, sun_azimuth_rad=0.2, epsilon=8.0, delta=0.1, grid=grid, **options)
    return model.lower(500)


def spike(n_zenith=5, n_azimuth=6, cell=14):
    """A sky whose light stands in one patch."""
    mass = np.zeros(n_zenith * n_azimuth)
    mass[cell] = 1.0
    return grid_component(Law.CELL_MU2, n_zenith, n_azimuth, mass=mass)


def sparse():
    """Three lit patches of 3600, two of them in one ring; whole rings are dark."""
    mass = np.zeros(3600)
    mass[[95, 1800, 1807]] = 0.2, 0.5, 0.3
    return grid_component(Law.CELL_MU2, 30, 120, mass=mass)


def tiny():
    """Masses from 1 down to 1e-15 in two rings, the second one of 1e-15 in all."""
    return grid_component(Law.CELL_MU2, 2, 4, mass=[1.0, 1e-5, 1e-10, 1e-15, 1e-15, 0.0, 0.0, 0.0])


@functools.cache
def scenes():
    """Components by the name of the scene."""
    beam = sky.DirectBeam(sun_zenith_deg=35, sun_azimuth_deg=200).lower(500)
    disc = sky.DirectBeam(sun_zenith_deg=20, sun_azimuth_deg=10, radius_deg=0.2665).lower(500)
    low_disc = sky.DirectBeam(sun_zenith_deg=89.9, sun_azimuth_deg=300, radius_deg=0.2665).lower(500)
    table = grid_component(Law.CELL_MU2)
    return {
        "table": (table,),
        "all cells lit": (grid_component(Law.CELL_MU2, 1, 6, mass=np.arange(1, 7)),),
        "solid angle": (grid_component(Law.CELL_MU),),
        "beam": beam,
        "disc": disc,
        "disc at the horizon": low_disc,
        "uniform": sky.UniformSky().lower(500),
        "spike": (spike(),),
        "sparse": (sparse(),),
        "tiny masses": (tiny(),),
        "beam and table": (*beam, table),
        "perez": perez_sky(sky.PatchGrid.regular(6, 5)),
        "perez, constant in patches": perez_sky(sky.PatchGrid.regular(30, 40), within="uniform"),
        "perez in narrow cells": perez_sky(sky.PatchGrid.regular(2, 120)),
        "beam and perez": (*beam, *perez_sky(sky.PatchGrid.regular(6, 2))),
        "four components": (
            *disc,
            *sky.UniformSky().lower(500),
            grid_component(Law.CELL_MU),
            grid_component(Law.CELL_MU2, 3, 2, "coarse", mass=np.ones(6)),
        ),
    }


def source_of(name, n, seed=9, **options):
    """The Sobol source of a scene of n photons."""
    scene = sky.Scene(wavebands=BAND, n_photons=n, components=scenes()[name])
    return scene.source(seed=seed, method="sobol", **options)
