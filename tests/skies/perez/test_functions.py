"""Functions of the Perez sky against 40-digit arithmetic, the paper's text and what the model cannot do."""

import mpmath as mp
import numpy as np
import pytest

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.coefficients import exp, power
from aomc_sky.skies.perez.irradiances import closed_irradiances
from aomc_sky.skies.perez.table import EPSILON_EDGES, TABLE_1, TEN_THOUSANDTHS
from tests.reference import perez_exact

EPSILONS = (1.0, 1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 8.0)  # one in each bin


def test_table_1_and_its_bins():
    assert TABLE_1.shape == (8, 5, 4)
    assert TABLE_1.sum() == pytest.approx(68.5262, abs=1e-12)
    assert np.abs(TABLE_1).sum() == pytest.approx(702.5774, abs=1e-12)
    typed = np.array([[float(v) for v in row] for row in perez_exact.ROWS]).reshape(8, 5, 4)
    np.testing.assert_array_equal(TABLE_1, typed)
    assert np.max(np.abs(TEN_THOUSANDTHS / 1e4 - TABLE_1)) < 1e-15
    edges = np.array(EPSILON_EDGES)
    np.testing.assert_array_equal(perez.epsilon_bin(edges), np.arange(8))
    np.testing.assert_array_equal(perez.epsilon_bin(np.nextafter(edges[1:], 0)), np.arange(7))
    np.testing.assert_array_equal(perez.epsilon_bin([0.5, np.inf]), [0, 7])
    with pytest.raises(SceneError, match="not a number"):
        perez.epsilon_bin(np.nan)


@pytest.mark.parametrize("row", range(8))
@pytest.mark.parametrize(
    ("delta", "zenith"), [("0.02", "0"), ("0.3", "45"), ("1e-9", "45"), ("0.6", "89.99"), ("1", "75")]
)
def test_coefficients_to_the_last_bits(row, delta, zenith):
    exact = perez_exact.coefficients(row, delta, zenith)
    found = perez.coefficients(EPSILONS[row], float(delta), np.deg2rad(float(zenith)), limits="paper")
    terms = np.abs(TABLE_1[row]) @ np.array([1, 1.6, 1, 1.6])
    for k in range(5):
        scale = abs(float(exact[k])) if (row, k) == (0, 2) else max(float(terms[k]), abs(float(exact[k])))
        assert abs(float(mp.mpf(float(found[k])) - exact[k])) <= 1.5e-15 * scale


HARD = [
    (0, "1e-9", "45", "30", "20"),  # c of 3e-11
    (2, "0.02", "0", "89.9", "0"),  # 1e46
    (3, "0.6", "5", "5", "0"),  # negative second factor at the sun
    (1, "0.0945128549556", "45", "0", "0"),  # 1 + a exp(b) of 1e-13
    (5, "0.0466025868303", "45", "0", "0"),
    (7, "0.1", "30", "30", "1e-9"),
    (7, "0.1", "2.5", "2.5", "0"),  # acos of the dot product is NaN
    (7, "0.1", "89", "89", "1e-7"),
    (7, "0.1", "45", "89.9999", "180"),
    (7, "0.5", "88", "70", "180"),  # d > 0
    (7, "0.9", "10", "10", "0"),
    (6, "0.6", "0", "85", "0"),
    (4, "0.05", "85", "89", "12.5"),
]


@pytest.mark.parametrize(("row", "delta", "sun", "xi", "phi"), HARD)
def test_luminance_to_the_last_bits(row, delta, sun, xi, phi):
    exact = perez_exact.coefficients(row, delta, sun)
    value, magnitude = perez_exact.luminance(exact, xi, phi, sun)
    angles = np.deg2rad([float(xi), float(phi), float(sun)])
    found = perez.relative_radiance(*angles, perez.coefficients(EPSILONS[row], float(delta), angles[2], limits="paper"))
    mu = mp.cos(mp.radians(mp.mpf(xi)))
    assert abs(mp.mpf(float(found)) - value) <= 1e-15 * (1 + abs(exact[1]) / mu**2) * magnitude


