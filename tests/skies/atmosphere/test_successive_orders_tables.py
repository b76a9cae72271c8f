"""Successive orders of scattering against the plane-parallel and the spherical reference tables."""

import numpy as np
import pytest

from aomc_sky.skies.atmosphere.scattering_orders.diffuse import summed_orders
from tests.skies.atmosphere.reference_tables import column, grouped, rows
from tests.support import atmospheres
from tests.support.plane_layers import Layers, by_order, later_orders, solve_layers

AZIMUTHS = (0, 30, 60, 90, 120, 150, 180)


def cases(name, *keys):
    return sorted(grouped(name, *keys))


def of(name, **wanted):
    return [row for row in rows(name) if all(row[key] == value for key, value in wanted.items())]


def most(keys, kept):
    """The first, the last and some between by default; all of them where slow tests run."""
    chosen = set(keys[:: max(len(keys) // kept, 1)]) | set(keys[-1:])
    return [pytest.param(*key, marks=() if key in chosen else pytest.mark.slow) for key in keys]


def rayleigh(cosine):
    return atmospheres.rayleigh_phase(cosine, 0)


def rayleigh_sky(tau, albedo, mu0, mu, n_listed=1):
    layers = Layers(optical_depth=np.array([float(tau)]), scattering=np.ones((1, 1)), phases=(rayleigh,))
    return solve_layers(layers, float(albedo), np.arccos(float(mu0)), np.arccos(mu), n_listed=n_listed)


@pytest.mark.parametrize(("tau", "albedo", "mu0"), most(cases("pp_rayleigh_radiance.csv", "tau", "albedo", "mu0"), 5))
def test_rayleigh_radiance_and_flux(tau, albedo, mu0):
    table = of("pp_rayleigh_radiance.csv", tau=tau, albedo=albedo, mu0=mu0)
    sky = rayleigh_sky(tau, albedo, mu0, column(table, "mu"), n_listed=6)
    expected = np.stack([column(table, f"L_phi{azimuth}") for azimuth in AZIMUTHS], axis=1)
    np.testing.assert_allclose(by_order(sky, np.deg2rad(AZIMUTHS)).sum(axis=1)[0], expected, rtol=3e-5)
    (flux,) = of("pp_rayleigh_flux.csv", tau=tau, albedo=albedo, mu0=mu0)
    orders = [float(flux[f"E_diffuse_order{n}"]) for n in range(1, 7)]
    np.testing.assert_allclose(sky.irradiance_by_order[0, :6], orders, rtol=3e-5)
    np.testing.assert_allclose(sky.irradiance_by_order.sum(axis=1)[0], float(flux["E_diffuse"]), rtol=2e-5)
    np.testing.assert_allclose(sky.direct_irradiance[0], float(flux["E_direct"]), rtol=1e-8)


@pytest.mark.parametrize(("tau", "albedo", "mu0"), most(cases("pp_rayleigh_orders.csv", "tau", "albedo", "mu0"), 3))
def test_rayleigh_orders(tau, albedo, mu0):
    table = of("pp_rayleigh_orders.csv", tau=tau, albedo=albedo, mu0=mu0)
    mu, azimuth = np.unique(column(table, "mu")), np.unique(column(table, "phi_deg"))
    found = by_order(rayleigh_sky(tau, albedo, mu0, mu, n_listed=6), np.deg2rad(azimuth))[0]
    compare_orders(table, mu, azimuth, found, n_orders=6, tolerance=4e-5)


def compare_orders(table, mu, azimuth, found, *, n_orders, tolerance):
    at = np.searchsorted(mu, column(table, "mu")), np.searchsorted(azimuth, column(table, "phi_deg"))
    for order in range(1, n_orders + 1):
        given = np.array([line[f"L_order{order}"] != "" for line in table])
        expected = column([line for line, there in zip(table, given, strict=True) if there], f"L_order{order}")
        seen = found[order - 1][at][given]
        np.testing.assert_allclose(seen, expected, rtol=tolerance, err_msg=f"order {order}")


def layers_of(case):
    table = of("pp_layers_cases.csv", case=case)
    molecules, particles, absorber = (column(table, key) for key in ("tau_rayleigh", "tau_hg", "tau_absorber"))
    depth = molecules + particles + absorber
    phase = atmospheres.henyey_greenstein_phase(column(table, "g").max())
    return Layers(
        optical_depth=depth,
        scattering=np.stack([molecules / depth, particles * column(table, "omega_hg") / depth]),
        phases=(rayleigh, lambda cosine: phase(cosine, 0)),
    )


@pytest.mark.parametrize(("case", "albedo", "mu0"), most(cases("pp_layers_radiance.csv", "case", "albedo", "mu0"), 4))
def test_layers(case, albedo, mu0):
    """Peaked and absorbing layers, total and order by order; the table claims 1e-4 itself for L3 at mu0 = 0.2."""
    table = of("pp_layers_radiance.csv", case=case, albedo=albedo, mu0=mu0)
    mu, azimuth = np.unique(column(table, "mu")), np.unique(column(table, "phi_deg"))
    sky = solve_layers(layers_of(case), float(albedo), np.arccos(float(mu0)), np.arccos(mu), n_listed=4)
    found = by_order(sky, np.deg2rad(azimuth))[0]
    at = np.searchsorted(mu, column(table, "mu")), np.searchsorted(azimuth, column(table, "phi_deg"))
    np.testing.assert_allclose(found.sum(axis=0)[at], column(table, "L_all"), rtol=1e-4)
    compare_orders(table, mu, azimuth, found, n_orders=4, tolerance=2e-4)
    (flux,) = of("pp_layers_flux.csv", case=case, albedo=albedo, mu0=mu0)
    np.testing.assert_allclose(sky.irradiance_by_order.sum(axis=1)[0], float(flux["E_diffuse"]), rtol=2e-5)


SPHERICAL = cases("spherical_radiance.csv", "case", "wavelength_nm", "albedo", "sza_deg")


CALCMYSKY = {"calcmysky_rayleigh.csv": atmospheres.molecules_only, "calcmysky_sample.csv": atmospheres.sample}


def tool_cases():
    """Tables and their suns above 10 degrees."""
    found = [(name, *key) for name in CALCMYSKY for key in cases(name, "wavelength_nm", "albedo", "mu0")]
    return [key for key in found if float(key[3]) > 0.17]


@pytest.mark.parametrize(("name", "wavelength", "albedo", "mu0"), most(tool_cases(), 4))
def test_four_orders_of_the_tool(name, wavelength, albedo, mu0):
    """The tool's own order 1 and our next three; its README counts on 1 %, which it needs itself at the horizon."""
    table = of(name, wavelength_nm=wavelength, albedo=albedo, mu0=mu0)
    medium = CALCMYSKY[name]([float(wavelength)], float(albedo))
    sun, views = float(mu0), np.unique(column(table, "mu_view"))
    modes, *_ = summed_orders(medium, np.arccos(sun), np.arccos(views), 4, n_listed=1)
    view, row = column(table, "mu_view"), np.searchsorted(views, column(table, "mu_view"))
    sines = np.sqrt((1.0 - view**2) * (1.0 - sun**2))
    cosine = np.divide(column(table, "cos_view_sun") - view * sun, sines, out=np.ones_like(sines), where=sines > 1e-9)
    later = later_orders(modes, np.arccos(np.clip(cosine, -1.0, 1.0)))[0][row, np.arange(view.size)]
    expected = sum(column(table, f"L_order{n}") for n in (1, 2, 3, 4))
    wrong = (column(table, "L_order1") + later) / expected - 1.0
    assert np.abs(wrong).max() < 0.011
    assert np.abs(wrong[view > 0.1]).max() < 0.008
    assert abs(wrong.mean()) < 0.005
