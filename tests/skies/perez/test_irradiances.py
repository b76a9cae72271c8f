"""Two of GHI, DNI and DHI say the third: exact arithmetic, pvlib, the edges, and what no sun can give."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.skies.perez.irradiances import closed_irradiances
from aomc_sky.skies.perez.sky import PerezSky

ULP, LEAST = 2.0**-52, 2.0**-1074
zeniths = st.floats(0.0, 89.9)


@given(st.floats(0.0, 1300.0), st.floats(0.0, 49.0), zeniths)
def test_any_two_give_the_third(dni, dhi, zenith):
    with mp.workdps(40):
        cosine = mp.cos(mp.radians(mp.mpf(zenith)))
        ghi = float(mp.mpf(dhi) + mp.mpf(dni) * cosine)
        exact_dni = float((mp.mpf(ghi) - mp.mpf(dhi)) / cosine)
        exact_dhi = float(max(mp.mpf(ghi) - mp.mpf(dni) * cosine, 0))
    found = closed_irradiances(ghi=ghi, dhi=dhi, sun_zenith_deg=zenith)
    assert abs(found[0] - max(exact_dni, 0.0)) <= 4 * max(ULP * abs(exact_dni), LEAST)
    assert found[1] == dhi
    found = closed_irradiances(ghi=ghi, dni=dni, sun_zenith_deg=zenith)
    assert abs(found[1] - exact_dhi) <= 4 * max(ULP * ghi, ULP * dni * float(cosine), LEAST)
    assert found[0] == dni
    found = closed_irradiances(ghi=ghi, dni=dni, dhi=dhi, sun_zenith_deg=zenith)
    assert tuple(map(float, found)) == (dni, dhi)


def test_what_instruments_show_below_0_and_above_the_global():
    direct, diffuse = closed_irradiances(ghi=30.0, dhi=-3.0, sun_zenith_deg=80.0)
    assert float(diffuse) == 0
    assert float(direct) == pytest.approx(30 / math.cos(math.radians(80.0)))
    with pytest.warns(ModelLimitWarning, match="its irradiances: dhi 102 exceeds ghi 100"):
        sky = PerezSky(sun_zenith_rad=0.5, ghi=100.0, dhi=102.0)
    assert (sky.dni, sky.dhi) == (0.0, 102.0)
    with pytest.raises(SceneError, match="strict"):
        PerezSky(sun_zenith_rad=0.5, ghi=100.0, dhi=102.0, strict=True)
    PerezSky(sun_zenith_rad=0.5, ghi=100.0, dhi=100.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"ghi": 500.0, "dhi": 526.0, "sun_zenith_deg": 74.9, "extraterrestrial_normal": 5e3}, "dhi 526 W m-2 is more"),
        ({"ghi": 100.0, "dhi": 111.0, "sun_zenith_deg": 75.0}, "dni would be negative"),
        ({"ghi": 20.0, "dhi": 25.01, "sun_zenith_deg": 80.0}, "dni would be negative"),
        ({"ghi": 20.0, "dhi": 15.0, "sun_zenith_deg": 94.0}, "its zenith angle is 94 degrees"),
        ({"ghi": 541.0, "dni": 800.0, "dhi": 100.0, "sun_zenith_deg": 60.0}, "good instruments agree to 8 %"),
        ({"ghi": 400.0, "dni": 800.0, "dhi": 140.0, "sun_zenith_deg": 75.0}, "= 347.1 W m-2 .* agree to 15 %"),
        ({"dni": 0.0, "dhi": 1394.0, "sun_zenith_deg": 0.0}, "1393 W m-2 for 1361.1 outside the atmosphere"),
        ({"dni": 0.0, "dhi": 101.0, "sun_zenith_deg": 90.0}, "100 W m-2 for 1361.1"),
        ({"dni": 1430.0, "dhi": 95.0, "sun_zenith_deg": 30.0}, "dni 1430 W m-2 is more than any sky lets through"),
        # 500, 300 and 240 W m-2 in kJ m-2 of an hour
        ({"dni": 1080.0, "dhi": 864.0, "sun_zenith_deg": 31.7}, "1783 W m-2, which is more .* 3.6 kJ m-2 in an hour"),
        ({"ghi": 1783.0, "dni": 1080.0, "dhi": 864.0, "sun_zenith_deg": 31.7}, "check their unit"),
        ({"ghi": 3.0, "sun_zenith_deg": 4.0}, "two of ghi, dni and dhi make a sky, got ghi"),
        ({"dni": 0.0, "dhi": 1.0, "sun_zenith_deg": 30.0, "extraterrestrial_normal": 0.0}, "positive"),
    ],
)
def test_what_no_sun_can_give(given, words):
    with pytest.raises((SceneError, UsageError), match=words):
        closed_irradiances(**given)


@pytest.mark.parametrize(
    "given",
    [
        {"ghi": 500.0, "dhi": 524.0, "sun_zenith_deg": 60.0},
        {"ghi": 20.0, "dhi": 24.99, "sun_zenith_deg": 80.0},
        {"ghi": 539.0, "dni": 800.0, "dhi": 100.0, "sun_zenith_deg": 60.0},
        {"ghi": 397.0, "dni": 800.0, "dhi": 140.0, "sun_zenith_deg": 75.1},
        {"dni": 0.0, "dhi": 1392.0, "sun_zenith_deg": 0.0},
        {"dni": 1429.0, "dhi": 95.0, "sun_zenith_deg": 30.0},
        {"dni": 1000.0, "dhi": 860.0, "sun_zenith_deg": 31.7},
    ],
)
def test_what_instruments_differ_by_is_accepted(given):
    direct, diffuse = closed_irradiances(**given)
    assert (direct, diffuse) == (given.get("dni", 0.0), given["dhi"])


CLEAR = {"dni": 850.0, "dhi": 95.0}
GHI = 850.0 * math.cos(0.5) + 95.0


@pytest.mark.parametrize("given", [{"ghi": GHI, "dhi": 95.0}, {"ghi": GHI, "dni": 850.0}, {"ghi": 860.0, **CLEAR}])
def test_a_sky_from_any_two(given):
    one, other = PerezSky(sun_zenith_rad=0.5, **CLEAR), PerezSky(sun_zenith_rad=0.5, **given)
    assert (other.dni, other.dhi) == (pytest.approx(850.0, rel=1e-14), pytest.approx(95.0, rel=1e-12))
    np.testing.assert_allclose(other.model_coefficients, one.model_coefficients, rtol=1e-11)
    assert other.radiance(0.3, 0.2, 550.0) == pytest.approx(float(one.radiance(0.3, 0.2, 550.0)), rel=1e-11)
