"""Optical depths against 40-digit quadrature, closed forms and tables, from 1 m to 1 Mm; the beam that is left."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from aomc_sky.skies.atmosphere.backward import SHELL_TOLERANCE, uniform_shells
from aomc_sky.skies.atmosphere.lights import ground_beam
from aomc_sky.skies.atmosphere.optical_depth import N_GAUSS, N_NODES, optical_depth_to_top, vertical_optical_depth
from tests.reference.spherical import exponential_column
from tests.skies.atmosphere.reference_tables import MEDIA, rows
from tests.support import atmospheres
from tests.support.atmospheres import EARTH_RADIUS_M, empty, exponential, full, medium_of

N = N_NODES
UNIFORM_ERROR = (2 * N * (N + 1) + 2 * N + N_GAUSS + 20) * 2.0**-53
"""Most by which a column of constant density is off, in units of u = 2^-53 of itself: each of N terms of the Chebyshev
series is a sum over N values, 2 (N + 1) u; Horner's rule 2 N u; the sum over Gauss nodes N_GAUSS u; geometry 20 u."""
# top, radius, scale height
SIZES = [(1.0, 6.371e6, 0.1), (120e3, 6.371e6, 8e3), (1e6, 6.371e6, 6e4), (1e6, 1e5, 3e5)]


WAYS = [(*size, *way) for size in SIZES for way in ((0.0, 0.0), (85.0, 0.3), (90 - 1e-9, 0.0), (90.0, 0.3))]
WAYS += [(*SIZES[1], 94.5, 20 / 120), (*SIZES[1], 96.0, 0.5)]  # rays that sink and rise


@pytest.mark.parametrize(("top_m", "radius_m", "scale_m", "zenith_deg", "start"), WAYS)
def test_exponential_atmospheres(top_m, radius_m, scale_m, zenith_deg, start):
    medium = exponential(2.0, scale_height_m=scale_m, earth_radius_m=radius_m, top_m=top_m)
    found = optical_depth_to_top(medium, start * top_m, np.radians(zenith_deg))[0]
    column = exponential_column(radius_m, top_m, scale_m, start * top_m, mpmath.mpf(float(np.radians(zenith_deg))))
    expected = 2.0 * column / (scale_m * (1 - mpmath.exp(-mpmath.mpf(top_m) / scale_m)))
    assert abs(found / float(expected) - 1) < 1e-10


@pytest.mark.parametrize("top_m", [1.0, 120e3, 1e6])
def test_a_uniform_atmosphere_measures_the_way(top_m):
    medium = atmospheres.uniform(3.0, top_m=top_m)
    with mpmath.workdps(50):
        r, end = mpmath.mpf(EARTH_RADIUS_M), mpmath.mpf(EARTH_RADIUS_M) + top_m
        for zenith in np.radians([0.0, 60.0, 89.0, 89.9999, 90.0]):
            along = r * mpmath.cos(mpmath.mpf(float(zenith)))
            way = -along + mpmath.sqrt(along**2 + end**2 - r**2)
            assert abs(optical_depth_to_top(medium, 0.0, zenith)[0] / float(3 * way / top_m) - 1) < UNIFORM_ERROR


def test_wavelengths_no_constituent_and_the_ground():
    medium = exponential(1.0)
    dip = np.arccos(EARTH_RADIUS_M / (EARTH_RADIUS_M + 1000.0))
    zenith = np.pi / 2 + dip * np.array([0.0, 0.999, 1.001, 20.0])
    assert np.isfinite(optical_depth_to_top(medium, 1000.0, zenith)[0]).tolist() == [True, True, False, False]
    assert np.isinf(optical_depth_to_top(medium, 0.0, np.radians(90.001))[0])
    two = optical_depth_to_top(full([450.0, 550.0]), np.array([0.0, 1e4, 120e3]), 0.7)
    assert two.shape == (2, 3)
    one = optical_depth_to_top(full(550.0), np.array([0.0, 1e4, 120e3]), 0.7)
    np.testing.assert_allclose(two[1], one[0], rtol=1e-10, atol=1e-16)
    assert np.all(two[:, 2] == 0)
    assert optical_depth_to_top(empty(), 0.0, 1.0)[0] == 0
    assert np.isinf(optical_depth_to_top(empty(), 0.0, 2.0)[0])
    assert vertical_optical_depth(full([450.0, 550.0])).shape == (2, 3)
    assert vertical_optical_depth(full(450.0)).sum() == pytest.approx(0.249152407, rel=1e-8)


