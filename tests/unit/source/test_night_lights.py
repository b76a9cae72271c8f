"""Moon and glow as sky.toml, options and arguments ask for them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aomc_sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import MoonDirection
from aomc_sky.source.atmospheres.medium import MediumReport, glow_of_luminance, moon_of_direction
from tests.support.atmospheres import molecules_only
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

RADIUS = 6.371e6
DESCRIPTION = INPUTS / "light_polluted" / "air.atmo"


def report(**more: Any) -> MediumReport:
    return MediumReport(wavelength_index=np.zeros(1, np.intp), optical_depth={}, phase_norm={}, dropped=(), **more)


def test_angles_and_offsets() -> None:
    assert MoonDirection(zenith_deg=50.0).angles(40.0, 90.0) == (50.0, 0.0)
    assert MoonDirection(zenith_offset_deg=-0.5, azimuth_offset_deg=0.25).angles(40.0, 90.0) == (39.5, 0.25)
    assert MoonDirection(azimuth_deg=100.0).angles(40.0, 90.0) == (40.0, 10.0)


def test_options_win_angle_by_angle() -> None:
    file = MoonDirection(zenith_offset_deg=0.1, azimuth_deg=20.0, distance_km=4e5)
    assert file.under(MoonDirection(zenith_deg=30.0)) == MoonDirection(
        zenith_deg=30.0, azimuth_deg=20.0, distance_km=4e5
    )
    assert file.under(MoonDirection()) == file
    assert file.under(MoonDirection(azimuth_offset_deg=0.0)).azimuth_deg is None


@pytest.mark.parametrize("zenith", [0.0, 60.0, 90.0, 120.0])
def test_distance_between_the_centres_becomes_that_of_the_observer(zenith: float) -> None:
    air = molecules_only(550.0, 0.1)
    moon = moon_of_direction(MoonDirection(zenith_deg=zenith), air, report(moon_distance_m=3.844e8), 45.0, 0.0)
    assert moon is not None
    assert np.linalg.norm(moon.centre_m(RADIUS)) == pytest.approx(3.844e8, rel=1e-12)
    given = moon_of_direction(MoonDirection(zenith_deg=zenith, distance_km=365e3), air, report(), 45.0, 0.0)
    assert given is not None
    assert given.distance_m == 3.65e8


def test_no_moon_without_a_place_and_none_without_a_distance() -> None:
    air = molecules_only(550.0, 0.1)
    assert moon_of_direction(MoonDirection(), air, report(), 45.0, 0.0) is None
    with pytest.raises(SceneError, match="how far away"):
        moon_of_direction(MoonDirection(zenith_deg=1.0), air, report(), 45.0, 0.0)
    with pytest.raises(SceneError, match="inside the earth"):
        moon_of_direction(MoonDirection(zenith_deg=1.0), air, report(moon_distance_m=6e6), 45.0, 0.0)


def test_luminance_times_spectrum() -> None:
    spectrum = np.array([2e-5, 1e-6])
    np.testing.assert_array_equal(glow_of_luminance(0.5, report(ground_glow=spectrum), "a"), 0.5 * spectrum)
    assert glow_of_luminance(0.0, report(), "a") is None
    wrong: list[tuple[Any, str]] = [
        (-1.0, "0 cd/m2 or more"),
        (math.nan, "0 cd/m2 or more"),
        ("bright", "got 'bright'"),
    ]
    for bad, message in (*wrong, (1.0, "light pollution")):
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
        (3, "must be a mapping"),
        ({"zenith": 1.0}, "no input 'moon_zenith'"),
        ({"zenith_deg": 1.0, "zenith_offset_deg": 1.0}, "twice"),
        ({"zenith_deg": 181.0}, "outside the range"),
        ({"distance_km": math.nan}, "not finite"),
    ],
)
def test_wrong_moons(moon: Any, message: str) -> None:
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


def night_scene(folder: Path, more: str) -> Path:
    """The scene `eclipse` in a folder, with order 1 alone, few patches, and other lines in sky.toml."""
    amc = copy_scene("eclipse", folder)
    keys = 'file = "air.atmo"\norders = 1\nzenith_bins = 6\nazimuth_bins = 12\n'
    (amc.parent / "sky.toml").write_text(f"[atmosphere]\n{keys}{more}")
    return amc


SUN = "[sun]\nzenith_deg = 55\nazimuth_deg = 90\n"


def test_a_scene_says_that_the_moon_hides_nothing(tmp_path: Path) -> None:
    scene = aomc_sky.read_scene(night_scene(tmp_path, f"moon_zenith_deg = 20\n{SUN}"))
    assert any("hides no part" in note for note in scene.notes)
    assert scene.options["atmosphere"]["eclipse"] is None


@pytest.mark.slow
def test_an_eclipse_of_the_file_is_that_of_the_options(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / name).mkdir()
    moon = "moon_zenith_offset_deg = 0.1\nmoon_azimuth_deg = 90.2\n"
    file = aomc_sky.read_scene(night_scene(tmp_path / "a", moon + SUN))
    given = {"moon_zenith_deg": 55.1, "moon_azimuth_offset_deg": 0.2}
    clear = night_scene(tmp_path / "b", SUN)
    options, whole = aomc_sky.read_scene(clear, atmosphere=given), aomc_sky.read_scene(clear)
    for one, other in zip(file.components, options.components, strict=True):
        np.testing.assert_allclose(one.mass, other.mass, rtol=1e-6)
    share = file.options["atmosphere"]["eclipse"]["visible_share"]
    assert 0.05 < share < 0.95
    np.testing.assert_allclose(file.components[0].strength, share * whole.components[0].strength, rtol=1e-13)
    sky = file.components[1].mass_of(0).reshape(6, 12)
    assert np.abs(sky[:, 2] / sky[:, 3] - 1.0).max() > 1e-3  # on both sides of the sun, which stands between them
    plain = whole.components[1].mass_of(0).reshape(6, 12)
    np.testing.assert_allclose(plain[:, 2], plain[:, 3], rtol=1e-12)


@pytest.mark.slow
def test_a_night_scene_is_linear_in_luminance(tmp_path: Path) -> None:
    amc = night_scene(tmp_path, "ground_luminance_cd_m2 = 0.25\n[sun]\nzenith_deg = 130\n")
    one, two = aomc_sky.read_scene(amc), aomc_sky.read_scene(amc, atmosphere={"ground_luminance_cd_m2": 0.5})
    assert [component.name for component in one.components] == ["atmosphere"]
    np.testing.assert_allclose(two.components[0].mass, 2.0 * one.components[0].mass, rtol=1e-14)
    assert any("glows with 0.25 cd/m2" in note for note in one.notes)
