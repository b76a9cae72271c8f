"""Backward paths against the reference tables: spherical radiances and orders, the description's own tool, eclipses."""

import dataclasses

import numpy as np
import pytest
from scipy.special import chdtr

from aomc_sky.skies.atmosphere.backward import path_tables, solve_paths
from aomc_sky.skies.atmosphere.lights import Moon
from tests.skies.atmosphere.reference_tables import MEDIA, column, grouped
from tests.support.atmospheres import molecules_only


def spherical_pulls(n_paths, every):
    """Deviations in combined standard errors of orders 2, 3 and all, (3, n); and how many rows were flagged."""
    found, flagged = [], 0
    made = {}
    groups = grouped("spherical_radiance.csv", "case", "wavelength_nm", "albedo", "sza_deg")
    for seed, ((*air, sun), rows) in enumerate(groups.items()):
        if tuple(air) not in made:
            medium = MEDIA[air[0]](float(air[1]), float(air[2]))
            made[tuple(air)] = medium, path_tables(medium)
        medium, tables = made[tuple(air)]
        some = rows[seed % every :: every]
        result = solve_paths(
            medium, sun_zenith_rad=np.radians(float(sun)), sky_zenith_rad=np.radians(column(some, "vza_deg")),
            azimuth_from_sun_rad=np.radians(column(some, "phi_deg")), n_paths=n_paths, n_orders=40, seed=seed,
            tables=tables, threads=2,
        )  # fmt: skip
        orders, bars = result.radiance_by_order[0], result.standard_error_by_order[0]
        pulls = [
            (orders[k - 1] - column(some, f"L_order{k}")) / np.hypot(bars[k - 1], column(some, f"se_order{k}"))
            for k in (2, 3)
        ]
        bar = np.hypot(result.standard_error[0], column(some, "se_all"))
        found.append([*pulls, (result.radiance[0] - column(some, "L_all")) / bar])
        flagged += int(result.under_sampled.sum())
    return np.concatenate(found, axis=1), flagged


@pytest.mark.parametrize(("n_paths", "every"), [(4000, 10), pytest.param(50_000, 1, marks=pytest.mark.slow)])
def test_spherical_rows(n_paths, every):
    pulls, flagged = spherical_pulls(n_paths, every)
    assert np.abs(pulls).max() < 5.0
    assert np.all(chdtr(pulls.shape[1], np.sum(pulls**2, axis=1)) < 0.9999)
    assert np.all(np.abs(pulls.mean(axis=1)) < 4.5 / np.sqrt(pulls.shape[1]))
    assert flagged <= (10 if every == 1 else 0.05 * pulls.shape[1])
    assert every > 1 or pulls.shape[1] == 945


@pytest.mark.parametrize("offset", ["0.0", "0.3"])
def test_eclipse(offset):
    rows = grouped("eclipse_radiance.csv", "moon_zenith_offset_deg")[(offset,)]
    medium = dataclasses.replace(molecules_only(550.0, 0.1), sun_angular_radius_rad=696350.0 / 149597870.7)
    result = solve_paths(
        medium, sun_zenith_rad=np.radians(45.0), sky_zenith_rad=np.radians(column(rows, "vza_deg")),
        azimuth_from_sun_rad=np.radians(column(rows, "phi_deg")), n_paths=10_000, n_orders=40,
        visible=Moon(zenith_rad=np.radians(45.0 + float(offset)), distance_m=3.65e8), threads=2,
    )  # fmt: skip
    np.testing.assert_allclose(result.radiance_by_order[0, 0], column(rows, "L_order1"), rtol=3e-3)
    second = np.hypot(result.standard_error_by_order[0, 1], column(rows, "se_order2"))
    assert np.all(np.abs(result.radiance_by_order[0, 1] - column(rows, "L_order2")) < 5.0 * second)
    bar = np.hypot(result.standard_error[0], column(rows, "se_all"))
    assert np.all(np.abs(result.radiance[0] - column(rows, "L_all")) < 5.0 * bar)


def test_glowing_ground():
    for (case, wavelength, albedo), rows in grouped(
        "ground_glow_radiance.csv", "case", "wavelength_nm", "albedo"
    ).items():
        medium = dataclasses.replace(MEDIA[case](float(wavelength), float(albedo)), toa_irradiance=np.zeros(1))
        zenith = np.radians(column(rows, "vza_deg"))
        result = solve_paths(
            medium, sun_zenith_rad=1.0, sky_zenith_rad=zenith, azimuth_from_sun_rad=np.zeros_like(zenith),
            n_paths=30_000, n_orders=40, ground_radiance=np.ones(1), threads=2,
        )  # fmt: skip
        for k in (1, 2, 3):
            bar = np.hypot(result.standard_error_by_order[0, k - 1], column(rows, f"se{k}"))
            assert np.all(np.abs(result.radiance_by_order[0, k - 1] - column(rows, f"L_order{k}")) < 5.0 * bar)
        bar = np.hypot(result.standard_error[0], column(rows, "se_all_at_least"))
        assert np.all(np.abs(result.radiance[0] - column(rows, "L_all")) < 5.0 * bar)


@pytest.mark.slow
def test_all_spherical_rows():
    pulls, flagged = spherical_pulls(n_paths=50_000, every=1)
    assert pulls.shape[1] == 945
    assert np.abs(pulls).max() < 5.0
    assert np.all(chdtr(945, np.sum(pulls**2, axis=1)) < 0.9999)
    assert np.all(np.abs(pulls.mean(axis=1)) < 4.5 / np.sqrt(945))
    assert flagged <= 10
