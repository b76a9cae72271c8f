"""Light scattered once: closed forms of flat layers, slow vectors, convergence, the corners of the sky, twilight."""

import itertools
import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest

from aomc_sky.skies.atmosphere import order_one
from aomc_sky.skies.atmosphere.eclipse import solve_order_one
from aomc_sky.skies.atmosphere.kernels import order_one as kernels
from aomc_sky.skies.atmosphere.medium import scatterers
from aomc_sky.skies.atmosphere.optical_depth import density_profile
from aomc_sky.skies.atmosphere.order_one import ray_panels, scattered_once, scattering_cosine
from aomc_sky.skies.atmosphere.sky.solved import ExactOrderOne
from tests.reference.spherical import SlowRays
from tests.skies.atmosphere.reference_tables import MEDIA, column, grouped
from tests.support import atmospheres
from tests.support.atmospheres import Layer, exponential, full, molecules_only, rayleigh_phase

CUTS_M = (500.0, 1e3, 2e3, 4e3, 8e3, 15e3, 21.5e3, 30e3, 39e3, 60e3, 90e3)
HALF_PI = np.pi / 2


def one_layer(tau, mu0, mu):
    """Order 1 below a flat isotropic layer over its phase function: mu0/(mu0 - mu) (e^(-tau/mu0) - e^(-tau/mu))."""

    def exact(x):
        sun, eye = 1 / mpmath.mpf(mu0), 1 / mpmath.mpf(x)
        if sun == eye:
            return tau * eye * mpmath.exp(-tau * eye)
        return eye / (sun - eye) * -(mpmath.exp(-tau * sun) - mpmath.exp(-tau * eye))

    with mpmath.workdps(30):
        return np.array([float(exact(float(x))) for x in mu])


