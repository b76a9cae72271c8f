"""Runs that are spoilt on purpose, and photons of a code that is not ours."""

import numpy as np

from aomc_sky.outputs.photons.files import BLOCK, PhotonRows
from aomc_sky.verify.directions import verify_directions


def directions_of(source, band=0):
    return source.photons(band).directions


def uniform_in_zenith_angle(directions, share, seed=0):
    """The directions with a share of them made uniform in zenith angle and in azimuth: no sine, no cosine."""
    rng = np.random.default_rng(seed)
    spoilt = directions.copy()
    chosen = rng.random(len(directions)) < share
    zenith, azimuth = rng.random(chosen.sum()) * np.pi / 2, rng.random(chosen.sum()) * 2 * np.pi
    sine = np.sin(zenith)
    spoilt[chosen] = -np.column_stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)])
    return spoilt


def change_photons(folder, change, waveband=1):
    """Replace the directions of a waveband and leave everything else as it is."""
    photons = np.load(folder / f"photons-{waveband:04d}.npy", mmap_mode="r+")
    photons[:] = change(photons.copy())
    photons.flush()


def rows_of(directions, weight=None):
    for start in range(0, len(directions), BLOCK):
        part = slice(start, start + BLOCK)
        yield PhotonRows(start=start, direction=directions[part], weight=None if weight is None else weight[part])


def direction_report(source, dependence, directions=None, *, weight=None, seed=0, band=0):
    """The tests of directions of a waveband: of the source's own photons, or of those given."""
    found = directions_of(source, band) if directions is None else directions
    return verify_directions(source, {band: rows_of(found, weight)}, dependence=dependence, seed=seed, threads=1)


def named(report, beginning):
    (check,) = (check for check in report.checks if check.name.startswith(beginning))
    return check
