"""Absolute irradiances of a scene change no photon; exact moments against independent quadrature."""

import numpy as np
import pytest
from mpmath import mp, mpf, quad

import aomc_sky as sky
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.emission.irradiance import Irradiance, cell_moments, mean_moments
from aomc_sky.errors import SceneError

BANDS = [450.0, 550.0]
PARTS = (sky.DirectBeam(sun_zenith_deg=30.0, strength=1.0), sky.UniformSky(strength=1.0))


def scene(irradiance):
    return sky.Scene(wavebands=BANDS, n_photons=1000, components=PARTS, irradiance=irradiance)


def test_irradiances_reach_the_source_and_change_no_photon():
    known = Irradiance(of_component=[[1.0, 0.25], [2.0, 0.0]], horizon_loss=[0.0, 0.5])
    plain, absolute = scene(None).source(seed=1), scene(known).source(seed=1)
    assert plain.irradiance(0) is None
    assert plain.horizon_loss(1) == 0.0
    assert absolute.irradiance(0) == {"direct": 1.0, "uniform": 0.25}
    assert absolute.irradiance(1) == {"direct": 2.0, "uniform": 0.0}
    assert absolute.horizon_loss(1) == 0.5
    one, other = plain.photons(0), absolute.photons(0)
    np.testing.assert_array_equal(one.ux, other.ux)
    assert plain.plan.sha256 != absolute.plan.sha256  # another manifest, so another run
    even = np.ones((2, 2))
    wrong = [(values, None) for values in ([[1.0, -1.0], [0.0, 0.0]], [[1.0, np.nan], [0.0, 0.0]], [1.0, 2.0])]
    for values, loss in (*wrong, (even, [0.0]), (even, [0.0, 1.5])):
        with pytest.raises(SceneError):
            Irradiance(of_component=values, horizon_loss=loss)
    with pytest.raises(SceneError, match="2 bands and 2 components"):
        scene(Irradiance(of_component=[[1.0], [1.0]]))


def moments(component):
    return cell_moments((component,))


def test_cells():
    grid = sky.PatchGrid.regular(9, 4)
    for law, power in ((Law.CELL_MU2, 1), (Law.CELL_MU, 0)):
        one = np.ones((1, 36))
        component = Component(name="c", law=law, strength=one[0, :1], mass=one, cell=cells_of_grid(grid, law))
        mean, inverse = moments(component)
        with mp.workdps(30):
            for ring in range(9):
                near, far = (mp.cos(mpf(d) * mp.pi / 180) for d in (10 * ring, 10 * ring + 10))
                norm = quad(lambda m, p=power: m**p, [far, near])
                true = quad(lambda m, p=power: m ** (p + 1), [far, near]) / norm
                assert abs(mean[4 * ring] / true - 1) < 1e-14
                if ring == 8 and law is Law.CELL_MU:
                    assert np.isinf(inverse[4 * ring])
                else:
                    true = quad(lambda m, p=power: m ** (p - 1), [far, near]) / norm
                    assert abs(inverse[4 * ring] / true - 1) < 1e-13


@pytest.mark.parametrize(
    "zenith", [0.0, 35.0, 89.7, 89.7335 + 1e-9, 89.7335 + 1e-6, 89.7336, 89.734, 89.74, 89.9, 90.0]
)
def test_disc(zenith):
    """Quadrature in disc coordinates: polar angle from the centre, in two parts where the horizon cuts the circles."""
    (component,) = sky.DirectBeam(sun_zenith_deg=zenith, radius_deg=0.2665).lower(500)
    assert component.law is (Law.DISC if zenith < 89.72 else Law.DISC_AT_HORIZON)
    mean, inverse = moments(component)
    r, z, below = np.deg2rad(0.2665), np.deg2rad(zenith), np.deg2rad(90.0 - zenith)
    nodes, weights = np.polynomial.legendre.leggauss(400)
    s, w, uncut = (nodes + 1) / 2, weights / 2, min(below, r)
    theta = np.concatenate([uncut * s, uncut + (r - uncut) * s * s])  # the cut circles begin with a root
    w = np.concatenate([uncut * w, (r - uncut) * 2 * s * w])
    # for each polar angle the visible azimuths are |phi| < limit: mu = cos z cos t + sin z sin t cos phi > 0
    a, b = np.sin(below) * np.cos(theta), np.sin(z) * np.sin(theta)
    root = np.sqrt(np.maximum(np.sin(theta + below) * np.sin(theta - below), 0.0))  # of b^2 - a^2
    limit = np.where(np.arange(theta.size) < s.size, np.pi, np.arctan2(root, -a))
    area = 2 * limit
    flux = 2 * (a * limit + b * np.sin(limit))
    square = 2 * (a * a * limit + 2 * a * b * np.sin(limit) + b * b * (limit / 2 + np.sin(2 * limit) / 4))
    measure = w * np.sin(theta)
    assert abs(mean[0] / ((measure @ square) / (measure @ flux)) - 1) < 1e-12
    assert abs(inverse[0] / ((measure @ area) / (measure @ flux)) - 1) < 1e-12


def test_means_of_bands_and_perez_cells():
    result = mean_moments(np.array([0.25, 0.75, 0.0]), np.array([1.0, 0.5, 0.1]), np.array([1.0, 2.0, np.inf]))
    assert result.mean_mu == 0.625
    assert result.mean_inverse_mu == 1.75
    assert result.planar_over_scalar == 1 / 1.75
    dark = mean_moments(np.zeros(2), np.ones(2), np.ones(2))
    assert np.isnan(dark.mean_mu)
    # Means of a coarse grid are those of a fine one, the horizon's included.
    sun = {"sun_zenith_rad": 0.7, "sun_azimuth_rad": 0.2, "epsilon": 8.0, "delta": 0.1}
    results = []
    for n_zenith, n_azimuth in ((9, 12), (90, 120)):
        (component,) = sky.PerezSky(**sun, grid=sky.PatchGrid.regular(n_zenith, n_azimuth)).lower(500)
        mean, inverse = moments(component)
        assert np.all((mean > 0) & (mean <= 1) & (inverse >= 1))
        found = mean_moments(component.mass[0], mean, inverse)
        results.append((found.mean_mu, found.mean_inverse_mu))
    np.testing.assert_allclose(results[0], results[1], rtol=2e-4)


def test_irradiance_of_a_scene_has_names_and_the_total():
    known = scene(Irradiance(of_component=[[1.0, 0.25], [2.0, 0.0]])).irradiance
    assert known.component_names == ("direct", "uniform")
    assert known.total.tolist() == [1.25, 2.0]
    assert known.of("uniform").tolist() == [0.25, 0.0]
    assert repr(known) == "Irradiance(direct 1 to 2, uniform 0 to 0.25, total 1.25 to 2 W m-2 nm-1)"
    with pytest.raises(sky.UsageError, match="no component 'perez'; the names are direct, uniform"):
        known.of("perez")
    with pytest.raises(SceneError, match="component_names"):
        Irradiance(of_component=[[1.0]], component_names=("one", "two"))