def test_luminance_at_the_horizon():
    for row, delta, sun, xi in ((3, "0.02", "0", "89.99"), (5, "0.55", "89", "89.99")):
        exact = perez_exact.coefficients(row, delta, sun)
        assert exact[1] > 0
        angles = np.deg2rad([float(xi), 10.0, float(sun)])
        values = perez.coefficients(EPSILONS[row], float(delta), angles[2], limits="paper")
        infinite = float(mp.sign(perez_exact.luminance(exact, xi, "10", sun)[0])) * np.inf
        assert perez.relative_radiance(*angles, values) == infinite
        assert perez.relative_radiance(np.pi / 2, 0.3, angles[2], values) == infinite
    values = np.array([[-0.7, -0.3, 4, -2, 0.2], [-0.7, 0.0, 4, -2, 0.2], [0.0, 0.4, 4, -2, 0.2]])
    second = 1 + 4 * np.exp(-2 * 1.0) + 0.2 * np.cos(1.0) ** 2
    found = perez.relative_radiance(np.pi / 2, 0.0, np.pi / 2 - 1, values)
    np.testing.assert_allclose(found, [second, 0.3 * second, second], rtol=1e-14)
    zero = perez.relative_radiance(np.pi / 2, 0.0, 0.0, [1.0, 1.0, -1.0, 0.0, 0.0])
    assert zero == 0  # 0 times an infinite first factor


def test_clearness_brightness_and_their_limits():
    np.testing.assert_array_equal(perez.sky_clearness([0, 0, 5, -2], [50, 0, 0, 30], 0.5), [1, 1, np.inf, 1])
    z = np.deg2rad(60.0)
    assert perez.sky_clearness(600, 120, z) == pytest.approx(((120 + 600) / 120 + 1.041 * z**3) / (1 + 1.041 * z**3))
    assert perez.sky_clearness(1000, 0.001, np.deg2rad(30)) - 1 == pytest.approx(869994.14122968131139, rel=1e-14)
    assert perez.sky_brightness(100, 0.0, extraterrestrial_normal=1000) == pytest.approx(0.09997119918558381, rel=1e-15)
    assert perez.relative_air_mass(np.pi / 2) == pytest.approx(37.919608377836325302, rel=1e-14)
    assert perez.relative_air_mass(np.pi / 2, formula="kasten-1966") == pytest.approx(36.510324500288756567, rel=1e-14)
    assert closed_irradiances(ghi=500, dni=400, sun_zenith_deg=60.0)[1] == pytest.approx(300)
    assert closed_irradiances(ghi=200.0, dni=400 * (1 + 1e-13), sun_zenith_deg=60.0)[1] == 0
    assert closed_irradiances(ghi=500, dhi=100, sun_zenith_deg=60.0)[0] == pytest.approx(800)
    gap = np.array([0.3, np.nan])
    assert np.isnan(perez.sky_clearness([100, np.nan], 100, 0.5)).tolist() == [False, True]
    values = perez.coefficients(2.0, gap, 0.5)
    assert np.isnan(values).all(axis=1).tolist() == [False, True]
    assert np.isfinite(values[0]).all()
    floor = perez.limited([1.0, 1.0649, 1.065, 2.7999, 2.8, 20.0], 0.05)[1]
    np.testing.assert_array_equal(floor, [0.05, 0.05, 0.2, 0.2, 0.05, 0.05])
    np.testing.assert_array_equal(perez.limited([1.0, 20.0], [0.0, 3.0]), [[1.0, 12.01], [0.01, 0.6]])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: perez.sky_clearness(100, -6, 0.5), "dhi"),
        (lambda: perez.sky_clearness(np.inf, 1, 0.5), "dni"),
        (lambda: perez.sky_clearness(100, 50, 1.6), "above the horizon"),
        (lambda: perez.sky_brightness(100, 0.5, extraterrestrial_normal=0), "positive"),
        (lambda: perez.relative_air_mass(np.deg2rad(94), formula="kasten-1966"), "93.885"),
        (lambda: perez.coefficients(1.0, -0.0005, 0.5), "negative"),
        (lambda: perez.coefficients(1.0, 1e6, 0.5, limits="paper"), "overflows"),
        (lambda: perez.relative_radiance(1.6, 0, 0.5, np.ones(5)), "sky element"),
        (lambda: perez.horizontal_integral([1, 0.1, 1, 1, 1], 0.5), "diverges"),
        (lambda: perez.luminance(1, 0, 0, [-2, 0, 0, 0, 0], zenith_luminance=1.0), "negative overhead"),
        (lambda: perez.luminance(0, 0, 0.5, [1, -1, 1, -1, 0]), "either"),
    ],
)
def test_what_the_model_refuses(call, words):
    with pytest.raises((SceneError, UsageError), match=words):
        call()


