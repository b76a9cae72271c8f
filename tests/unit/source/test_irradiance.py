"""Absolute irradiances of a scene: checked, kept in the plan, without a say in the photons."""

from __future__ import annotations

import numpy as np
import pytest

import aomc_sky
from aomc_sky.errors import SceneError
from aomc_sky.source.irradiance import Irradiance

ZERO = np.zeros(2)
BANDS = aomc_sky.Wavebands(
    wavelength_nm=np.array([450.0, 550.0]),
    bottom_reflectance=ZERO,
    bottom_specular_fraction=ZERO,
    target_reflectance=ZERO,
    target_specular_fraction=ZERO,
)
PARTS = (aomc_sky.DirectBeam(sun_zenith_deg=30.0), aomc_sky.UniformSky())


def scene(irradiance: Irradiance | None) -> aomc_sky.Scene:
    return aomc_sky.Scene(wavebands=BANDS, n_photons=1000, components=PARTS, irradiance=irradiance)


def test_irradiances_reach_the_source_by_name_and_change_no_photon() -> None:
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


@pytest.mark.parametrize(
    ("values", "loss"),
    [
        ([[1.0, -1.0], [0.0, 0.0]], None),
        ([[1.0, np.nan], [0.0, 0.0]], None),
        ([[1.0, np.inf], [0.0, 0.0]], None),
        ([1.0, 2.0], None),
        ([[1.0, 0.0], [0.0, 0.0]], [0.0]),
        ([[1.0, 0.0], [0.0, 0.0]], [0.0, 1.5]),
        ([[1.0, 0.0], [0.0, 0.0]], [np.nan, 0.5]),
    ],
)
def test_what_is_no_irradiance_is_refused(values: list, loss: list | None) -> None:
    with pytest.raises(SceneError):
        Irradiance(of_component=values, horizon_loss=loss)


def test_a_scene_refuses_irradiances_of_another_shape() -> None:
    with pytest.raises(SceneError, match="2 bands and 2 components"):
        scene(Irradiance(of_component=[[1.0], [1.0]]))
