"""Background-sky files from lobes: axes where they are said to point, spectra shared, everything read back."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import SceneError
from aomc_sky.skies.lobes.file.data import ReferenceType, axis_quaternion
from aomc_sky.skies.lobes.lobe import rotation_matrix

WAVELENGTH = [400.0, 550.0, 700.0]
SPECTRUM = [1e-9, 2e-9, 4e-9]


def direction(zenith_deg, azimuth_deg):
    zenith, azimuth = np.deg2rad(zenith_deg), np.deg2rad(azimuth_deg)
    return np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)])


U = 2.0**-53
NORM_ERROR = 12 * U
"""Sines and cosines are good to 2 ulp on any processor: 8 u in the product of two sums of squares, the rest in sums."""
DIRECTION_ERROR = 2 * NORM_ERROR + 2 * np.pi * 2 * U + 8 * U
"""Squares of the quaternion, an angle halved before and one halved after its conversion, sines of the oracle."""


@pytest.mark.parametrize("turn", [0.0, 30.0, -90.0, 400.0])
@pytest.mark.parametrize(("zenith", "azimuth"), [(0, 0), (0, 77), (35, 0), (85, 210), (90, -45), (180, 10), (120, 359)])
def test_axes_point_where_they_are_said_to(zenith, azimuth, turn):
    quaternion = axis_quaternion(zenith, azimuth, turn)
    assert np.linalg.norm(quaternion) == pytest.approx(1.0, abs=NORM_ERROR)
    matrix = rotation_matrix(quaternion)
    np.testing.assert_allclose(matrix[:, 2], direction(zenith, azimuth), rtol=0, atol=DIRECTION_ERROR)
    down, along = direction(zenith + 90, azimuth), direction(90, azimuth + 90)
    t = np.deg2rad(turn)
    np.testing.assert_allclose(matrix[:, 0], np.cos(t) * down + np.sin(t) * along, rtol=0, atol=2 * DIRECTION_ERROR)
    np.testing.assert_allclose(matrix[:, 1], np.cos(t) * along - np.sin(t) * down, rtol=0, atol=2 * DIRECTION_ERROR)


def test_a_file_of_lobes_is_read_back(tmp_path):
    pytest.importorskip("h5py")
    lamp = {"kind": "beckmann", "width": 0.25, "width_y": 0.5, "zenith_deg": 80.0, "spectrum": SPECTRUM}
    file = sky.lobes.background_of_lobes(
        {
            "stars": sky.lobes.SkyLobe(kind="hg", width=0.5, spectrum=[4e-9, 4e-9, 4e-9]),
            "town": [sky.lobes.SkyLobe(**lamp, time_days=0.5), sky.lobes.SkyLobe(**lamp, time_days=0.75, factor=0.5)],
            "round": [sky.lobes.SkyLobe(kind="ggx", width=2.0, spectrum=np.array(SPECTRUM))],
        },
        WAVELENGTH,
        reference="hebdomadal",
        name="a town",
    )
    sky.lobes.write_background(tmp_path / "town.h5", file)
    found = sky.lobes.read_background_file(tmp_path / "town.h5")
    assert found.info.name == "a town"
    assert found.curves.shape == (2, 3)  # three equal spectra are one curve
    town, stars, round_one = (found.animations[name] for name in ("town", "stars", "round"))
    assert town.reference is ReferenceType.HEBDOMADAL
    assert town.coefficient.tolist() == [1.0, 0.5]
    assert town.relative_time_days.tolist() == [0.5, 0.75]
    assert (stars.param0.tolist(), stars.param1.tolist()) == ([0.5], [0.0])
    assert (round_one.param0.tolist(), round_one.param1.tolist()) == ([2.0], [2.0])
    assert town.curve_index.tolist() == [round_one.curve_index[0]] * 2
    np.testing.assert_allclose(found.curves[town.curve_index[0]], SPECTRUM, rtol=1e-7)
    light = sky.read_background(tmp_path / "town.h5").irradiance("town", 5 * 86400.0, 550.0)
    assert light == pytest.approx(0.5 * 2e-9, rel=1e-6)  # a Tuesday, long after the last key


def test_what_cannot_be_built_is_refused():
    good = sky.lobes.SkyLobe(kind="hg", width=0.5, spectrum=SPECTRUM)
    with pytest.raises(SceneError, match="'a': a spectrum of shape \\(3,\\) for 2 wavelengths"):
        sky.lobes.background_of_lobes({"a": good}, WAVELENGTH[:2])
    with pytest.raises(SceneError, match="'b' has no lobe"):
        sky.lobes.background_of_lobes({"a": good, "b": []}, WAVELENGTH)