def with_density(density, kinks_m):
    part = replace(exponential(1.0).constituents[0], number_density=density, kink_altitude_m=np.array(kinks_m))
    return medium_of([part], 550.0)


def test_profiles_of_thin_layers_jumps_and_many_scales():
    column = optical_depth_to_top(with_density(lambda h: np.exp(-(((h - 85e3) / 200.0) ** 2)), []), 0.0, 0.0)[0]
    assert column == pytest.approx(200.0 * np.sqrt(np.pi), rel=1e-10)
    declared = optical_depth_to_top(with_density(lambda h: (h < 12345.6).astype(float), [12345.6]), 0.0, 1.5)[0]
    hidden = optical_depth_to_top(with_density(lambda h: (h < 12345.6).astype(float), []), 0.0, 1.5)[0]
    assert hidden == pytest.approx(declared, rel=1e-5)
    assert declared != hidden
    (part,) = exponential(1.0).constituents
    thin = replace(part, name="thin", number_density=atmospheres.exponential_profile(1 / 30.0, 30.0))
    np.testing.assert_allclose(vertical_optical_depth(medium_of([part, thin], 550.0))[0], [1.0, 1.0], rtol=1e-10)


def test_shells_keep_columns_and_kinks():
    medium = atmospheres.mol_ozone([600.0])
    edge, density = uniform_shells(medium)
    assert edge[0] == 0
    assert edge[-1] == medium.top_m
    assert np.all(np.diff(edge) > 0)
    assert {8e3, 21.5e3, 39e3} <= set(edge)
    assert np.diff(edge)[:50] == pytest.approx(50.0)
    by_shell = (density * np.diff(edge)[:, None]).sum(axis=0)
    sigma = np.array([part.scattering_m2 + part.absorption_m2 for part in medium.constituents])[:, 0]
    np.testing.assert_allclose(by_shell * sigma, vertical_optical_depth(medium)[0], rtol=1e-12)


@pytest.mark.parametrize("top_m", [1.0, 120e3, 1e6])
def test_shells_are_thin_beside_the_scale_height(top_m):
    scale = top_m / 100
    edge, _ = uniform_shells(exponential(1.0, top_m=top_m, scale_height_m=scale))
    thickness = np.diff(edge)[edge[1:] < 10 * scale]
    assert np.max((thickness / scale) ** 2 / 24) < 1.01 * SHELL_TOLERANCE


def test_reference_slant_depths_and_beams():
    table = rows("spherical_direct.csv")
    for row in table:
        ozone = () if row["case"] == "rayleigh" else (0.0, float(row["ozone_cross_section_m2"]))
        medium = MEDIA[row["case"]](float(row["wavelength_nm"]), *ozone)
        depth = optical_depth_to_top(medium, 0.0, np.radians(float(row["sza_deg"])))[0]
        assert abs(depth / float(row["tau_slant"]) - 1) < 1e-9
        assert abs(vertical_optical_depth(medium).sum() / float(row["tau_vertical"]) - 1) < 1e-9
    assert len(table) == 40
    table = rows("spherical_flux.csv")
    for row in table:
        medium = MEDIA[row["case"]](float(row["wavelength_nm"]))
        found = ground_beam(medium, np.radians(float(row["sza_deg"]))).irradiance[0]
        assert found == pytest.approx(float(row["E_direct"]), rel=1e-8, abs=1e-16)
    assert len(table) == 45


RADIUS_RAD = np.radians(0.2666)


def test_the_beam_at_the_ground():
    medium = replace(full([450.0, 550.0]), toa_irradiance=np.array([2.0, 3.0]), sun_angular_radius_rad=RADIUS_RAD)
    for sun_deg in (0.0, 60.0, 89.0, 89.99):
        sun = np.radians(sun_deg)
        beam = ground_beam(medium, sun)
        np.testing.assert_allclose(beam.optical_depth, optical_depth_to_top(medium, 0.0, sun), rtol=0)
        expected = np.cos(sun) * np.array([2.0, 3.0]) * np.exp(-beam.optical_depth)
        np.testing.assert_allclose(beam.irradiance, expected, rtol=1e-15)
    found = ground_beam(exponential(0.1), np.radians([89.0, 89.999, 90.0, 90.001, 91.0, 180.0])).irradiance[0]
    assert np.all(np.diff(found[:3]) < 0)
    assert found[2:].tolist() == [0.0] * 4
    assert np.isfinite(ground_beam(exponential(0.1), np.pi / 2).optical_depth[0])
    assert np.isinf(ground_beam(exponential(0.1), np.radians(90.001)).optical_depth[0])
