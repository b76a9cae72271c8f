"""A whole sky of independent photons against its masses, and a function inside coarse patches, by directions."""

import dataclasses

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import scene, sky_angles, uneven_sky

N = 500_000


def patch_seen(grid, mu, sin2, azimuth_deg):
    """Patch that a direction lies in; angles by arctan2, sharp at zenith and horizon."""
    zenith_deg = np.rad2deg(np.arctan2(np.sqrt(sin2), mu))
    ring = np.minimum((zenith_deg / 90 * grid.n_zenith).astype(int), grid.n_zenith - 1)
    column = np.minimum((azimuth_deg / 360 * grid.n_azimuth).astype(int), grid.n_azimuth - 1)
    return ring * grid.n_azimuth + column


def sky_p(table, angles):
    share = table.mass(0) / table.mass(0).sum()
    counts = np.bincount(patch_seen(table.grid, *angles), minlength=share.size)
    return chi2.chi2_p(counts, share * counts.sum())


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_independent_photons(plan, precision):
    table = uneven_sky()
    batch = scene(table, N).source(seed=4, method="iid", precision=precision).photons()
    angles = sky_angles(batch)
    plan.check(sky_p(table, angles))
    # float32 rounds a photon over an edge about once in a million
    strangers = np.count_nonzero(patch_seen(table.grid, *angles) != batch.patch)
    assert strangers <= (N // 50_000 if precision == "float32" else 0)


DEFECTS = {
    "azimuth mirrored": lambda zenith, azimuth: (zenith, -azimuth),
    "travel for sky": lambda zenith, azimuth: (zenith, azimuth + 180),
    "column off by one": lambda zenith, azimuth: (zenith, azimuth + 15),
    "ring off by one": lambda zenith, azimuth: (np.minimum(zenith + np.deg2rad(5), np.pi / 2), azimuth),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_planted_defects(plan_only, defect):
    table = uneven_sky()
    mu, sin2, azimuth = sky_angles(scene(table, N).source(seed=4, method="iid").photons())
    zenith, azimuth = DEFECTS[defect](np.arctan2(np.sqrt(sin2), mu), azimuth)
    plan_only.catches(sky_p(table, (np.cos(zenith), np.sin(zenith) ** 2, np.mod(azimuth, 360))))


def test_a_mass_off_by_one_percent(plan_only):
    table = uneven_sky()
    values = table.values * np.where(np.arange(table.grid.n_patches) % 2, 1.01, 0.99)
    spoilt = dataclasses.replace(table, values=values)
    plan_only.catches(sky_p(table, sky_angles(scene(spoilt, 4_000_000).source(seed=4, method="iid").photons())))


N_COARSE = 300_000
COARSE, FINE = sky.PatchGrid.regular(9, 24), sky.PatchGrid.regular(18, 48)


def leaning(z, a, nm):
    """Brightest at azimuth 0.3, with a horizon that is redder than the zenith."""
    return np.exp(2 * np.sin(z) * np.cos(a - 0.3)) * (1 + nm / 300 * np.sin(z) ** 2)


def shares(nm, n=30):
    """Of the photons in the fine patches, by n x n midpoints in each of them."""
    zenith, azimuth = (np.arange(18 * n) + 0.5) * np.pi / (36 * n), (np.arange(48 * n) + 0.5) * np.pi / (24 * n)
    value = leaning(zenith[:, None], azimuth, nm) * np.sin(2 * zenith)[:, None]
    return value.reshape(18, n, 48, n).sum(axis=(1, 3)) / value.sum()


@pytest.mark.parametrize("nm", [400.0, 700.0])
def test_photons_follow_the_function_inside_coarse_patches(plan, nm):
    """Halves of patches of 10 x 15 degrees; patches of constant radiance and another wavelength are found out."""
    model = sky.FunctionSky(leaning, grid=COARSE)
    source = sky.Scene(wavebands=[nm], n_photons=N_COARSE, components=model).source(
        seed=11, method="iid", precision="float64"
    )
    mu, sin2, azimuth_deg = sky_angles(source.photons())
    patch = FINE.patch_of(np.rad2deg(np.arctan2(np.sqrt(sin2), mu)), azimuth_deg)
    counts = np.bincount(patch, minlength=FINE.n_patches)
    plan.check(chi2.chi2_p(counts, N_COARSE * shares(nm).ravel()))
    plan.catches(chi2.chi2_p(counts, N_COARSE * shares(1100.0 - nm).ravel()))
    area = FINE.projected_solid_angle_sr.reshape(9, 2, 24, 2)
    means = shares(nm).reshape(9, 2, 24, 2).sum(axis=(1, 3), keepdims=True) / area.sum(axis=(1, 3), keepdims=True)
    plan.catches(chi2.chi2_p(counts, N_COARSE * (means * area).ravel()))
