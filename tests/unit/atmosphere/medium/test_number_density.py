"""Densities from code blocks: finite and not negative at every altitude, bends found, columns exact."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aomc_sky.atmosphere.medium import NumberDensity
from aomc_sky.errors import InputFileError
from tests.support.atmospheres import OZONE_KINKS_M, ozone_profile
from tests.support.blocks import GIVEN, density_block
from tests.unit.atmosphere.language.test_block_shapes import AEROSOL, MOLECULES, OZONE

TOP_M = 120e3


def density(text: str, top_m: float = TOP_M) -> NumberDensity:
    return NumberDensity(block=density_block(text), given=GIVEN, top_m=top_m)


def test_the_ozone_of_the_reference_has_its_kinks_and_values() -> None:
    ozone = density(OZONE)
    assert ozone.kinks().tolist() == OZONE_KINKS_M.tolist()
    altitude = np.concatenate([np.linspace(0, TOP_M, 1001), OZONE_KINKS_M, np.nextafter(OZONE_KINKS_M, 0)])
    np.testing.assert_allclose(ozone(altitude), ozone_profile(altitude), rtol=3e-15, atol=0)


@pytest.mark.parametrize(
    ("text", "kinks"),
    [
        (MOLECULES, []),
        (AEROSOL, [2000.0]),
        ("return max(0., 1. - altitude/(10*km));", [10e3]),
        ("return abs(altitude - 90.0123*km) < 2. ? 1. : 0.;", [90010.3, 90012.3, 90014.3]),
        ("return altitude > 3. && altitude < 50. ? 1. : 0.;", [3.0, 50.0]),
        ("return altitude <= 7777. ? 2. : 1.;", [7777.0]),
        ("return clamp(altitude, 10., 20.);", [10.0, 20.0]),
        ("return smoothstep(10., 20., altitude);", [10.0, 20.0]),
        ("return step(10., altitude);", [10.0]),
        ("return length(altitude - 7*km);", [7e3]),
        ("return distance(altitude, 7*km) + length(vec2(altitude));", [7e3]),
        ("return 4. + atan(6999.9 - altitude, -1.);", [6999.9]),
        ("return sqr(tan(altitude/(60*km)) - 1e-9);", [60e3 * math.pi / 2]),
        ("return floor(altitude/(50*km));", [50e3, 100e3]),
        ("return float(int(altitude)/50000);", None),
        ("return min(altitude, 5*km) + min(altitude, 5*km);", [5e3]),
        ("float s=0.; for(int i=1; i<4; i++) if(altitude > float(i*i)*km) s += 1.; return s;", [1e3, 4e3, 9e3]),
        ("bool low = altitude < 4*km; return low ? 1. : 2.;", [4e3]),
        ("return float(altitude < 4*km);", [4e3]),
        ("return abs(sign(altitude - 6*km)) * 2.;", [6e3]),
        ("return altitude >= 0. ? 1. : 2.;", []),
        ("return altitude > 0. ? 1. : 2.;", []),
        ("return altitude < 120*km ? 1. : 2.;", []),
    ],
)
def test_kinks(text: str, kinks: list[float] | None) -> None:
    if kinks is None:
        with pytest.raises(InputFileError, match="more than 1000 jumps or bends"):
            density(text).kinks()
        return
    found = density(text).kinks()
    assert found.size == len(kinks)
    np.testing.assert_allclose(found, kinks, rtol=0, atol=1e-6)


def layer(width_m: float) -> str:
    return f"return 1e-9*exp(-altitude/8e3) + exp(-0.5*sqr((altitude - 83.217*km)/{width_m!r}));"


@pytest.mark.parametrize("width_m", [8.0, 30.0, 200.0])
def test_no_quadrature_steps_over_a_thin_smooth_layer(width_m: float) -> None:
    one = density(layer(width_m))
    low, peak, high = one.kinks()
    half = math.sqrt(2 * math.log(2)) * width_m
    spacing = TOP_M / 16384
    assert abs(peak - 83217) <= spacing
    assert 0 <= (83217 - half) - low <= spacing
    assert 0 <= high - (83217 + half) <= spacing
    assert one.column(one.kinks()) == pytest.approx(math.sqrt(2 * math.pi) * width_m, rel=1e-5)
    # to all digits, beside the gas
    assert one.column(one.kinks()) - 1e-9 * 8e3 * -math.expm1(-15) == pytest.approx(
        math.sqrt(2 * math.pi) * width_m, rel=1e-11
    )


def test_a_wide_layer_is_left_to_the_quadratures() -> None:
    assert density(layer(3000.0)).kinks().size == 0
    assert density("return 1 + sin(altitude/10.);").kinks().size <= 300


@pytest.mark.parametrize("top_m", [1.0, 1e6])
def test_kinks_are_found_in_the_thinnest_and_the_thickest_atmosphere(top_m: float) -> None:
    found = density(f"return altitude < {top_m / 3!r} ? 1. : 2.;", top_m).kinks()
    assert found.tolist() == [top_m / 3]


def column(text: str, top_m: float = TOP_M) -> float:
    one = density(text, top_m)
    return one.column(one.kinks())


def test_columns_are_those_of_the_integral() -> None:
    assert column("return exp(-altitude/8000.);") == pytest.approx(-8000 * math.expm1(-15), rel=1e-12)
    assert column("return exp(-altitude);") == pytest.approx(1.0, rel=1e-12)
    assert column("return exp(-altitude/0.5);", 1e6) == pytest.approx(0.5, rel=1e-12)
    assert column("return 3.;") == pytest.approx(3 * TOP_M, rel=1e-14)
    assert column("return altitude < 7777. ? 2. : 0.;") == pytest.approx(2 * 7777.0, rel=1e-12)
    assert column("return abs(altitude - 90.0123*km) < 2. ? 1. : 0.;") == pytest.approx(4.0, rel=1e-9)
    assert column("return 0.;") == 0.0
    pieces = 370 * 2.687e20 * ozone_integral()
    assert column(OZONE) == pytest.approx(pieces, rel=1e-12)


def ozone_integral() -> float:
    """Of the four pieces, in closed form: kilometres of their formulas to metres."""
    lines = [
        (0.0, 8.0, 7.2402403521159135e-6, -1.206527437798165e-7),
        (8.0, 21.5, -2.0590185333577628e-5, 3.3581504669318765e-6),
        (21.5, 39.0, 1.0542813563268143e-4, -2.50316678731273e-6),
    ]
    total = sum(a * (high - low) + b * (high * high - low * low) / 2 for low, high, a, b in lines)
    k = 0.2208669270720561
    return 1000.0 * (total + 0.04298160111157969 * (math.exp(-k * 39) - math.exp(-k * 120)) / k)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("return altitude - 10.;", "it is -10, altitude 0 m"),
        ("return 1./altitude;", "it is inf, altitude 0 m"),
        ("return pow(10., 400.);", "it is inf, altitude 0 m"),
        ("return exp(altitude);", "it is inf, altitude 120000 m"),
        ("return altitude/altitude;", "it is nan, altitude 0 m"),
        ("return altitude < 7777. ? 1. : altitude < 7778. ? -1. : 2.;", "it is -1, altitude 777"),
        ("return altitude == 120*km ? -1. : 1.;", "it is -1, altitude 120000 m"),
        ("return 1 - altitude/(119.999*km);", "it is -8.3"),
    ],
)
def test_a_density_that_is_none_is_refused_with_its_altitude(text: str, message: str) -> None:
    with pytest.raises(InputFileError) as caught:
        density(text).kinks()
    problem = caught.value.problems[0]
    assert message in problem.message
    assert (problem.code, problem.line) == ("E403", 10)


def test_an_altitude_between_the_samples_is_checked_when_it_is_asked_for() -> None:
    # no branch leads to this hole of a nanometre
    hidden = density("return altitude*altitude - 1.0e4*altitude + 2.5e7 - 1e-4 > 0. ? 1. : 1. - 1./0.;")
    with pytest.raises(InputFileError, match="altitude 5000 m"):
        hidden(np.array([4000.0, 5000.0]))


def test_rounding_beyond_the_ends_is_taken_for_the_ends() -> None:
    root = density("return sqrt(altitude) + sqrt(120*km - altitude);")
    ends = root(np.array([-1e-9, 0.0, TOP_M, TOP_M + 1e-9]))
    assert ends.tolist() == [math.sqrt(TOP_M)] * 4


def test_any_shape_of_altitudes_is_kept() -> None:
    altitude = np.linspace(0, TOP_M, 12).reshape(3, 4)
    assert density(OZONE)(altitude).shape == (3, 4)
    assert density("return 2.;")(altitude).tolist() == [[2.0] * 4] * 3
