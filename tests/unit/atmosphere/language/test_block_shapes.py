"""Blocks of the shapes that published descriptions have, against plain Python, altitude by altitude."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from aomc_sky.atmosphere.language.block import Block
from tests.support.blocks import GIVEN, WAVELENGTHS, density_block, phase_block

ALTITUDES = np.linspace(0.0, 120e3, 241)
COSINES = np.cos(np.linspace(0.0, np.pi, 181))
DOBSON = 2.687e20

MOLECULES = """
    CONST float rayleighScaleHeight=8*km;
    return 3.08458e25*exp(-1/rayleighScaleHeight * altitude);
"""
AEROSOL = """
    const float scaleHeight = 1.2*km; // mixed layer and above
    if(altitude < 2.*km)
        return 1.03333e8*exp(-altitude/scaleHeight);
    return 1.03333e8*exp(-2.*km/scaleHeight)*exp(-(altitude-2*km)/(2.4*km));
"""
OZONE = """
    CONST float totalColumn=370*dobsonUnit;
    CONST float altInKm=altitude/km;
    float density;
    if(altitude<8*km)
        density=7.2402403521159135e-6 - 1.206527437798165e-7*altInKm;
    else if(altitude<21.5*km)
        density=-2.0590185333577628e-5 + 3.3581504669318765e-6*altInKm;
    else if(altitude<39*km)
        density=1.0542813563268143e-4 - 2.50316678731273e-6*altInKm;
    else
        density=0.04298160111157969*exp(-0.2208669270720561*altInKm);
    density*=totalColumn;
    return density;
"""
POWER = """
    float h = 3.*altitude/atmosphere;
    return 1.0744578e24*pow(1/(1 + h), 2.5);
""".replace("atmosphere", "(120*km)")
RAYLEIGH = """
    return vec4(3./(16*PI)*(1+sqr(dotViewSun)));
"""
CORNETTE = """
    CONST float g=0.76;
    CONST float g2=g*g;
    CONST float k=3/(8*PI)*(1-g2)/(2+g2);
    return vec4(k*(1+sqr(dotViewSun))/pow(1+g2-2*g*dotViewSun, 1.5));
"""
PEAKED = """
    CONST float g=0.76;
    CONST float k=3/(8*PI)*(1-g*g)/(2+g*g);
    float value = k*(1+dotViewSun*dotViewSun)/pow(1+g*g-2*g*dotViewSun,1.5);
    value += 1/(600*(1-dotViewSun)+0.05);
    value *= 0.904;
    return vec4(value);
"""
COLOURED = """
    CONST vec4 g = 0.6 + 0.2*exp(-0.00002*sqr(wavelengths-300)); // à la carte
    CONST vec4 g2 = g*g;
    return vec4((1-g2)/(4*PI*pow(vec4(1+g2-2*g*dotViewSun), vec4(1.5))));
"""


def aerosol(h: float) -> float:
    if h < 2000.0:
        return 1.03333e8 * math.exp(-h / 1200.0)
    return 1.03333e8 * math.exp(-2000.0 / 1200.0) * math.exp(-(h - 2000.0) / 2400.0)


def ozone(h: float) -> float:
    x = h / 1000.0
    if h < 8000.0:
        y = 7.2402403521159135e-6 - 1.206527437798165e-7 * x
    elif h < 21500.0:
        y = -2.0590185333577628e-5 + 3.3581504669318765e-6 * x
    elif h < 39000.0:
        y = 1.0542813563268143e-4 - 2.50316678731273e-6 * x
    else:
        y = 0.04298160111157969 * math.exp(-0.2208669270720561 * x)
    return y * (370 * DOBSON)


def cornette(c: float) -> float:
    g = 0.76
    k = 3 / (8 * math.pi) * (1 - g * g) / (2 + g * g)
    return k * (1 + c * c) / math.pow(1 + g * g - 2 * g * c, 1.5)


DENSITIES: dict[str, tuple[str, Callable[[float], float]]] = {
    "molecules": (MOLECULES, lambda h: 3.08458e25 * math.exp(-1 / 8000.0 * h)),
    "aerosol": (AEROSOL, aerosol),
    "ozone": (OZONE, ozone),
    "power": (POWER, lambda h: 1.0744578e24 * math.pow(1 / (1 + 3.0 * h / 120e3), 2.5)),
}
GREY_PHASES: dict[str, tuple[str, Callable[[float], float]]] = {
    "rayleigh": (RAYLEIGH, lambda c: 3.0 / (16 * math.pi) * (1 + c * c)),
    "cornette": (CORNETTE, cornette),
    "peaked": (PEAKED, lambda c: (cornette(c) + 1 / (600 * (1 - c) + 0.05)) * 0.904),
}


@pytest.mark.parametrize("name", DENSITIES)
def test_a_number_density_is_that_of_plain_python(name: str) -> None:
    text, law = DENSITIES[name]
    found = density_block(text)(ALTITUDES, GIVEN)
    wanted = np.array([law(h) for h in ALTITUDES])
    # the ozone crosses zero slope and value nowhere: a relative error is meant
    np.testing.assert_allclose(found, wanted, rtol=1e-15, atol=0)


@pytest.mark.parametrize("name", GREY_PHASES)
def test_a_grey_phase_function_is_that_of_plain_python(name: str) -> None:
    text, law = GREY_PHASES[name]
    found = phase_block(text)(COSINES, GIVEN)
    wanted = np.array([law(c) for c in COSINES])
    assert found.shape == (4, COSINES.size)
    np.testing.assert_allclose(found, np.tile(wanted, (4, 1)), rtol=1e-15, atol=0)


def test_a_phase_function_with_colours_is_that_of_plain_python() -> None:
    found = phase_block(COLOURED)(COSINES, GIVEN)
    for row, wavelength in enumerate(WAVELENGTHS):
        g = 0.6 + 0.2 * math.exp(-0.00002 * ((wavelength - 300) * (wavelength - 300)))
        wanted = [(1 - g * g) / (4 * math.pi * math.pow(1 + g * g - 2 * g * c, 1.5)) for c in COSINES]
        np.testing.assert_allclose(found[row], wanted, rtol=1e-15, atol=0)


def _one_by_one(block: Block, places: np.ndarray) -> np.ndarray:
    return np.concatenate([block(places[k : k + 1], GIVEN) for k in range(places.size)], axis=-1)


@pytest.mark.parametrize("text", [OZONE, AEROSOL])
def test_values_do_not_depend_on_their_neighbours(text: str) -> None:
    block = density_block(text)
    long = np.linspace(0.0, 120e3, 9001)
    assert np.array_equal(block(long, GIVEN)[::50], _one_by_one(block, long[::50]))


def test_no_altitudes_give_no_values() -> None:
    assert density_block(OZONE)(np.empty(0), GIVEN).shape == (0,)
    assert phase_block(RAYLEIGH)(np.empty(0), GIVEN).shape == (4, 0)
