"""Patch masses of the Perez sky by two routes, at every special place of the sun; bounds that hold at every point."""

import dataclasses

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.patches import first_factor_zero, second_factor_zeros
from aomc_sky.skies.perez.sky import PerezSky

pytestmark = pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")


def test_zeros_of_the_factors():
    assert first_factor_zero(-0.5, -0.1) == -1
    assert first_factor_zero(-5.0, 0.0) == -1
    zero = first_factor_zero(-3.0, -0.5)
    assert 1 - 3 * np.exp(-0.5 / np.cos(zero * np.pi / 2)) == pytest.approx(0, abs=1e-14)
    assert second_factor_zeros(1.0, -1.0, 0.1).size == 0
    roots = second_factor_zeros(-3.0, -1.0, 0.0)
    assert 2 * np.arcsin(np.sqrt(roots)) == pytest.approx([np.log(3.0)], rel=1e-12)


def test_mirrored_and_turned_columns_and_suns_on_edges():
    grid = PatchGrid.regular(9, 36)
    skies = [
        PerezSky(sun_zenith_rad=0.9, sun_azimuth_rad=np.deg2rad(azimuth), epsilon=5.0, delta=0.15)
        for azimuth in (40.0, 40.0 + 1e-7, -320.0, 0.0)
    ]
    mass = [sky.patch_mass(grid).reshape(9, 36) for sky in skies]
    np.testing.assert_allclose(mass[0], np.roll(mass[0][:, ::-1], 8, axis=1), rtol=1e-12)
    np.testing.assert_allclose(mass[0], mass[1], rtol=1e-7)
    np.testing.assert_array_equal(mass[0], mass[2])
    np.testing.assert_allclose(np.roll(mass[3], 4, axis=1), mass[0], rtol=1e-10)
    grid = PatchGrid.regular(9, 12)
    for zenith, azimuth in ((30.0, 60.0), (30.0, 45.0), (35.0, 60.0), (30.0, 0.0), (30.0, 360.0), (29.9999999, 60.0)):
        sky = PerezSky(sun_zenith_rad=np.deg2rad(zenith), sun_azimuth_rad=np.deg2rad(azimuth), epsilon=8.0, delta=0.05)
        known = float(perez.horizontal_integral(sky.model_coefficients, sky.sun_zenith_rad))
        assert sky._integrals(grid)[1] == pytest.approx(known, rel=1e-11)


def test_columns_below_zero_and_empty_patches():
    sky = PerezSky(sun_zenith_rad=0.9, sun_azimuth_rad=0.0, epsilon=8.0, delta=0.1)
    shifted = PatchGrid(
        zenith_bounds_deg=np.array([[0.0, 30.0], [30.0, 30.0], [30.0, 90.0]]),
        azimuth_bounds_deg=np.array([[-45.0, 45.0], [45.0, 45.0], [45.0, 200.0], [200.0, 315.0]]),
    )
    mass = sky.patch_mass(shifted).reshape(3, 4)
    assert mass.sum() == pytest.approx(1, rel=1e-13)
    assert mass[1].max() == 0
    assert mass[:, 1].max() == 0
    first = PatchGrid(zenith_bounds_deg=np.array([[30.0, 90.0]]), azimuth_bounds_deg=np.array([[315.0, 405.0]]))
    assert sky.patch_mass(first)[0] == pytest.approx(mass[2, 0], rel=1e-10)


HARD = [
    {"sun_zenith_rad": 0.7, "epsilon": 8.0, "delta": 0.1},
    {"sun_zenith_rad": 0.0, "epsilon": 5.0, "delta": 0.2},
    {"sun_zenith_rad": 1.5, "epsilon": 1.0, "delta": 0.6},
    {"sun_zenith_rad": 1.2, "epsilon": 13.0, "delta": 0.05},
    {"sun_zenith_rad": 0.15, "coefficients": (-1.2, -0.4, 9.0, -14.0, 0.5)},
    {"sun_zenith_rad": 0.9, "coefficients": (0.5, -0.1, -3.0, -0.6, 0.8)},
    {"sun_zenith_rad": 0.9, "coefficients": (-1.0, -0.3, 0.2, 0.4, -0.3)},
]


@pytest.mark.parametrize("case", HARD)
@pytest.mark.parametrize("shape", [(9, 12), (45, 180), (3, 1)])
def test_every_point_lies_between(case, shape):
    grid = PatchGrid.regular(*shape)
    model = PerezSky(sun_azimuth_rad=0.3, grid=grid, **case)
    (component,) = model.lower(500)
    assert component.law is Law.PEREZ
    upper, lower, tilt_u, tilt_v = component.bounds.T[:, :, None, None]
    share = np.array([0.0, 1e-9, 0.2, 0.5, 0.77, 1.0])
    u, v = share[:, None], share[None, :]
    sine2 = np.sin(np.deg2rad(grid.zenith_bounds_deg)) ** 2
    ring, column = np.divmod(np.arange(grid.n_patches), grid.n_azimuth)
    u_moved, v_moved = u + tilt_u * u * (1 - u), v + tilt_v * v * (1 - v)
    near, far = sine2[ring].T[:, :, None, None]
    zenith = np.arcsin(np.sqrt(np.minimum(near + (far - near) * u_moved, 1.0)))
    first, last = np.deg2rad(grid.azimuth_bounds_deg)[column].T[:, :, None, None]
    value = model.radiance(zenith, first + (last - first) * v_moved, 500)
    value = value * (1 + tilt_u * (1 - 2 * u)) * (1 + tilt_v * (1 - 2 * v))
    assert np.all(value <= upper)
    assert np.all(value >= lower)
    if shape == (45, 180):
        # bounds that are never reached would cost trials: all together they are close to the sampled ends
        area = grid.projected_solid_angle_sr
        assert area @ upper[:, 0, 0] <= 1.04 * (area @ value.max(axis=(1, 2)))
        assert area @ lower[:, 0, 0] >= 0.96 * (area @ value.min(axis=(1, 2)))


def test_two_skies_with_exact_cells_are_refused():
    """Each way that the sentences name is a scene."""
    bands, model = {"wavebands": [500.0], "n_photons": 10}, PerezSky(sun_zenith_rad=0.7, epsilon=8.0, delta=0.1)
    one = model.lower(500)[0]
    with pytest.raises(sky.SceneError, match=r"names must differ, got .* name="):
        sky.Scene(**bands, components=(one, one))
    with pytest.raises(sky.SceneError, match=r"'perez' and 'second' are of law PEREZ, of which a scene can have one"):
        sky.Scene(**bands, components=(one, dataclasses.replace(one, name="second")))
    (flat,) = dataclasses.replace(model, within="uniform", sun_zenith_deg=None, sun_azimuth_deg=None).lower(500)
    other = sky.FunctionSky(model.radiance, name="third", strength=1.0)
    for more in (dataclasses.replace(flat, name="second"), *other.lower(500)):
        assert sky.Scene(**bands, components=(one, more)).source().total == 10
