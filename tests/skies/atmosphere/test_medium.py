"""The air: densities and phase functions from code blocks, jumps and bends, cross sections of molecules."""

import math

import mpmath
import numpy as np
import pytest

from aomc_sky import UsageError
from aomc_sky.atmosphere import rayleigh_cross_section
from aomc_sky.errors import InputFileError
from aomc_sky.skies.atmosphere.medium import Constituent, NumberDensity, _thin_layers, read_phase_block, sphere_integral
from aomc_sky.skies.atmosphere.optical_depth import vertical_optical_depth
from tests.skies.atmosphere.language.test_values import AEROSOL, COLOURED, CORNETTE, MOLECULES, OZONE, PEAKED, RAYLEIGH
from tests.support import atmospheres
from tests.support.atmospheres import OZONE_KINKS_M, PEAK_NORM
from tests.support.blocks import GIVEN, density_block, phase_block

TOP_M = 120e3


def density(text, top_m=TOP_M):
    return NumberDensity(block=density_block(text), given=GIVEN, top_m=top_m)


def test_columns_are_those_of_the_integral():
    ozone = density(OZONE)
    assert ozone.kinks().tolist() == OZONE_KINKS_M.tolist()
    altitude = np.concatenate([np.linspace(0, TOP_M, 1001), OZONE_KINKS_M, np.nextafter(OZONE_KINKS_M, 0)])
    np.testing.assert_allclose(ozone(altitude), atmospheres.ozone_profile(altitude), rtol=3e-15, atol=0)
    assert column("return exp(-altitude/8000.);") == pytest.approx(-8000 * math.expm1(-15), rel=1e-12)
    assert column("return exp(-altitude);") == pytest.approx(1.0, rel=1e-12)
    assert column("return exp(-altitude/5.);", 1e6) == pytest.approx(5.0, rel=1e-11)
    assert column("return 3.;") == pytest.approx(3 * TOP_M, rel=1e-14)
    assert column("return altitude < 7777. ? 2. : 0.;") == pytest.approx(2 * 7777.0, rel=1e-12)
    assert column("return abs(altitude - 90.0123*km) < 2. ? 1. : 0.;") == pytest.approx(4.0, rel=1e-9)
    assert column("return 0.;") == 0.0
    assert column(OZONE) == pytest.approx(370 * 2.687e20 * ozone_integral(), rel=1e-12)


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
        ("return mod(altitude, 50*km);", [50e3, 100e3]),
        ("return min(altitude, 5*km) + min(altitude, 5*km);", [5e3]),
        ("float s=0.; if(altitude > 1*km) s += 1.; if(altitude > 4*km) s += 1.; return s;", [1e3, 4e3]),
        ("bool low = altitude < 4*km; return low ? 1. : 2.;", [4e3]),
        ("return float(altitude < 4*km);", [4e3]),
        ("return abs(sign(altitude - 6*km)) * 2.;", [6e3]),
        ("return altitude >= 0. ? 1. : 2.;", []),
        ("return altitude > 0. ? 1. : 2.;", []),
        ("return altitude < 120*km ? 1. : 2.;", []),
    ],
)
def test_kinks(text, kinks):
    found = density(text).kinks()
    assert found.size == len(kinks)
    np.testing.assert_allclose(found, kinks, rtol=0, atol=1e-6)


def layer(width_m):
    return f"return 1e-9*exp(-altitude/8e3) + exp(-0.5*sqr((altitude - 83.217*km)/{width_m!r}));"


@pytest.mark.parametrize("width_m", [8.0, 30.0, 200.0])
def test_no_quadrature_steps_over_a_thin_smooth_layer(width_m):
    low, peak, high = density(layer(width_m)).kinks()
    half = math.sqrt(2 * math.log(2)) * width_m
    spacing = TOP_M / 16384
    assert abs(peak - 83217) <= spacing
    assert 0 <= (83217 - half) - low <= spacing
    assert 0 <= high - (83217 + half) <= spacing
    beside_the_gas = column(layer(width_m)) - 1e-9 * 8e3 * -math.expm1(-15)
    assert beside_the_gas == pytest.approx(math.sqrt(2 * math.pi) * width_m, rel=1e-10)


