"""A whole sky of independent photons against its masses, by directions alone; means against the exact ones."""

import dataclasses

import numpy as np
import pytest

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
