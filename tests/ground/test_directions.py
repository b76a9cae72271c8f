"""Every frame and convention pinned by whole-number vectors."""

from dataclasses import InitVar, dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from aomc_sky.directions import (
    EDGE_DEG,
    AzimuthConvention,
    Frame,
    arcsin_deg,
    at_quarter_deg,
    in_both_units,
    settle_angles,
    sin_cos_deg,
    sky_from_travel,
    to_enu_azimuth_deg,
    travel_from_sky,
    within_sky_deg,
)

WHOLE = [
    (0, 0, [0, 0, -1]), (90, 0, [-1, 0, 0]), (90, 90, [0, -1, 0]), (90, 180, [1, 0, 0]), (90, 270, [0, 1, 0]),
    (90, 360, [-1, 0, 0]), (90, -90, [0, 1, 0]),
]  # fmt: skip


@pytest.mark.parametrize(("zenith", "azimuth", "travel"), WHOLE)
def test_travel_is_minus_sky(zenith, azimuth, travel):
    np.testing.assert_array_equal(travel_from_sky(zenith, azimuth), travel)
    np.testing.assert_array_equal(travel_from_sky(zenith, azimuth, Frame.DOWN), [*travel[:2], -travel[2]])


def test_there_and_back():
    rng = np.random.default_rng(1)
    zenith, azimuth = rng.uniform(0.001, 90, 500), rng.uniform(0, 360, 500)
    for frame in Frame:
        back_z, back_a = sky_from_travel(travel_from_sky(zenith, azimuth, frame), frame)
        np.testing.assert_allclose(np.rad2deg(back_z), zenith, rtol=1e-12)
        np.testing.assert_allclose(np.rad2deg(back_a), azimuth, rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize(
    ("convention", "given", "ours"),
    [
        (AzimuthConvention.ENU_FROM_EAST, [0, 90, 359], [0, 90, 359]),
        (AzimuthConvention.NORTH_CLOCKWISE, [0, 90, 180, 270], [90, 0, 270, 180]),
        (AzimuthConvention.WEST_OF_SOUTH, [0, 90, -90, 180], [270, 180, 0, 90]),
    ],
)
def test_azimuth_conventions(convention, given, ours):
    np.testing.assert_array_equal(to_enu_azimuth_deg(given, convention), ours)


def test_sine_and_cosine_against_50_digits():
    angle = np.append(np.random.default_rng(2).uniform(-720, 720, 1000), [1e-300, 44.999, 45, 89.9999999, 90.0000001])
    s, c = sin_cos_deg(angle)
    with mp.workdps(50):
        for a, got_s, got_c in zip(angle.tolist(), s.tolist(), c.tolist(), strict=True):
            for got, true in ((got_s, mp.sin(mpf(a) * mp.pi / 180)), (got_c, mp.cos(mpf(a) * mp.pi / 180))):
                assert abs(got - true) < 2.5 * np.spacing(abs(float(true)))
    s, c = sin_cos_deg(np.arange(-720, 721, 90))
    assert set(s.tolist()) | set(c.tolist()) == {-1.0, 0.0, 1.0}
    assert not np.any(np.signbit(s) & (s == 0))
    for sine in (0.0, 1e-300, 0.00465, 0.5, 0.9):
        assert abs(arcsin_deg(sine) - np.rad2deg(np.arcsin(sine))) <= 1e-13


def test_what_rounding_has_put_beyond_the_sky_is_at_its_edge():
    edge = [90.0 + EDGE_DEG, np.nextafter(90, 91), 90.0, np.nextafter(0, -1), -EDGE_DEG, -90.0 - EDGE_DEG]
    assert within_sky_deg(np.array(edge)).tolist() == [90, 90, 90, 0, 0, -90]
    beyond = np.nextafter([90.0 + EDGE_DEG, -EDGE_DEG, -90.0 - EDGE_DEG], [91, -1, -91])
    np.testing.assert_array_equal(within_sky_deg(beyond), beyond)
    inside = np.array([np.nextafter(0, 1), EDGE_DEG, 45.0, 90 - EDGE_DEG, np.nextafter(90, 0)])
    np.testing.assert_array_equal(within_sky_deg(inside), inside)


@given(st.integers(-4, 8), st.floats(-45, 45))
def test_azimuths_are_at_a_quarter_turn_where_they_are_as_near_as_rounding(quarter, beside_deg):
    angle = 90.0 * quarter + np.array([beside_deg, EDGE_DEG, -EDGE_DEG, 1.001 * EDGE_DEG])
    near = np.abs(angle - 90.0 * quarter) <= EDGE_DEG
    assert not near[3]
    np.testing.assert_array_equal(at_quarter_deg(angle), np.where(near, 90.0 * quarter, angle))


def test_the_twin_of_an_angle_is_a_property_and_no_field():
    @in_both_units
    @dataclass(frozen=True, kw_only=True)
    class Sun:
        zenith_deg: float = None
        radius_deg: float = 0.25
        name: str = ""
        zenith_rad: InitVar[float | None] = None
        note: InitVar[str] = ""

        def __post_init__(self, zenith_rad, note):
            settle_angles(self, zenith_deg=zenith_rad)

    sun = Sun(zenith_rad=np.pi / 6, name="ours", note="high")
    assert (sun.zenith_deg, sun.zenith_rad) == (pytest.approx(30.0), np.deg2rad(sun.zenith_deg))
    assert replace(sun, zenith_deg=60.0, note="low") == Sun(zenith_deg=60.0, name="ours")
    assert set(Sun.__dataclass_fields__) == {"zenith_deg", "radius_deg", "name", "note"}


WHERE_IT_IS_NOUGHT = {"EAST": 0, "NORTH": 90, "WEST": 180, "SOUTH": 270, "SUN": 40, "ANTISUN": 220}


@pytest.mark.parametrize(
    "convention", [c for c in AzimuthConvention if not {"ENU", "OF"} & set(c.name.split("_"))], ids=str
)
def test_a_convention_begins_and_turns_as_its_name_says(convention):
    words = convention.name.removeprefix("FROM_").split("_")
    is_clockwise = words[1:] == ["CLOCKWISE"]
    begin = WHERE_IT_IS_NOUGHT[words[0]]
    found = to_enu_azimuth_deg([0, 20], convention, **({"sun_azimuth_deg": 40.0} if convention.is_from_sun else {}))
    assert found.tolist() == [begin, (begin + (-20 if is_clockwise else 20)) % 360]