@pytest.mark.parametrize("tau", [1e-6, 0.05, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("sun_deg", [0.0, 60.0, 85.0, 88.0])
def test_flat_layer(tau, sun_deg):
    medium = atmospheres.plane_parallel([Layer(tau_rayleigh=tau)])
    sun = np.radians(sun_deg)
    zenith = np.radians([0.0, 0.01, 30.0, 60.0, 85.0, 88.0])
    azimuth = np.array([0.0, 1.0, 2.0, 3.0, np.pi, 0.0])
    found = solve_order_one(medium, sun, zenith, azimuth)[0]
    phase = rayleigh_phase(scattering_cosine(sun, zenith, azimuth), 0)
    expected = phase * one_layer(tau, float(np.cos(sun)), np.cos(zenith))
    seen = expected > 1e-250
    np.testing.assert_allclose(found[seen], expected[seen], rtol=1e-6)


def compare(medium, cases_deg, rtol, cuts_m=CUTS_M):
    slow = SlowRays(medium, cuts_m)
    for sun, zenith, azimuth in np.radians(cases_deg).tolist():
        found = solve_order_one(medium, sun, [zenith], [azimuth])[0, 0]
        assert found == pytest.approx(slow.radiance(sun, zenith, azimuth), rel=rtol)


def test_slow_vectors():
    compare(molecules_only(550.0), [(92.0, 85.0, 180.0), (90.01, 0.0, 0.0)], 1e-7)
    compare(atmospheres.mol_ozone(600.0), [(90.0, 90.0, 0.0), (92.0, 85.0, 180.0)], 1e-6)
    # Densities that jump; under a level sun only the upper metre of the cloud is lit.
    cloud = replace(
        exponential(0.5, phase=atmospheres.henyey_greenstein_phase(0.85)).constituents[0],
        name="cloud",
        number_density=lambda h: ((h >= 2e3) & (h < 3e3)) / 1e3,
        kink_altitude_m=np.array([2e3, 3e3]),
    )
    medium = atmospheres.medium_of([*molecules_only(550.0).constituents, cloud], 550.0)
    compare(medium, [(85.0, 89.0, 180.0), (90.0, 60.0, 0.0)], 3e-7, (1e3, 2e3, 2.9e3, 2.99e3, 2.999e3, 3e3, 4e3, 30e3))


def with_nodes(n, solve, *arguments):
    """Light scattered once with so many Gauss nodes on a panel."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(order_one, "N_NODES", n)
        return solve(*arguments)


def test_the_horizon_and_sunset_make_no_jump():
    medium = full([450.0, 550.0])
    zenith = np.array([HALF_PI, np.radians(90 - 1e-9), np.radians(90 - 1e-5), 0.0, 1.0])
    at = solve_order_one(medium, HALF_PI, zenith, np.full(5, 2.0))
    assert np.all(at > 0)
    for sun in (0.5, HALF_PI - 1e-10, HALF_PI + 1e-10):
        level = solve_order_one(medium, sun, zenith, np.full(5, 2.0))
        np.testing.assert_allclose(level[:, 1], level[:, 0], rtol=1e-7)
        np.testing.assert_allclose(level[:, 2], level[:, 0], rtol=1e-4)
        if sun > 1:
            np.testing.assert_allclose(level[:, [0, 3, 4]], at[:, [0, 3, 4]], rtol=1e-7)


def test_into_the_sun():
    for phase in (atmospheres.peaked_phase, atmospheres.henyey_greenstein_phase(0.9999)):
        medium = exponential(0.2, phase=phase)
        for sun_deg in (0.0, 33.3, 89.9):
            sun = np.radians(sun_deg)
            found = solve_order_one(medium, sun, [sun], [0.0])[0, 0]
            flat = solve_order_one(exponential(0.2, phase=atmospheres.isotropic_phase), sun, [sun], [0.0])[0, 0]
            assert found / flat == pytest.approx(4 * np.pi * phase(np.ones(1), 0)[0], rel=1e-12)


def test_no_air_no_scattering_no_light():
    for medium in (atmospheres.empty(), exponential(1.0, omega=0.0)):
        assert scatterers(medium) == []
        assert scattered_once(medium, 0.5, [0.1, 0.2], [0.0, 0.0]).shape == (1, 0, 2)
        assert np.all(solve_order_one(medium, 0.5, [0.1, 0.2], [0.0, 0.0]) == 0)
    assert solve_order_one(exponential(1.0), 0.5, [], []).shape == (1, 0)
    for sun in (np.radians(113.0), np.pi):
        assert np.all(solve_order_one(exponential(1.0), sun, [0.0, HALF_PI], [0.0, 0.0]) == 0)


def test_wavelengths_and_constituents_stand_alone():
    zenith, azimuth = np.radians([10.0, 80.0, 80.0, 45.0]), np.array([0.0, 1.0, -1.0, 3.0])
    both = solve_order_one(full([450.0, 550.0]), 1.3, zenith, azimuth)
    for row, wavelength in enumerate((450.0, 550.0)):
        np.testing.assert_allclose(both[row], solve_order_one(full(wavelength), 1.3, zenith, azimuth)[0], rtol=1e-6)
    assert np.all(both[:, 1] == both[:, 2])  # mirrored on the sun's vertical plane
    parts = scattered_once(full([450.0, 550.0]), 1.3, zenith, azimuth)
    cosine = scattering_cosine(1.3, zenith, azimuth)
    together = parts[:, 0] * rayleigh_phase(cosine, 0) + parts[:, 1] * atmospheres.peaked_phase(cosine, 0)
    np.testing.assert_allclose(both, together, rtol=1e-13)


def test_a_wish_for_more_points_along_a_line():
    medium = full(450.0)
    panels = ray_panels(density_profile(medium), 1.0).size - 1
    zenith, azimuth = np.array([0.3, 1.5]), np.array([0.5, 2.0])

    def found(points, n_nodes=6):
        return with_nodes(n_nodes, scattered_once, replace(medium, least_line_points=points), 1.0, zenith, azimuth)

    np.testing.assert_array_equal(found(6 * panels), found(0))
    np.testing.assert_array_equal(found(6 * panels + 1), found(0, n_nodes=7))
    np.testing.assert_array_equal(found(2**31 - 1), found(0, n_nodes=64))
    assert np.any(found(12 * panels) != found(0))
    np.testing.assert_allclose(found(2**31 - 1), found(0), rtol=1e-6)


SMALLEST_DIGIT = 5e-13  # of the printed radiances


def test_spherical_sun_up():
    n_rows = 0
    groups = grouped("spherical_radiance.csv", "case", "wavelength_nm", "sza_deg")
    for (case, wavelength, sun_deg), rows in groups.items():
        if float(sun_deg) > 90:
            continue
        zenith, azimuth = np.radians(column(rows, "vza_deg")), np.radians(column(rows, "phi_deg"))
        found = solve_order_one(MEDIA[case](float(wavelength)), np.radians(float(sun_deg)), zenith, azimuth)[0]
        np.testing.assert_allclose(found, column(rows, "L_order1"), rtol=1e-5, atol=SMALLEST_DIGIT)
        n_rows += len(rows)
    assert n_rows == 840


@pytest.mark.parametrize(
    ("name", "maker"), [("calcmysky_rayleigh", molecules_only), ("calcmysky_sample", atmospheres.sample)]
)
def test_the_tool(name, maker):
    """Within 0.5 %, or 1e-5 of the brightest where it is dark, but along the horizon with the sun below it.

    There the tool's sun, a disc, still stands in part above the horizon of the air that is seen; ours is a point.
    """
    n_rows = 0
    for (wavelength, mu0), rows in grouped(f"{name}.csv", "wavelength_nm", "mu0").items():
        sun = float(np.arccos(float(mu0)))
        view, cosine = column(rows, "mu_view"), column(rows, "cos_view_sun")
        zenith = np.arccos(np.clip(view, -1, 1))
        across = np.sin(zenith) * np.sin(sun)
        turn = np.divide(cosine - view * np.cos(sun), across, out=np.ones_like(across), where=across > 1e-9)
        found = solve_order_one(maker(float(wavelength)), sun, zenith, np.arccos(np.clip(turn, -1, 1)))[0]
        expected = column(rows, "L_order1")
        keep = (view > 0.1) | (float(mu0) > 0.0)
        np.testing.assert_allclose(found[keep], expected[keep], rtol=5e-3, atol=1e-5 * expected.max())
        n_rows += int(keep.sum())
    assert n_rows > 500


def test_cells_are_the_solver():
    once = ExactOrderOne(medium=full([400.0, 700.0]), sun_zenith_rad=np.radians(92.0))
    zenith = np.radians([[0.0, 35.0], [70.0, 85.0]])
    azimuth = np.radians(np.linspace(0.0, 170.0, 36)).reshape(18, 2)
    ring, column = np.append(np.zeros(18, dtype=int), 1), np.append(np.arange(18), 7)
    found = once.in_cells(zenith, azimuth, ring, column)
    assert found.shape[2:] == (19, 2, 2)
    for cell in (0, 11, 18):
        theta, phi = np.meshgrid(zenith[ring[cell]], azimuth[column[cell]], indexing="ij")
        true = once.at(theta.ravel(), phi.ravel()).reshape(found[:, :, cell].shape)
        np.testing.assert_array_equal(found[:, :, cell], true)


@pytest.mark.slow
def test_slow_vectors_all_over_the_sky():
    suns, zeniths = (60.0, 88.0, 90.34, 96.0), (0.0, 85.0, 89.7, 90.0)
    cases = [(s, z, a) for s in suns for z in zeniths for a in (0.0, 90.0, 180.0)]
    lit = [c for c in cases if solve_order_one(full(550.0), np.radians(c[0]), *np.radians([c[1:]]).T)[0, 0] > 1e-30]
    compare(molecules_only(400.0), lit, 2e-6)
    compare(full(550.0), lit, 2e-6)


def plain(kernel):
    """The Python of a kernel that only kernels may call."""
    return getattr(kernel, "py_func", kernel)


def test_a_number_lies_between_the_edges_of_its_panel():
    edges, panel_of = np.array([0.0, 1.0, 3.0, 4.0, 9.0]), plain(kernels.panel_of)
    for x in (0.0, 0.5, 1.0, 2.9, 3.0, 3.5, 4.0, 8.9):
        panel = panel_of(edges, x)
        assert edges[panel] <= x < edges[panel + 1]
    assert (panel_of(edges, 9.0), panel_of(edges, 20.0)) == (3, 3)  # the last panel has what lies beyond it


def test_beyond_the_root_no_ray_of_a_sinking_sun_dips_below_the_altitude():
    """By vectors: from the ground along a ray, and the distance of the sun's ray from the centre of the earth."""
    radius, n_infinite = 6371e3, 0
    for sun_mu, mu, turn, touched in itertools.product(
        (-0.2, -0.05, -0.001), (0.01, 0.4, 0.9), (0.0, 0.7, 1.8, 3.1), (0.0, 2e4)
    ):
        sine, to_sun = math.sqrt(1 - mu**2), np.array([math.sqrt(1 - sun_mu**2), 0.0, sun_mu])
        ray = np.array([sine * math.cos(turn), sine * math.sin(turn), mu])
        root = plain(kernels.root_above)(radius, mu, sun_mu, float(ray @ to_sun), touched)
        altitude = root**2
        way = np.geomspace(1.0, 1e10, 400)
        if root < math.inf:
            way = np.array([math.sqrt((radius * mu) ** 2 + altitude * (altitude + 2 * radius)) - radius * mu])
        place = np.array([0.0, 0.0, radius]) + way[:, None] * ray
        sinks = place @ to_sun < 0.0
        lowest = np.linalg.norm(np.cross(place, to_sun), axis=1) - radius
        if root < math.inf:
            assert sinks.all()
            assert lowest == pytest.approx(touched, abs=0.1)
        else:
            assert (lowest[sinks] < touched).all()
        n_infinite += root == math.inf
    assert 0 < n_infinite < 36
