"""Bounds of the Perez luminance over patches hold at every point, and are not much wider than they must be."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law

HARD = [
    {"sun_zenith_rad": 0.7, "epsilon": 8.0, "delta": 0.1},
    {"sun_zenith_rad": 0.0, "epsilon": 5.0, "delta": 0.2},
    {"sun_zenith_rad": 1.5, "epsilon": 1.0, "delta": 0.6},
    {"sun_zenith_rad": 1.2, "epsilon": 13.0, "delta": 0.05},
    {"sun_zenith_rad": 0.15, "coefficients": (-1.2, -0.4, 9.0, -14.0, 0.5)},
    {"sun_zenith_rad": 0.9, "coefficients": (0.5, -0.1, -3.0, -0.6, 0.8)},
    {"sun_zenith_rad": 0.9, "coefficients": (-1.0, -0.3, 0.2, 0.4, -0.3)},
]


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")
@pytest.mark.parametrize("case", HARD)
@pytest.mark.parametrize("shape", [(9, 12), (45, 180), (3, 1)])
def test_every_point_lies_between(case, shape):
    grid = sky.PatchGrid.regular(*shape)
    model = sky.PerezSky(sun_azimuth_rad=0.3, grid=grid, **case)
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
