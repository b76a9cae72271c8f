"""An ocean run under an atmosphere description: what its photons carry is what the solution says."""

import numpy as np
import pytest

import aomc_sky
from tests.support.shared import INPUTS

SCENE = INPUTS / "atmosphere_sky"
BAND = 1


def photon_means(source):
    """Share of photons from the beam, and the mean of 1 / mu of all."""
    direct, inverse, n = 0, 0.0, 0
    beam_cell = [c.name for c in source.components].index("direct")
    for batch in source.batches(BAND, 1 << 20):
        direct += int(np.count_nonzero(batch.patch == beam_cell))
        inverse += float(np.sum(1.0 / -batch.uz.astype(np.float64)))
        n += batch.uz.size
    return direct / n, inverse / n


def solved_light():
    """Direct, diffuse, and scalar irradiance of the waveband, from radiances in single directions."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    t, w = (nodes + 1) / 2, weights / 2
    mu, n_azimuth = t**2, 96
    found = aomc_sky.solve_atmosphere(
        SCENE / "clear.atmo",
        wavelength_nm=[412.0, 510.0, 590.0, 670.0],
        sun_zenith_deg=41.5,
        sky_zenith_deg=np.rad2deg(np.arccos(mu)),
        azimuth_from_sun_deg=180 * (np.arange(n_azimuth) + 0.5) / n_azimuth,
    )
    ring = found.radiance[BAND].mean(axis=1) * 2 * np.pi * w * 2 * t
    direct = float(found.direct_irradiance[BAND])
    return direct, float(ring @ mu), float(ring.sum() + direct / np.cos(np.deg2rad(41.5)))


def run_of(n_photons):
    return aomc_sky.read_scene(SCENE, iterations=int(n_photons), wavebands=[BAND + 1]).source(seed=7)


@pytest.mark.parametrize("n_photons", [3e5, pytest.param(1e7, marks=pytest.mark.slow)])
def test_photons_carry_the_light_of_the_solution(n_photons):
    source = run_of(n_photons)
    direct, diffuse, scalar = solved_light()
    stated = source.irradiance(BAND)
    assert stated["direct"] == pytest.approx(direct, rel=1e-9)
    assert stated["atmosphere"] == pytest.approx(diffuse, rel=1e-6)  # two quadratures of one radiance
    share, inverse = photon_means(source)
    whole = stated["direct"] + stated["atmosphere"]
    assert abs(share - stated["direct"] / whole) < max(1e-5, 1.5 / n_photons)
    # irradiance of a photon: whole / n; mean 1 / mu of light at the horizon has no variance, so 1e7 are needed for 2e-3
    assert whole * inverse == pytest.approx(scalar, rel=2e-3 if n_photons >= 1e7 else 1e-2)
    # patches are of constant radiance: exact for Ed, and for Eo to what varies inside a patch
    assert whole * source.exact_moments(BAND).mean_inverse_mu == pytest.approx(scalar, rel=1e-3)


def test_counts_follow_the_patch_means():
    source = run_of(2e5)
    sky = next(c for c in source.components if c.name == "atmosphere")
    row = 1
    expected = (
        sky.mass_of(row) / sky.mass_of(row).sum() * sky.strength[row] / sum(c.strength[row] for c in source.components)
    )
    start = int(np.argmax([c.name == "atmosphere" for c in source.components]))
    counts = source.counts[BAND, start : start + sky.n_cells]
    assert np.abs(counts - expected * 2e5).max() < 1.0
