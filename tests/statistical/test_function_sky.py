"""Independent photons of a function inside coarse patches against midpoints of the function itself."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import sky_angles

N = 300_000
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
    source = sky.Scene(wavebands=[nm], n_photons=N, components=model).source(seed=11, method="iid", precision="float64")
    mu, sin2, azimuth_deg = sky_angles(source.photons())
    patch = FINE.patch_of(np.rad2deg(np.arctan2(np.sqrt(sin2), mu)), azimuth_deg)
    counts = np.bincount(patch, minlength=FINE.n_patches)
    plan.check(chi2.chi2_p(counts, N * shares(nm).ravel()))
    plan.catches(chi2.chi2_p(counts, N * shares(1100.0 - nm).ravel()))
    area = FINE.projected_solid_angle_sr.reshape(9, 2, 24, 2)
    means = shares(nm).reshape(9, 2, 24, 2).sum(axis=(1, 3), keepdims=True) / area.sum(axis=(1, 3), keepdims=True)
    plan.catches(chi2.chi2_p(counts, N * (means * area).ravel()))
