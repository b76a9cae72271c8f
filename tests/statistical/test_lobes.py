"""Samplers of the lobes against the masses of patches; what lies below the horizon is one more cell."""

import numpy as np
import pytest

from aomc_sky.skies.lobes import functions as lobes
from tests.support import chi2
from tests.support.sampled import grid_of_edges

N = 2_000_000
BLOCK = 250_000
LOBES = {
    "isotropic": ("hg", 0.0, 0.0, (1.0, 0.0, 0.0, 0.0)),
    "nearly isotropic": ("hg", 1e-6, 0.0, (0.6, 0.3, -0.2, 0.7)),
    "broad": ("hg", 0.5, 0.0, (0.91, -0.09, 0.24, 0.33)),
    "at the horizon": ("hg", 0.9, 0.0, (1.0, 1.0, 0.0, 0.0)),
    "below the horizon": ("hg", 0.94, 0.0, (-0.585, -0.369, -0.639, 0.338)),
    "needle": ("hg", 0.99999, 0.0, (0.9, 0.3, 0.2, 0.0)),
    "cosine law": ("ggx", 1.0, 1.0, (0.9, 0.1, 0.4, 0.2)),
    "city": ("ggx", 0.25, 1.0, (0.76, -0.084, 0.637, 0.1)),
    "thread": ("ggx", 0.001, 0.7, (0.9, 0.3, 0.2, 0.4)),
    "sunken glow": ("ggx", 0.3, 0.3, (0.6, 0.7, 0.3, 0.0)),
    "band": ("beckmann", 0.3, 1.5, (0.4, -0.108, 0.488, 0.768)),
    "sunken spot": ("beckmann", 0.2, 0.4, (0.66, 0.71, 0.2, 0.1)),
}


def grid_around(kind, param0, param1, quaternion):
    """Ten degrees everywhere, and edges next to the axis at the width of the lobe."""
    x, y, z = lobes.to_world(quaternion, [0.0, 0.0, 1.0])
    width = np.degrees(min(1 - param0 if kind == "hg" else min(param0, param1), 0.2))
    steps = width * np.array([-3.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0])
    zenith = np.degrees(np.arctan2(np.hypot(x, y), z)) + steps
    azimuth = np.degrees(np.arctan2(y, x)) % 360 + steps / max(np.hypot(x, y), 0.2)
    edges = [
        np.unique(np.concatenate([np.linspace(0, end, n), near[(near > 0) & (near < end)]]))
        for end, n, near in ((90.0, 10, zenith), (360.0, 37, azimuth))
    ]
    return grid_of_edges(*edges)


def counts(grid, world):
    """Directions in each patch, and below the horizon."""
    zenith = np.degrees(np.arctan2(np.hypot(world[:, 0], world[:, 1]), world[:, 2]))
    azimuth = np.degrees(np.arctan2(world[:, 1], world[:, 0]))
    return np.bincount(grid.patch_of(zenith, azimuth) + 1, minlength=grid.n_patches + 1)


def patch_p(case, draw, seed=0):
    """p-value of N directions against the masses of patches."""
    kind, param0, param1, quaternion = case
    grid, rng = grid_around(*case), np.random.default_rng(seed)
    observed = np.zeros(grid.n_patches + 1)
    for _ in range(N // BLOCK):
        u, v = rng.random((2, BLOCK))
        observed += counts(grid, lobes.to_world(quaternion, draw(kind, param0, param1, u, v)))
    mass = lobes.patch_mass(kind, param0, param1, quaternion, grid)
    return chi2.chi2_p(observed[1:], N * mass / mass.sum() * observed[1:].sum() / N), observed[0], mass.sum()


# two seconds each
QUICK = ("nearly isotropic", "needle", "city", "sunken spot")
CASES = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in LOBES]


@pytest.mark.parametrize("name", CASES)
def test_patches(plan, name):
    """Over the patches, and how many of all fall below the horizon."""
    p_value, below, above_mass = patch_p(LOBES[name], lobes.sample, seed=list(LOBES).index(name))
    plan.check(p_value)
    plan.check(chi2.binomial_p(int(N - below), N, float(above_mass)))


DEFECTS = {
    "roughness swapped": ("city", lambda kind, a, b, u, v: lobes.sample(kind, b, a, u, v)),
    "azimuth short of a turn by 1 %": ("band", lambda kind, a, b, u, v: lobes.sample(kind, a, b, u, 0.99 * v)),
    "Beckmann wider by 1 %": ("sunken spot", lambda kind, a, b, u, v: lobes.sample(kind, 1.01 * a, b, u, v)),
    "g off by 3 %": ("broad", lambda kind, a, b, u, v: lobes.sample(kind, 1.03 * a, b, u, v)),
    "roughness off by 2 %": ("cosine law", lambda kind, a, b, u, v: lobes.sample(kind, 1.02 * a, b, u, v)),
    "needle wider by 1 %": ("needle", lambda kind, a, b, u, v: lobes.sample(kind, 1 - (1 - a) * 1.01, b, u, v)),
}


@pytest.mark.slow
@pytest.mark.parametrize("defect", DEFECTS)
def test_planted_defects_are_caught(plan_only, defect):
    name, draw = DEFECTS[defect]
    plan_only.catches(patch_p(LOBES[name], draw)[0])