@pytest.mark.parametrize(
    ("sun_deg", "values", "integral"),
    [  # mpmath in coordinates centred on the zenith, 25 digits, cut at the sun
        (0.0, (-1.05, -0.3, 30.0, -7.0, 1.5), 2.68431669002532485),
        (85.0, (0.5, -0.6, 2.0, -1.0, 0.1), 5.77680551514440597),
        (89.0, (-1.0, -0.05, 15.0, -6.5, 0.9), 0.409866920220164541),
        (50.0, (-1.0, -0.2, 10.0, -4.0, 0.3), 1.59360421007260642),
    ],
)
def test_integral_against_many_digits(sun_deg, values, integral):
    assert perez.horizontal_integral(values, np.deg2rad(sun_deg)) == pytest.approx(integral, rel=1e-11)


def test_integral_and_luminance_where_they_are_known():
    assert perez.horizontal_integral([0, 0, 0, 0, 0], 0.4) == pytest.approx(np.pi, rel=1e-15)
    assert perez.horizontal_integral([0.5, 0, 1, 0, 0], 1.3) == pytest.approx(3 * np.pi, rel=1e-12)
    # sun overhead, a = 0: 2 pi times the integral of exp(d x) sin x cos x
    d = -3.0
    known = np.pi + 2 * np.pi * 4 * (2 * (1 + np.exp(d * np.pi / 2))) / (2 * (4 + d * d))
    assert perez.horizontal_integral([0, -1, 4, d, 0], 0.0) == pytest.approx(known, rel=1e-12)
    sun, values = 0.7, perez.coefficients(5.0, 0.15, 0.7)
    overhead = perez.luminance(0.0, 0.0, sun, values, diffuse_illuminance=12000.0)
    of_diffuse = perez.luminance(0.9, 1.0, sun, values, diffuse_illuminance=12000.0)
    assert perez.luminance(0.9, 1.0, sun, values, zenith_luminance=overhead) == pytest.approx(of_diffuse, rel=1e-14)
    x, w = np.polynomial.legendre.leggauss(60)
    mu, w = (x + 1) / 2, w / 2
    azimuth = (np.arange(720) + 0.5) * np.pi / 720
    field = perez.luminance(np.arccos(mu)[:, None], azimuth, sun, values, diffuse_illuminance=12000.0)
    assert 2 * np.pi * np.sum(field.mean(axis=1) * mu * w) == pytest.approx(12000, rel=1e-4)


def test_ends_and_pinned_bits_of_elementary_functions():
    np.testing.assert_array_equal(exp(np.array([-1e9, 1e9, 0.0])), [0, np.inf, 1])
    assert np.isnan(exp(np.array([np.nan]))).all()
    np.testing.assert_array_equal(power(np.zeros(2), np.array([12375.0, -16364.0])), [0, np.inf])
    assert np.isnan(power(np.array([np.nan]), np.array([12375.0]))).all()
    found = (*perez.coefficients(1.0, 0.3, 0.75)[2:4], perez.sky_brightness(100.0, 0.75))
    pinned = ["0x1.a2d16b46a6f5cp+0", "-0x1.ed22514734237p-1", "0x1.9adbd806fd980p-4"]
    assert [float(value).hex() for value in found] == pinned
