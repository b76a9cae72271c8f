"""`AtmosphereSky.from_file`: a sky of a description, with its warnings and errors."""

import shutil

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import InputFileError
from aomc_sky.skies.atmosphere.description.medium import read_medium
from tests.support.shared import INPUTS

MARINE = INPUTS / "atmosphere" / "clear_marine.atmo"
FEW = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 20.0, "n_orders": 1, "grid": sky.PatchGrid.regular(6, 8)}


def test_it_is_the_sky_of_the_medium(tmp_path):
    found = sky.AtmosphereSky.from_file(str(MARINE), wavelength_nm=[440.0, 560.0], **FEW)
    medium, _ = read_medium(sky.atmosphere.read_atmo(MARINE), [440.0, 560.0])
    expected = sky.AtmosphereSky(medium=medium, **FEW)
    assert found.medium.wavelength_nm.tolist() == [440.0, 560.0]
    np.testing.assert_array_equal(found.patch_mean, expected.patch_mean)
    np.testing.assert_array_equal(found.direct_irradiance, expected.direct_irradiance)
    assert found.solved.n_orders == 1
    # The description names spectra/..., here by an absolute path of another folder.
    shutil.copytree(MARINE.parent / "spectra", tmp_path / "tables")
    (tmp_path / "own").mkdir()
    text = MARINE.read_text().replace("file spectra/", "file ../tables/").replace("file phase/", "file ../tables/")
    shutil.copy(MARINE.parent / "phase" / "sea_salt.csv", tmp_path / "tables")
    moved = tmp_path / "own" / "clear.atmo"
    moved.write_text(text)
    with pytest.raises(InputFileError, match="--allow-path"):
        sky.AtmosphereSky.from_file(moved, wavelength_nm=560.0, **FEW)
    found = sky.AtmosphereSky.from_file(moved, wavelength_nm=560.0, allow_paths=[tmp_path / "tables"], **FEW)
    same = sky.AtmosphereSky.from_file(MARINE, wavelength_nm=560.0, **FEW)
    np.testing.assert_array_equal(found.patch_mean, same.patch_mean)


@pytest.mark.parametrize("name", ["molecules_only", "clear_marine", "continental", "hazy"])
def test_the_shipped_descriptions_reach_from_380_to_900_nm(name):
    found = sky.solve_atmosphere(
        INPUTS / "atmosphere" / f"{name}.atmo",
        wavelength_nm=[380.0, 412.0, 443.0, 670.0, 765.0, 865.0, 900.0],
        sun_zenith_deg=40.0,
        sky_zenith_deg=[0.0],
        azimuth_from_sun_deg=[0.0],
        method="order1",
    )
    light = found.radiance[:, 0, 0]
    assert np.all(np.diff(light[3:]) < 0)
    assert np.all(light > 0)
    assert np.all(np.diff(found.direct_irradiance[3:]) < 0)  # the sun's own light falls, too
    assert np.all(found.direct_irradiance > 0.1)
