"""Photons of the Perez sky against the continuous law: cells finer than the patches, rings around the sun, means."""

import warnings
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import ModelLimitWarning
from aomc_sky.skies.perez.sky import PerezSky
from tests.reference import perez_law
from tests.support import chi2
from tests.support.perez_cases import CASES, CLIPPED, cell_counts, cell_p, cell_shares, cone_p, photon_p_values
from tests.support.sampled import scene, sky_angles

EDGES = [1.0, 1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2, 12.0]


STATES = [
    (epsilon, delta, sun_deg)
    for low, high in pairwise(EDGES)
    for epsilon in (low, (low + high) / 2, high - 1e-3)
    for delta, sun_deg in ((0.2, 15.0), (0.35, 55.0), (0.25, 80.0))
]

N = 2_000_000
SUN_AZIMUTH_DEG = 25.0
TEN_DEGREES = sky.PatchGrid.regular(9, 36)


FREE = {"method": "iid", "precision": "float64"}


def angles_of(model, n, **options):
    """mu, sin^2 of the zenith angle, azimuth [rad] of the photons of a model."""
    mu, u, azimuth_deg = sky_angles(scene(model, n).source(**options).photons())
    return mu, u, np.deg2rad(azimuth_deg)


def photons(case, *, seed=6, within="exact", turn_deg=0.0, grid=TEN_DEGREES, n=N, **options):
    """The same of a sky, the azimuth from the sun."""
    sun = {"sun_zenith_deg": case.sun_zenith_deg, "sun_azimuth_deg": SUN_AZIMUTH_DEG + turn_deg}
    model = PerezSky(**sun, epsilon=case.epsilon, delta=case.delta, grid=grid, within=within)
    mu, u, azimuth = angles_of(model, n, seed=seed, **options)
    return mu, u, np.mod(azimuth - np.deg2rad(SUN_AZIMUTH_DEG), 2 * np.pi)


@pytest.mark.parametrize("name", CASES)
def test_independent_photons(plan, name):
    case, seed = CASES[name], list(CASES).index(name)
    n = N if name == "narrow aureole" else N // 2  # so many as the planted defects of this one need
    for p_value in photon_p_values(case.law, *photons(case, seed=seed, n=n, **FREE)).values():
        plan.check(p_value)


GRIDS = [((9, 36), "float32", N)]
GRIDS += [pytest.param(shape, "float64", N // 4, marks=pytest.mark.slow) for shape in ((1, 1), (2, 3), (45, 180))]


@pytest.mark.parametrize(("shape", "precision", "n"), GRIDS)
def test_any_grid(plan, shape, precision, n):
    """In float32; and one patch for the whole sky, patches that the sun's azimuth cuts, and the default: one law."""
    case, grid = CASES["narrow aureole"], sky.PatchGrid.regular(*shape)
    angles = photons(case, seed=shape[0], grid=grid, n=n, method="iid", precision=precision)
    plan.check(cell_p(case.law, *angles))
    plan.check(cone_p(case.law, *perez_law.around_the_sun(case.law, *angles)))


@pytest.mark.slow
@pytest.mark.parametrize("name", CLIPPED)
def test_clipped_skies(plan, name):
    """Where eq. (1) is negative nothing is emitted, and the rest keeps its law."""
    law = CLIPPED[name]
    with pytest.warns(ModelLimitWarning, match="negative"):
        model = PerezSky(sun_zenith_rad=law.sun_zenith_rad, coefficients=law.coefficients, grid=TEN_DEGREES)
    angles = angles_of(model, N, seed=7, **FREE)
    gamma, psi = perez_law.around_the_sun(law, *angles)
    assert law.luminance(angles[0], gamma).min() > 0
    plan.check(cell_p(law, *angles))
    plan.check(cone_p(law, gamma, psi))


@pytest.mark.parametrize("name", CASES)
def test_stratified_photons(plan, name):
    """The default is not farther from the law than chance, and in cells of an eighth of a patch clearly nearer."""
    case = CASES[name]
    counts, expected = cell_counts(*photons(case, precision="float64")), cell_shares(case.law) * N
    plan.check(chi2.upper_p(counts, expected))
    large = expected >= 1000
    assert chi2.per_degree(counts[large], expected[large]) < 0.5


@pytest.mark.parametrize("method", ["iid", "stratified"])
def test_planted_uniform_patches(plan_only, method):
    """Patches of constant radiance: right in every patch, wrong inside."""
    case = CASES["narrow aureole"]
    angles = photons(case, n=N // 2, within="uniform", method=method, precision="float64")
    counts = cell_counts(*angles)
    plan_only.catches(chi2.upper_p(counts, cell_shares(case.law) * (N // 2)))
    if method == "iid":
        p_values = photon_p_values(case.law, *angles)
        for name in ("cells", "cone", "beside the sun"):
            plan_only.catches(p_values[name])


@pytest.mark.parametrize("defect", ["sun turned by 0.6 degrees", "aureole 3 % wider", "other bin"])
def test_planted_defects(plan_only, defect):
    case = CASES["narrow aureole"]
    law = case.law
    turn_deg = 0.6 if "turned" in defect else 0.0
    if "wider" in defect:
        a, b, c, d, e = law.coefficients
        law = replace(law, coefficients=(a, b, c, d / 1.03, e))
    planted = replace(case, epsilon=6.1) if defect == "other bin" else case
    angles = photons(planted, turn_deg=turn_deg, **FREE)
    plan_only.catches(cone_p(law, *perez_law.around_the_sun(law, *angles)))


@pytest.mark.slow
@pytest.mark.parametrize("state", STATES, ids=lambda state: "-".join(f"{value:.3g}" for value in state))
def test_states_of_all_clearness_bins(plan, state):
    epsilon, delta, sun_deg = state
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelLimitWarning)
        model = PerezSky(sun_zenith_deg=sun_deg, epsilon=epsilon, delta=delta, grid=TEN_DEGREES)
    law = perez_law.PerezLaw(
        coefficients=tuple(model.model_coefficients.tolist()), sun_zenith_rad=model.sun_zenith_rad, tolerance=1e-6
    )
    angles = angles_of(model, 300_000, seed=9, **FREE)
    plan.check(cell_p(law, *angles))
    plan.check(chi2.mean_p(angles[0], perez_law.mean(law, lambda x, y, mu: mu)))
