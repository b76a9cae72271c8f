"""Flag 0 under `--compat aomc` against launches of the AOMC program's own random source."""

import numpy as np
import pytest
from scipy.special import ndtr

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import sky_angles
from tests.support.shared import AOMC, csv_rows

CASES = [("internal_source_point", 0), ("internal_source_point", 1), ("internal_source_circle", 0)]


def summary(case, band):
    return {name: float(value) for name, value in csv_rows(AOMC / case / "summary.csv")[band].items()}


def histogram(case, band, quantity):
    table = csv_rows(AOMC / case / "histograms.csv")
    rows = [r for r in table if int(r["waveband"]) == band + 1 and r["quantity"] == quantity]
    assert rows
    assert [int(r["bin"]) for r in rows] == list(range(len(rows)))
    return np.array([int(r["photons"]) for r in rows])


def ours(case, band, **options):
    """Our photons of a band, and which of them are diffuse."""
    chosen = {"compat": "aomc", **options}
    source = sky.read_scene(AOMC / case / "amc.inp", sky="uniform", lenient=True, **chosen).source(seed=13)
    batch = source.photons(band)
    names = [c.name for c in source.components]
    edges = np.cumsum([c.n_cells for c in source.components])
    return batch, np.searchsorted(edges, batch.patch, side="right") == names.index("uniform")


def two_means_p(ours, n, mean, variance):
    """Difference of two independent sample means, variance known."""
    return float(2 * ndtr(-abs(ours.mean() - mean) / np.sqrt(variance * (1 / ours.size + 1 / n))))


def diffuse_p(case, band, **options):
    batch, diffuse = ours(case, band, **options)
    mu, _, azimuth = (a[diffuse] for a in sky_angles(batch))
    row = summary(case, band)
    n = row["launched"] - row["direct_photons"]
    return (
        chi2.homogeneity_p(np.histogram(mu, 20, (0, 1))[0], histogram(case, band, "cos_zenith")),
        chi2.homogeneity_p(np.histogram(azimuth, 24, (0, 360))[0], histogram(case, band, "azimuth")),
        two_means_p(mu, n, row["diffuse_mean_cos"], 1 / 12),
        two_means_p(mu**2, n, row["diffuse_mean_cos2"], 1 / 5 - 1 / 9),
    )


@pytest.mark.parametrize(("case", "band"), CASES)
def test_diffuse_light(plan, case, band):
    assert ours(case, band)[0].ux.size == summary(case, band)["launched"]
    for p_value in diffuse_p(case, band):
        plan.check(p_value)
    with_cosine = diffuse_p(case, band, compat=None)  # our own default: through the horizontal surface
    for k in (0, 2, 3):
        plan.catches(with_cosine[k])


def test_direct_share(plan):
    """The program draws each photon's kind; so do we under compat."""
    _, diffuse = ours("internal_source_point", 1)
    row = summary("internal_source_point", 1)
    direct = int(np.count_nonzero(~diffuse))
    theirs = np.array([row["direct_photons"], row["launched"] - row["direct_photons"]])
    plan.check(chi2.homogeneity_p(np.array([direct, diffuse.sum()]), theirs))
    plan.catches(chi2.homogeneity_p(np.array([diffuse.sum(), direct]), theirs))


def test_bands_of_one_kind():
    batch, diffuse = ours("internal_source_point", 2)
    assert not diffuse.any()
    assert np.unique(batch.uz).size == 1
    assert -batch.uz[0] == pytest.approx(np.cos(np.deg2rad(30)), abs=1e-6)
    assert ours("internal_source_point", 3)[0].ux.size == 0


def test_circle(plan):
    case = "internal_source_circle"
    batch, _ = ours(case, 0)
    r2 = (np.asarray(batch.x, dtype=np.float64) ** 2 + np.asarray(batch.y, dtype=np.float64) ** 2) / 1.5**2
    row = summary(case, 0)
    assert r2.max() < 1 + 1e-6
    assert row["max_r"] <= 1.5
    theirs = histogram(case, 0, "radius_over_R")
    plan.check(chi2.homogeneity_p(np.histogram(np.sqrt(r2), 10, (0, 1))[0], theirs))
    plan.check(two_means_p(r2, row["launched"], row["mean_r2"] / 1.5**2, 1 / 12))
    plan.catches(chi2.homogeneity_p(np.histogram(r2, 10, (0, 1))[0], theirs))  # no square root
