"""The solar disc: uniform radiance, flux law, whole or cut by the horizon."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import scene, square_counts

N = 200_000
BINS = 12
DISCS = {"overhead": (0.0, 0.2665), "large": (70.0, 9.0), "low": (89.9, 0.2665), "setting": (90.0, 5.0)}
AZIMUTH_DEG = 250.0


def frame(zenith_deg):
    """Centre, the tangent towards the zenith and the tangent across, of the disc."""
    z, a = np.deg2rad([zenith_deg, AZIMUTH_DEG])
    centre = np.array([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)])
    up = np.array([-np.cos(z) * np.cos(a), -np.cos(z) * np.sin(a), np.sin(z)])
    return centre, up, np.cross(up, centre)


def ring_and_sector(directions, zenith_deg, radius_deg):
    """Cell of equal solid angle on the disc: ring in 1 - cos(distance), sector around the centre."""
    centre, up, across = frame(zenith_deg)
    apart = directions - centre
    drop = np.einsum("ij,ij->i", apart, apart) / 2  # 1 - cos(distance), without cancellation
    ring = drop / (2 * np.sin(np.deg2rad(radius_deg) / 2) ** 2)
    angle = np.mod(np.arctan2(directions @ across, directions @ up), 2 * np.pi) / (2 * np.pi)
    return ring, angle


def counts_on_disc(directions, zenith_deg, radius_deg):
    ring, angle = ring_and_sector(directions, zenith_deg, radius_deg)
    assert ring.max() < 1 + 1e-3, "a photon beside the disc"
    assert directions[:, 2].min() >= 0, "a photon from below the horizon"
    return square_counts(np.minimum(ring, 1.0), angle, BINS).ravel()


def expected_on_disc(zenith_deg, radius_deg, fine=60):
    """Flux share of each cell by the midpoint rule on the visible part."""
    centre, up, across = frame(zenith_deg)
    n = BINS * fine
    ring, angle = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * 2 * np.pi, indexing="ij")
    drop = ring * 2 * np.sin(np.deg2rad(radius_deg) / 2) ** 2
    off = np.sqrt(drop * (2 - drop))
    mu = (1 - drop) * centre[2] + off * (np.cos(angle) * up[2] + np.sin(angle) * across[2])
    flux = np.maximum(mu, 0).reshape(BINS, fine, BINS, fine).sum(axis=(1, 3)).ravel()
    return flux / flux.sum()


def disc_p(directions, zenith_deg, radius_deg):
    """Cells that expect none are caught by `pool`; the ragged edge of the horizon is pooled with its neighbours."""
    expected = expected_on_disc(zenith_deg, radius_deg) * directions.shape[0]
    return chi2.chi2_p(counts_on_disc(directions, zenith_deg, radius_deg), expected)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("disc", DISCS)
def test_disc(plan, disc, precision):
    zenith, radius = DISCS[disc]
    components = sky.DirectBeam(sun_zenith_deg=zenith, sun_azimuth_deg=AZIMUTH_DEG, radius_deg=radius).lower([500])
    batch = scene(components, N).source(seed=3, placement="philox", precision=precision).photons()
    plan.check(disc_p(-batch.directions.astype(np.float64), zenith, radius))


def planted(zenith_deg, radius_deg, defect):
    """Discs by rejection on another generator, with a defect."""
    u, v, w = np.random.default_rng(8).random((3, 3 * N, 1))
    centre, up, across = frame(zenith_deg)
    drop = 2 * np.sin(np.deg2rad(radius_deg) / 2) ** 2 * u
    if defect == "uniform in the distance":
        drop = 2 * np.sin(np.deg2rad(radius_deg) * u / 2) ** 2

    def directions(drop):
        off, angle = np.sqrt(drop * (2 - drop)), 2 * np.pi * v
        return (1 - drop) * centre + off * (np.cos(angle) * up + np.sin(angle) * across)

    found = directions(drop)
    mu = found[:, 2]
    is_kept = mu > 0 if defect == "no cosine" else w[:, 0] * mu.max() < mu
    if defect == "radius one percent large":
        found = directions(0.99**2 * drop)
        is_kept &= found[:, 2] >= 0
    return found[is_kept][:N]


@pytest.mark.parametrize(
    ("disc", "defect"),
    [
        ("large", "no cosine"),
        ("low", "no cosine"),
        ("setting", "no cosine"),
        ("overhead", "uniform in the distance"),
        ("large", "radius one percent large"),
    ],
)
def test_planted_defects(plan_only, disc, defect):
    plan_only.catches(disc_p(planted(*DISCS[disc], defect), *DISCS[disc]))


@pytest.mark.parametrize("disc", DISCS)
def test_the_plant_itself_is_sound(plan_only, disc):
    assert disc_p(planted(*DISCS[disc], "none"), *DISCS[disc]) >= plan_only.level
