"""How evenly the photons of one lobe fill the sky: variance over seeds of 5-degree bins beside independent photons'."""

from dataclasses import dataclass, replace

import numpy as np

import aomc_sky as sky
from aomc_sky.skies.lobes import functions as lobes
from tests.support.lobes import lobe_sky
from tests.support.sampled import table_of

SEEDS = 24
MOST_MEAN, MOST_WORST = 0.8, 3.5
"""Bars of the ratio. 24 seeds of independent photons have a mean of 1 and, over 1000 bins, a largest one near 2.3."""

LEAST = 20.0
"""Bins that expect fewer photons are left out: their ratio says more of the grid than of the photons."""

GRID = sky.PatchGrid.regular(18, 72)
_MU2 = np.cos(np.deg2rad(np.arange(0, 91, 5)))[::-1] ** 2


def turned(zenith_deg, azimuth_deg=0.0, roll_deg=0.0):
    """Quaternion of a lobe whose axis points to a direction, its own x axis turned by `roll_deg` from the meridian."""
    zenith, azimuth, roll = np.deg2rad([zenith_deg, azimuth_deg, roll_deg]) / 2
    c, s = np.cos(zenith), np.sin(zenith)
    turn, skew = azimuth + roll, azimuth - roll
    return float(c * np.cos(turn)), float(-s * np.sin(skew)), float(s * np.cos(skew)), float(c * np.sin(turn))


LOBES = {
    "streak": ("beckmann", 0.25, 1.5, turned(30, 270, 90)),
    "glow": ("ggx", 0.2, 0.8, turned(30)),
    "cloud edge": ("hg", 0.7, 0.0, turned(50, 20)),
    "at the horizon": ("hg", 0.94, 0.0, turned(88, 100)),
    "band": ("beckmann", 0.3, 1.2, turned(70, 40, 30)),
    "thread": ("ggx", 0.01, 0.7, turned(60, 10, 20)),
    "isotropic": ("hg", 0.0, 0.0, turned(0)),
}


def component(case, name="lobe", strength=1.0):
    (lobe,) = lobe_sky(case, names=[name], wavelength_nm=[500.0], spectra=strength).lower([500.0])
    return lobe


def scene_of(case, n, *, crowded=False):
    """A scene in which the lobe is the last component and has n photons: alone, or a quarter of a sky."""
    if not crowded:
        return sky.Scene(wavebands=[500.0], n_photons=n, components=(component(case),))
    perez = sky.PerezSky(sun_zenith_rad=0.7, epsilon=6.3, delta=0.12, grid=sky.PatchGrid.regular(18, 36)).lower(500)
    table = table_of(np.random.default_rng(3).lognormal(0, 1, (9, 10))).lower([500])
    others = [component(LOBES[name], name) for name in ("cloud edge", "thread")]
    shares = (0.25, 0.25, 0.125, 0.125, 0.25)
    parts = [_with_strength(c, s) for c, s in zip((*perez, *table, *others, component(case)), shares, strict=True)]
    return sky.Scene(wavebands=[500.0], n_photons=4 * n, components=tuple(parts))


def _with_strength(part, strength):
    return replace(part, strength=np.array([strength]), irradiance_W_m2_nm=None)


def masses(case):
    """Share of the lobe's photons in each bin, exact to 1e-8."""
    kind, param0, param1, quaternion = case
    mass = lobes.patch_mass(kind, param0, param1, quaternion, GRID, weighting="projected").ravel()
    return np.asarray(mass / mass.sum())


def counts(x, y, z):
    ring = np.clip(18 - np.searchsorted(_MU2, np.asarray(z, np.float64) ** 2), 0, 17)
    azimuth = np.arctan2(-np.asarray(y, np.float64), -np.asarray(x, np.float64))
    column = np.floor(azimuth * (36 / np.pi)).astype(np.int64) % 72
    return np.bincount(ring * 72 + column, minlength=GRID.n_patches)


def last_component(source):
    batch = source.photons()
    own = batch.patch == source.counts.shape[1] - 1
    return batch.ux[own], batch.uy[own], batch.uz[own]


@dataclass(frozen=True, kw_only=True)
class Fairness:
    """Ratios of variances over the bins of a lobe."""

    mean: float
    worst: float
    n_bins: int

    @property
    def holds(self):
        return self.mean < MOST_MEAN and self.worst < MOST_WORST


def fairness(case, scene, seeds=SEEDS, emit=last_component, **options):
    """Mean square of bins about their exact expectation over seeds, divided by n p (1 - p)."""
    p, squares, photons = masses(case), np.zeros(GRID.n_patches), 0
    for seed in range(seeds):
        directions = emit(scene.source(seed=seed, **options))
        n = directions[0].size
        photons += n
        squares += (counts(*directions) - n * p) ** 2
    kept = p * photons >= LEAST * seeds
    ratio = squares[kept] / (photons * p[kept] * (1 - p[kept]))
    return Fairness(mean=float(ratio.mean()), worst=float(ratio.max()), n_bins=int(kept.sum()))