def test_of_many_thin_layers_the_largest_are_kept():
    value = np.zeros(521)
    value[2::4] = 1.0 + np.random.default_rng(1).permutation(130)
    layers = _thin_layers(value)
    assert sorted(value[peak] for _, peak, _ in layers) == list(range(31, 131))
    assert all((before, after) == (peak - 1, peak + 1) for before, peak, after in layers)


def column(text, top_m=TOP_M):
    one = density(text, top_m)
    alone = {"scattering_m2": np.zeros(1), "absorption_m2": np.ones(1)}
    gas = Constituent(name="gas", number_density=one, kink_altitude_m=one.kinks(), **alone)
    return float(vertical_optical_depth(atmospheres.medium_of([gas], 550.0, top_m=top_m))[0, 0])


def ozone_integral():
    """Of the four pieces, in closed form: kilometres of their formulas to metres."""
    lines = [
        (0.0, 8.0, 7.2402403521159135e-6, -1.206527437798165e-7),
        (8.0, 21.5, -2.0590185333577628e-5, 3.3581504669318765e-6),
        (21.5, 39.0, 1.0542813563268143e-4, -2.50316678731273e-6),
    ]
    total = sum(a * (high - low) + b * (high * high - low * low) / 2 for low, high, a, b in lines)
    k = 0.2208669270720561
    return 1000.0 * (total + 0.04298160111157969 * (math.exp(-k * 39) - math.exp(-k * 120)) / k)


def test_altitudes_between_the_samples_and_beyond_the_top():
    # no branch leads to this hole of a nanometre
    hidden = density("return altitude*altitude - 1.0e4*altitude + 2.5e7 - 1e-4 > 0. ? 1. : 1. - 1./0.;")
    with pytest.raises(InputFileError, match="altitude 5000 m"):
        hidden(np.array([4000.0, 5000.0]))
    root = density("return sqrt(altitude) + sqrt(120*km - altitude);")
    ends = root(np.array([-1e-9, 0.0, TOP_M, TOP_M + 1e-9]))
    assert ends.tolist() == [math.sqrt(TOP_M)] * 4


ROWS = ((0, 0), (0, 3))


def hg(g):
    return f"const float g = {g!r}; return vec4((1-g*g)/(4*PI*pow(1+g*g-2*g*dotViewSun, 1.5)));"


def norm_of(text):
    return sphere_integral(phase_block(text), GIVEN)[0]


def read(text):
    return read_phase_block(phase_block(text), [GIVEN], ROWS)


def test_the_aerosol_of_the_reference_has_its_integral():
    with mpmath.workdps(30):
        g = mpmath.mpf("0.76")
        k = 3 / (8 * mpmath.pi) * (1 - g * g) / (2 + g * g)
        law = lambda c: k * (1 + c * c) / (1 + g * g - 2 * g * c) ** 1.5 + 1 / (600 * (1 - c) + mpmath.mpf("0.05"))  # noqa: E731
        edges = [-1, 0, 0.9, 0.99, 0.999, 0.9999, 0.99999, 1]
        exact = float(2 * mpmath.pi * mpmath.mpf("0.904") * mpmath.quad(law, edges))
    found = norm_of(PEAKED)
    np.testing.assert_allclose(found, exact, rtol=1e-12)
    np.testing.assert_allclose(found, PEAK_NORM, rtol=1e-8)
    # the planted defect: 64 Gauss nodes in mu miss a hundredth of the reference aerosol
    mu, weight = np.polynomial.legendre.leggauss(64)
    assert abs(2 * np.pi * phase_block(PEAKED)(mu, GIVEN)[0] @ weight - PEAK_NORM) > 5e-3


@pytest.mark.parametrize("text", [RAYLEIGH, CORNETTE, COLOURED])
def test_laws_of_integral_one(text):
    np.testing.assert_allclose(norm_of(text), 1.0, rtol=1e-13)


