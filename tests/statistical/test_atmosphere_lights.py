"""Eclipses and a glowing ground through the whole chain, series and all, against the reference tables."""

from __future__ import annotations

import csv
import dataclasses
import math

import numpy as np
import pytest

from aomc_sky.atmosphere.lights import Moon
from aomc_sky.atmosphere.optical_depth import optical_depth_to_top
from aomc_sky.atmosphere.sky.solve import solve
from tests.support.atmospheres import mol_ozone, molecules_only
from tests.support.shared import SHARED, needs_shared

TABLES = SHARED / "atmosphere"
SUN_RADIUS = 696350.0 / 149597870.7
pytestmark = [needs_shared, pytest.mark.slow]


def rows_of(name: str, **wanted: str) -> list[dict[str, str]]:
    with (TABLES / name).open() as file:
        return [row for row in csv.DictReader(file) if all(row[key] == value for key, value in wanted.items())]


@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches")
@pytest.mark.filterwarnings("ignore:the paths give orders 2 and up")
@pytest.mark.parametrize("offset", ["0.0", "0.3"])
def test_eclipse_of_the_whole_sky(offset: str) -> None:
    rows = rows_of("eclipse_radiance.csv", moon_zenith_offset_deg=offset)
    medium = dataclasses.replace(molecules_only(550.0, 0.1), sun_angular_radius_rad=SUN_RADIUS, n_orders=40)
    zenith, azimuth = (sorted({float(row[key]) for row in rows}) for key in ("vza_deg", "phi_deg"))
    found = solve(
        medium,
        sun_zenith_rad=math.radians(45.0),
        sky_zenith_rad=np.radians(zenith),
        azimuth_from_sun_rad=np.radians(azimuth),
        moon=Moon(zenith_rad=math.radians(45.0 + float(offset)), distance_m=3.65e8),
    )
    assert found.method == "mc"
    share = float(rows[0]["visible_fraction_at_observer"])
    whole = math.cos(math.radians(45.0)) * math.exp(
        -float(np.ravel(optical_depth_to_top(medium, 0.0, math.radians(45.0)))[0])
    )
    assert found.direct_irradiance[0] == pytest.approx(share * whole, rel=2e-3, abs=1e-12)
    for row in rows:
        place = 0, zenith.index(float(row["vza_deg"])), azimuth.index(float(row["phi_deg"]))
        bar = math.hypot(found.standard_error[place], float(row["se_all"]))
        assert abs(found.radiance[place] - float(row["L_all"])) < 5.0 * bar
        assert found.radiance_by_order[0, 0][place[1:]] == pytest.approx(float(row["L_order1"]), rel=3e-3)


@pytest.mark.parametrize("case", ["rayleigh", "mol_ozone"])
def test_glow_of_the_whole_sky(case: str) -> None:
    maker = {"rayleigh": molecules_only, "mol_ozone": mol_ozone}[case]
    rows = rows_of("ground_glow_radiance.csv", case=case)
    rows = [
        row for row in rows if row["wavelength_nm"] == rows[0]["wavelength_nm"] and row["albedo"] == rows[0]["albedo"]
    ]
    medium = dataclasses.replace(maker(float(rows[0]["wavelength_nm"]), float(rows[0]["albedo"])), n_orders=40)
    found = solve(
        medium,
        sun_zenith_rad=math.pi,
        sky_zenith_rad=[math.radians(float(row["vza_deg"])) for row in rows],
        azimuth_from_sun_rad=[0.0, 1.0],
        ground_radiance=np.ones(1),
    )
    assert found.method == "mc"
    np.testing.assert_array_equal(found.radiance[..., 0], found.radiance[..., 1])
    np.testing.assert_array_equal(found.direct_irradiance, 0.0)
    for k, row in enumerate(rows):
        bar = math.hypot(found.standard_error[0, k, 0], float(row["se_all_at_least"]))
        assert abs(found.radiance[0, k, 0] - float(row["L_all"])) < 5.0 * bar
