"""The law linear in mu^2 and azimuth inside a cell: against mpmath at hard points, and its books against quadrature."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad

import aomc_sky as sky
from aomc_sky.component import MAX_SLOPE, Component, Law, cells_of_grid
from aomc_sky.kernels.cells.laws import slope_words, sloped
from aomc_sky.plan.laws import law_of

SLOPES = [0.0, 2.0**-30, -(2.0**-30), 1e-3, -0.3, 0.7, MAX_SLOPE, -MAX_SLOPE]


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("slope", SLOPES)
def test_places_against_the_distribution_function(kind, slope):
    """Within 4 ulp of the root of (1 - s) x + s x^2 = u, and below 1; a slope of 0 changes no bit."""
    last = 1 - kind(2.0 ** (-24 if kind is np.float32 else -53))
    u = np.array([0.0, np.finfo(kind).tiny, 1e-6, 0.1, 0.5, 0.9, last], kind)
    x, y = sloped(u, u, np.repeat(slope_words(np.array([[slope, 0.0]])), u.size))
    np.testing.assert_array_equal(y, u)
    assert x.max() < 1
    with mpmath.workdps(50):
        s = mpmath.mpf(round(slope * 2**30)) / 2**30
        exact = np.array([float(2 * v / (1 - s + mpmath.sqrt((1 - s) ** 2 + 4 * s * v))) for v in u.astype(float)])
    # 1 - s is rounded once, and the steepest one has 10 bits less
    allowed = 4 * np.finfo(kind).eps * (1 if slope < 0.9 else 2**9)
    np.testing.assert_allclose(x.astype(float), np.minimum(exact, last), rtol=allowed, atol=0)


def sloped_component(grid, slope):
    cell = cells_of_grid(grid)
    return Component(name="s", law=Law.CELL_SLOPED, strength=[1.0], mass=[[1.0]], cell=cell, grid=grid, slope=slope)


def one_ring(slope, *, lo=20.0, hi=70.0):
    grid = sky.PatchGrid(zenith_bounds_deg=[[lo, hi]], azimuth_bounds_deg=[[350.0, 440.0]])
    return sloped_component(grid, [[slope]])


@pytest.mark.parametrize("ends", [(0.0, 90.0), (0.0, 1.0), (89.0, 90.0), (20.0, 70.0)])
@pytest.mark.parametrize("slope", [-0.9, 0.2])
def test_moments_against_quadrature(ends, slope):
    component = one_ring([slope, 0.1], lo=ends[0], hi=ends[1])
    near, growth, far = (float(x[0]) for x in component.grid.ring_sin2())
    mean, inverse = law_of(component.law).moments(component)
    for found, power in ((mean, 1), (inverse, -1)):

        def weighed(root, power=power):  # w = 1 - u = root^2 takes the pole at the horizon away
            w = root * root
            return (far + growth * w) ** (power / 2) * (1 + slope * (1 - 2 * w)) * 2 * root

        assert abs(found[0] / quad(weighed, 0, 1, epsabs=0, epsrel=1e-12)[0] - 1) < 1e-11
    assert near >= 0


def test_flux_through_parts_of_a_cell():
    """A column across azimuth 0, parts of the ring, and all of it."""
    component = one_ring([-0.5, 0.8])
    near, growth, _ = (float(x[0]) for x in component.grid.ring_sin2())
    rings = np.array([[20.0, 30.0], [30.0, 70.0], [0.0, 90.0]])
    columns = np.array([[-10.0, 20.0], [20.0, 80.0], [0, 360]])
    flux = law_of(component.law).flux(component, rings, columns)

    def share(low, high, slope):
        return quad(lambda u: 1 + slope * (2 * u - 1), low, high)[0]

    def u_of(zenith):
        return np.clip((np.sin(np.deg2rad(zenith)) ** 2 - near) / growth, 0, 1)

    along = [share(u_of(low), u_of(high), -0.5) for low, high in rings]
    across = [share(0, 1 / 3, 0.8), share(1 / 3, 1, 0.8), share(1 / 9, 1, 0.8)]  # the last: 0 to 80, from 350 none
    across[2] += share(0, 1 / 9, 0.8)
    np.testing.assert_allclose(flux, np.outer(along, across), rtol=1e-12)


def tinted(z, a, nm):
    """Leans one way in the blue and another in the red."""
    return np.exp((nm - 550) / 60 * np.sin(z) * np.cos(a)) + z


def mixed_scene():
    function = sky.FunctionSky(tinted, grid=sky.PatchGrid.regular(6, 12), strength=1.0)
    disc = sky.DirectBeam(sun_zenith_deg=89.9, sun_azimuth_deg=10.0, radius_deg=0.3, strength=0.5)
    even = sky.UniformSky(strength=0.5)
    return sky.Scene(wavebands=[440.0, 670.0], n_photons=40_000, components=[function, disc, even])


def test_bands_have_slopes_of_their_own(tmp_path):
    """Means of each band against the exact ones; a plan read back gives the same photons."""
    source = mixed_scene().source(seed=5)
    assert source.bands_differ_inside_cells
    for band in (0, 1):
        mean = -source.photons(band).uz.mean(dtype=float)
        assert abs(mean - source.exact_moments(band).mean_mu) < 5e-5
    assert not np.allclose(source.cell_moments(0)[0][:72], source.cell_moments(1)[0][:72], rtol=1e-3)
    source.plan.save(tmp_path / "plan.npz")
    again = sky.PhotonSource(sky.Plan.load(tmp_path / "plan.npz"))
    np.testing.assert_array_equal(again.photons(1).ux, source.photons(1).ux)
    grid = sky.PatchGrid.regular(6, 12)
    scene = sky.Scene(wavebands=[550], n_photons=5000, components=sky.FunctionSky(tinted, grid=grid))
    batch = scene.source(seed=1, placement="centre").photons()
    assert np.unique(np.round(batch.uz, 6)).size <= 6


@pytest.mark.parametrize("slope", [[[[1.0, 0.0]]], [[[np.nan, 0.0]]], [[[0.1, 0.0], [0.1, 0.0]]], None])
def test_slopes_that_no_kernel_may_read(slope):
    with pytest.raises(ValueError, match="slope"):
        sloped_component(sky.PatchGrid.regular(1, 1), slope)