@pytest.mark.parametrize(
    ("g", "error"), [(0.0, 1e-14), (0.9, 1e-13), (0.99, 1e-12), (0.999, 1e-9), (0.9999, 1e-7), (-0.9, 1e-13)]
)
def test_sharp_peaks_are_resolved(g, error):
    # the error is that of mu itself, 1e-16 over the width of the peak
    np.testing.assert_allclose(norm_of(hg(g)), 1.0, rtol=error)


def test_each_wavelength_has_its_own_norm():
    text = "return vec4(dotViewSun > 0.3 ? 1. : 0., abs(dotViewSun - 0.1), dotViewSun < -0.999 ? 1. : 0., 1.);"
    wanted = 2 * np.pi * np.array([0.7, (1.1**2 + 0.9**2) / 2, 0.001, 2.0])
    np.testing.assert_allclose(norm_of(text), wanted, rtol=1e-12)
    phase = read("return wavelengths/700*vec4(1 + dotViewSun)/(4*PI);")
    np.testing.assert_allclose(phase.norm, [4 / 7, 1.0], rtol=1e-13)
    mu = np.linspace(-1, 1, 5)
    np.testing.assert_allclose(phase(mu, 0), (1 + mu) / (4 * np.pi), rtol=1e-13)
    mu = np.cos(np.linspace(0, np.pi, 91))
    np.testing.assert_allclose(read(RAYLEIGH)(mu, 1), atmospheres.rayleigh_phase(mu, 0), rtol=1e-14)
    np.testing.assert_allclose(read(PEAKED)(mu, 1), atmospheres.sample_aerosol_phase(mu, 0) / PEAK_NORM, rtol=1e-8)
    phase = read("return vec4(2 + sqrt(1 - sqr(dotViewSun)));")
    assert phase(np.array([1.0 + 4e-16, -1.0 - 4e-16]), 0).tolist() == phase(np.array([1.0, -1.0]), 0).tolist()
    assert phase(np.zeros((2, 3)), 0).shape == (2, 3)


def exact(n, temperature, pressure, wavelength_nm, king):
    with mpmath.workdps(50):
        n, t, p, w, f = (mpmath.mpf(x) for x in (n, temperature, pressure, wavelength_nm, king))
        h = (n * n - 1) ** 2 / (w * mpmath.mpf(10) ** -9) ** 4 * (mpmath.mpf("1.380649e-23") * t / p) ** 2
        return 8 * mpmath.pi**3 / 3 * h * f


@pytest.mark.parametrize(
    "case",
    [
        (1.000274, 288.15, 101325.0, 1000.0, 1.0),
        (1.000447, 273.15, 101325.0, 532.0, 1.149),
        (1.0 + 2.0**-52, 215.0, 610.0, 1000.0, 1.0),
        (1.0000000001, 3.0, 1e-3, 121.6, 1.05),
        (2.0, 300.0, 1e9, 1e5, 2.0),
    ],
)
def test_it_is_the_formula_to_the_last_digits(case):
    found = rayleigh_cross_section(*case[:3], wavelength_nm=case[3], king_factor=case[4])
    wanted = exact(*case)
    assert abs(found - wanted) <= 2e-15 * wanted


def test_arguments_broadcast_and_the_king_factor_multiplies():
    wavelength = np.array([400.0, 500.0, 1000.0])
    found = rayleigh_cross_section(1.000274, 288.15, 101325.0, wavelength_nm=wavelength, king_factor=[[1.0], [1.05]])
    assert found.shape == (2, 3)
    np.testing.assert_allclose(found[1] / found[0], 1.05, rtol=1e-15)
    np.testing.assert_allclose(found[0] / found[0, 2], (1000.0 / wavelength) ** 4, rtol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "king"),
    [((0.9, 288, 1e5), 1), ((1.0003, 0, 1e5), 1), ((1.0003, 288, -1), 1), ((np.nan, 288, 1e5), 1), ((1.1, 1, 1), 0.5)],
)
def test_numbers_outside_their_ranges_are_refused(arguments, king):
    with pytest.raises(UsageError, match="must lie between"):
        rayleigh_cross_section(*arguments, king_factor=king)
