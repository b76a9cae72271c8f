"""Scenes that between them use every law and table form of the emission, for the hosts outside Python."""

import dataclasses
import functools

import numpy as np

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid

WAVEBANDS = [450.0, 550.0]
N = 20_011


def table(law, n_zenith, n_azimuth, name="table", sparse=False):
    """A table of widely spread masses; a sparse one has light in a tenth of its cells."""
    grid = sky.PatchGrid.regular(n_zenith, n_azimuth)
    rng = np.random.default_rng(2)
    mass = rng.lognormal(0, 2, (2, grid.n_patches))
    mass[:, rng.random(grid.n_patches) < (0.9 if sparse else 0.1)] = 0
    cell = cells_of_grid(grid, law)
    return Component(name=name, law=law, strength=np.ones(2), mass=mass, cell=cell, grid=grid)


def perez(n_zenith, n_azimuth, **options):
    grid = sky.PatchGrid.regular(n_zenith, n_azimuth)
    model = sky.PerezSky(sun_zenith_rad=0.7, sun_azimuth_rad=0.2, epsilon=8.0, delta=0.1, grid=grid, **options)
    return model.lower([450, 550])


def disc(sun_zenith_deg, radius_deg=0.2665):
    more = {} if radius_deg is None else {"radius_deg": radius_deg}
    return sky.DirectBeam(sun_zenith_deg=sun_zenith_deg, sun_azimuth_deg=200, **more).lower([450, 550])


def everything():
    tables = table(Law.CELL_MU2, 6, 9), table(Law.CELL_MU, 3, 2, "coarse")
    (beam,) = disc(35, None)
    return (*disc(89.9), *tables, *perez(6, 5), dataclasses.replace(beam, name="beam"))


SCENES = {
    "table": lambda: (table(Law.CELL_MU2, 18, 36),),
    "narrow cells": lambda: (table(Law.CELL_MU2, 10, 180),),
    "sparse": lambda: (table(Law.CELL_MU2, 9, 12, sparse=True),),
    "wide cells": lambda: sky.UniformSky().lower([450, 550]),
    "solid angle": lambda: (table(Law.CELL_MU, 7, 11),),
    "disc and table": lambda: (*disc(20), table(Law.CELL_MU2, 6, 9)),
    "everything": everything,
    "perez": lambda: perez(9, 12),
    "perez within": lambda: perez(6, 12, within="uniform"),
}


@functools.cache
def components(name):
    return SCENES[name]()


def source(name, n=N, **options):
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=n, components=components(name))
    return scene.source(seed=9, **options)


def directions(batch):
    """Directions of a batch as rows ux, uy, uz."""
    return np.ascontiguousarray(batch.directions.T)
