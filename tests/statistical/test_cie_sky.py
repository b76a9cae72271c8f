"""Independent photons of general skies of the CIE against the law of the standard, by midpoints of their own."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import sky_angles
from tests.support.shared import INPUTS

N = 300_000
SUN_ZENITH, SUN_AZIMUTH = np.deg2rad(32.0), np.deg2rad(121.0)
RINGS, SECTORS = np.deg2rad(np.arange(0, 91, 10.0)), np.deg2rad(np.arange(0, 361, 30.0))
FINE = 60  # midpoints along each side of a cell


def law_of_type_12(zenith, azimuth, *, gradation=-0.32):
    """Clear sky of low turbidity, ISO 15469, but for a constant."""
    cosine = np.cos(SUN_ZENITH) * np.cos(zenith) + np.sin(SUN_ZENITH) * np.sin(zenith) * np.cos(azimuth - SUN_AZIMUTH)
    chi = np.arccos(np.clip(cosine, -1, 1))
    indicatrix = 1 + 10 * (np.exp(-3 * chi) - np.exp(-1.5 * np.pi)) + 0.45 * cosine**2
    return indicatrix * (1 - np.exp(gradation / np.cos(zenith)))


def law_of_type_3(zenith, azimuth, *, gradation=-0.8):
    """Overcast, moderately graded."""
    return 1 + 1.1 * np.exp(gradation / np.cos(zenith)) + 0 * azimuth


def shares(law, **changed):
    zenith = np.interp((np.arange(9 * FINE) + 0.5) / FINE, np.arange(10), RINGS)
    azimuth = np.interp((np.arange(12 * FINE) + 0.5) / FINE, np.arange(13), SECTORS)
    value = law(zenith[:, None], azimuth, **changed) * (np.cos(zenith) * np.sin(zenith))[:, None]
    cells = value.reshape(9, FINE, 12, FINE).sum(axis=(1, 3))
    return (cells / cells.sum()).ravel()


@pytest.mark.parametrize(("number", "law", "wrong"), [(3, law_of_type_3, -0.4), (12, law_of_type_12, -0.55)])
def test_photons_of_general_skies(plan, number, law, wrong):
    options = {"sky_options": {"type": number}, "sun": {"zenith_deg": 32.0, "azimuth_deg": 121.0}}
    scene = sky.read_scene(INPUTS / "clear_day", sky="cie", iterations=N, **options)
    mu, sin2, azimuth_deg = sky_angles(scene.source(seed=5, method="iid", precision="float64").photons())
    zenith = np.arctan2(np.sqrt(sin2), mu)
    counts = np.histogram2d(zenith, np.deg2rad(azimuth_deg), bins=(RINGS, SECTORS))[0].ravel()
    assert counts.sum() == N
    plan.check(chi2.chi2_p(counts, shares(law) * N))
    plan.catches(chi2.chi2_p(counts, shares(law, gradation=wrong) * N))
