"""Moon and glow as sky.toml, options and arguments ask for them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aomc_sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.formats.moon_place import MoonPlace
from aomc_sky.source.atmosphere_medium import MediumReport
from aomc_sky.source.night_lights import glow_of_luminance, moon_of_place
from tests.support.atmospheres import molecules_only
from tests.support.shared import INPUTS

RADIUS = 6.371e6
DESCRIPTION = INPUTS / "light_polluted" / "air.atmo"


def report(**more: Any) -> MediumReport:
    return MediumReport(wavelength_index=np.zeros(1, np.intp), optical_depth={}, phase_norm={}, dropped=(), **more)


def test_angles_and_offsets() -> None:
    assert MoonPlace(zenith_deg=50.0).angles(40.0, 90.0) == (50.0, 0.0)
    assert MoonPlace(zenith_offset_deg=-0.5, azimuth_offset_deg=0.25).angles(40.0, 90.0) == (39.5, 0.25)
    assert MoonPlace(azimuth_deg=100.0).angles(40.0, 90.0) == (40.0, 10.0)


def test_options_win_angle_by_angle() -> None:
    file = MoonPlace(zenith_offset_deg=0.1, azimuth_deg=20.0, distance_km=4e5)
    assert file.under(MoonPlace(zenith_deg=30.0)) == MoonPlace(zenith_deg=30.0, azimuth_deg=20.0, distance_km=4e5)
    assert file.under(MoonPlace()) == file
    assert file.under(MoonPlace(azimuth_offset_deg=0.0)).azimuth_deg is None


@pytest.mark.parametrize("zenith", [0.0, 60.0, 90.0, 120.0])
def test_distance_between_the_centres_becomes_that_of_the_observer(zenith: float) -> None:
    air = molecules_only(550.0, 0.1)
    moon = moon_of_place(MoonPlace(zenith_deg=zenith), air, report(moon_distance_m=3.844e8), 45.0, 0.0)
    assert moon is not None
    assert np.linalg.norm(moon.centre_m(RADIUS)) == pytest.approx(3.844e8, rel=1e-12)
    given = moon_of_place(MoonPlace(zenith_deg=zenith, distance_km=365e3), air, report(), 45.0, 0.0)
    assert given is not None
    assert given.distance_m == 3.65e8


def test_no_moon_without_a_place_and_none_without_a_distance() -> None:
    air = molecules_only(550.0, 0.1)
    assert moon_of_place(MoonPlace(), air, report(), 45.0, 0.0) is None
    with pytest.raises(SceneError, match="how far away"):
        moon_of_place(MoonPlace(zenith_deg=1.0), air, report(), 45.0, 0.0)
    with pytest.raises(SceneError, match="inside the earth"):
        moon_of_place(MoonPlace(zenith_deg=1.0), air, report(moon_distance_m=6e6), 45.0, 0.0)


def test_luminance_times_spectrum() -> None:
    spectrum = np.array([2e-5, 1e-6])
    np.testing.assert_array_equal(glow_of_luminance(0.5, report(ground_glow=spectrum), "a"), 0.5 * spectrum)
    assert glow_of_luminance(0.0, report(), "a") is None
    for bad, message in ((-1.0, "0 cd/m2 or more"), (math.nan, "0 cd/m2 or more"), (1.0, "light pollution")):
        with pytest.raises(SceneError, match=message):
            glow_of_luminance(bad, report(), "a")


def solved(**given: Any) -> aomc_sky.AtmosphereResult:
    return aomc_sky.solve_atmosphere(
        DESCRIPTION, wavelength_nm=450.0, sky_zenith_deg=[20.0], azimuth_from_sun_deg=[0.0], orders=1, **given
    )


@pytest.mark.parametrize(
    ("moon", "message"),
    [
        ({}, "no place"),
        ({"zenith": 1.0}, "no input 'moon_zenith'"),
        ({"zenith_deg": 1.0, "zenith_offset_deg": 1.0}, "twice"),
        ({"zenith_deg": 181.0}, "outside the range"),
        ({"distance_km": math.nan}, "not finite"),
    ],
)
def test_wrong_moons(moon: dict[str, float], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        solved(sun_zenith_deg=40.0, moon=moon)


def test_moon_elsewhere_changes_no_bit() -> None:
    with_moon = solved(sun_zenith_deg=40.0, moon={"zenith_offset_deg": 20.0})
    without = solved(sun_zenith_deg=40.0)
    np.testing.assert_array_equal(with_moon.radiance, without.radiance)
    np.testing.assert_array_equal(with_moon.diffuse_irradiance, without.diffuse_irradiance)


def test_lights_without_an_atmosphere_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="only beside"):
        aomc_sky.read_scene(INPUTS / "overcast" / "amc.inp", atmosphere={"ground_luminance_cd_m2": 1.0})
    with pytest.raises(UsageError, match="no input 'orders'"):
        aomc_sky.read_scene(INPUTS / "overcast" / "amc.inp", atmosphere={"orders": 1.0})
