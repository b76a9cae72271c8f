"""Radiance fields in the layouts of programs and instruments: names, dimensions, units and attributes as they write."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import FieldError
from tests.support.fields import FROM_EAST, NM, angles_of, radiance, through_a_file

xarray = pytest.importorskip("xarray")
read = sky.TabulatedSky.from_xarray
pytest.importorskip("h5netcdf")


def check(table, tolerance):
    """The table is the radiance above, well inside the measured directions."""
    zenith, azimuth = np.meshgrid([15.0, 35.0, 55.0], np.arange(7.0, 360.0, 40.0))
    for nm in NM:
        seen = table.radiance(np.deg2rad(zenith), np.deg2rad(azimuth), nm)
        np.testing.assert_allclose(seen, radiance(zenith, azimuth, nm), rtol=tolerance)
        mirrored = radiance(zenith, -azimuth, nm)
        assert np.abs(seen / mirrored - 1).max() > 5 * tolerance


def asks(field, **how):
    """The keywords that a field is asked for."""
    with pytest.raises(FieldError) as error:
        read(field, **how)
    assert all(one.field in one.advice for one in error.value.problems)
    return [one.field for one in error.value.problems]


def eradiate():
    """A result of Eradiate: film pixels x_index, y_index with vza and vaa, a spectral axis w, one sun."""
    vza, vaa = np.meshgrid(np.linspace(1, 85, 29), np.arange(0.0, 360.0, 6.0), indexing="ij")
    values = radiance(vza, vaa, NM[:, None, None])[:, None, None]
    angle, unit = {"units": "deg"}, {"standard_name": "radiance", "units": "W/m**2/sr/nm"}
    return xarray.Dataset(
        {
            "radiance": (("w", "sza", "saa", "x_index", "y_index"), values, unit),
            "irradiance": (("w", "sza", "saa"), np.ones((2, 1, 1)), {"units": "W/m**2/nm"}),
        },
        coords={
            "w": ("w", NM, {"standard_name": "radiation_wavelength", "long_name": "wavelength", "units": "nm"}),
            "sza": ("sza", [30.0], angle | {"standard_name": "solar_zenith_angle"}),
            "saa": ("saa", [0.0], angle | {"standard_name": "solar_azimuth_angle"}),
            "x_index": np.arange(29),
            "y_index": np.arange(60),
            "vza": (("x_index", "y_index"), vza, angle | {"standard_name": "viewing_zenith_angle"}),
            "vaa": (("x_index", "y_index"), vaa, angle | {"standard_name": "viewing_azimuth_angle"}),
        },
    )


def test_eradiate(tmp_path):
    """Its angles are named; azimuths count from +x, as ours."""
    for field in (eradiate()["radiance"], eradiate(), through_a_file(eradiate(), tmp_path / "eradiate.nc")):
        assert asks(field)[0] == "zenith"
        named = {"zenith": "vza", "azimuth": "vaa"}
        assert asks(field, **named) == ["azimuth_convention", "isel"]
        check(read(field, **named, **FROM_EAST, wavelength="w"), 0.02)


def hypernets():
    """Level 1 of the HYPERNETS water network: series of pointings, angles as variables, packed in whole numbers."""
    rng = np.random.default_rng(2)
    zenith, ours = np.rad2deg(np.arccos(np.sqrt(rng.uniform(0.03, 1, 1500)))), rng.uniform(0, 360, 1500)
    values = radiance(zenith, ours, NM[:, None])
    values[:, :30] = np.nan
    angles = {
        "viewing_zenith_angle": (zenith, {"standard_name": "sensor_zenith_angle", "preferred_symbol": "vza"}),
        "viewing_azimuth_angle": (
            np.mod(90 - ours, 360),
            {"standard_name": "sensor_azimuth_angle", "reference": "True North", "preferred_symbol": "vaa"},
        ),
        "solar_zenith_angle": (np.full(1500, 30.0), {"standard_name": "solar_zenith_angle"}),
    }
    made = xarray.Dataset(
        {name: ("series", numbers, texts | {"units": "degrees"}) for name, (numbers, texts) in angles.items()},
        coords={"wavelength": ("wavelength", NM, {"standard_name": "wavelength", "units": "nm"})},
    )
    for name, light in (("downwelling_radiance", values), ("upwelling_radiance", values / 50)):
        texts = {"standard_name": f"{name}_per_unit_wavelength_in_air", "units": "mW m^-2 nm^-1 sr^-1"}
        made[name] = (("wavelength", "series"), light, texts)
    for name in ("viewing_zenith_angle", "viewing_azimuth_angle"):
        made[name].encoding = {"dtype": "uint16", "scale_factor": 0.01, "_FillValue": 65535}
    return made


def test_pointings_of_a_radiometer(tmp_path):
    """Irregular angles, clockwise from north by CF; unfinished pointings are gaps and are said."""
    made, named = hypernets(), {"zenith": "viewing_zenith_angle", "azimuth": "viewing_azimuth_angle"}
    for one in (made, through_a_file(made, tmp_path / "series.nc")):
        assert asks(one) == ["variable"]
        assert asks(one, variable="downwelling_radiance")[0] == "zenith"
        with pytest.warns(sky.InputWarning, match=r"5\.\d % of the light comes from beyond the measured directions"):
            table = read(one, variable="downwelling_radiance", **named, grid=sky.PatchGrid.regular(36, 72))
        check(table, 0.03)
        assert any("30 of 1500 directions have no value" in remark for remark in table.remarks)
        assert "not used: variables solar_zenith_angle, upwelling_radiance" in table.remarks
        assert 'the file says "preferred_symbol: vza"; "reference: True North"' in table.remarks[0]


@pytest.mark.parametrize("name", ["vaa", "phi"])
def test_points_whose_azimuth_has_another_name_are_no_sky_without_azimuths(name):
    """1500 directions became 1500 rings."""
    made = hypernets().isel(series=slice(30, None)).rename(viewing_zenith_angle="zenith", viewing_azimuth_angle=name)
    with pytest.raises(FieldError, match=f"'{name}'.*azimuth={name}"):
        read(made, variable="downwelling_radiance")


def test_libradtran(tmp_path):
    """uvspec's directions as zenith angles; upward ones are left out, and phi counts clockwise from the south."""
    zenith, phi = np.arange(1.0, 90.0, 2.0), np.arange(0.0, 360.0, 4.0)
    values = radiance(zenith[:, None], np.mod(-90 - phi, 360), NM[:, None, None])
    both = np.concatenate([values, -1e-17 * values[:, ::-1]], axis=1)  # upward radiance over a black ground, rounded
    coords = {
        "lambda": ("lambda", NM, {"units": "nm"}),
        "sky_angle": ("sky_angle", np.append(zenith, 180 - zenith[::-1]), {"units": "degrees"}),
        "phi": ("phi", phi, {"units": "degrees"}),
    }
    made = xarray.DataArray(both, dims=("lambda", "sky_angle", "phi"), coords=coords, name="uu")
    for field in (made, through_a_file(made, tmp_path / "uu.nc")):
        assert asks(field)[0] == "zenith"
        assert asks(field, zenith="sky_angle") == ["isel", "isel"]
        with pytest.raises(FieldError, match="dimension 'lambda' of 2 ") as error:
            read(field, zenith="sky_angle")
        of_lambda, of_phi = (one.advice for one in error.value.problems)
        assert "--coordinate wavelength=lambda (wavelength='lambda')" in of_lambda
        assert "--coordinate azimuth=phi (azimuth='phi')" in of_phi
        assert "azimuths need --azimuth-convention, too" in of_phi
        named = {"zenith": "sky_angle", "azimuth": "phi", "wavelength": "lambda"}
        assert asks(field, **named) == ["azimuth_convention"]
        table = read(field, **named, azimuth_convention="west_of_south")
        check(table, 0.02)
        assert "45 zenith angles below the horizon were left out" in table.remarks


def test_sasktran2(tmp_path):
    """radiance over wavelength, los and stokes, the letters of stokes as a coordinate; the angles are assigned."""
    zenith, azimuth = (a.ravel() for a in np.meshgrid(np.linspace(1, 85, 29), np.arange(0.0, 360.0, 6.0)))
    values = np.stack([radiance(zenith, azimuth, NM[:, None])] + [np.full((2, zenith.size), -1e-3)] * 2, axis=-1)
    made = xarray.DataArray(values, dims=("wavelength", "los", "stokes"), name="radiance")
    made = made.assign_coords(wavelength=NM, stokes=["I", "Q", "U"], **angles_of("los", zenith, azimuth))
    for field in (made, through_a_file(made, tmp_path / "sk.nc")):
        assert asks(field) == ["wavelength_unit"]
        check(read(field.isel(stokes=0), wavelength_unit="nm"), 0.02)
        table = read(field, wavelength_unit="nm")  # all pairs of zenith angles and azimuths
        check(table, 0.02)
        np.testing.assert_allclose(table.values_q, -1e-3, rtol=0.03)
        with pytest.raises(sky.SceneError, match=r"without gaps; .*--isel stokes=0"):
            read(field.isel(los=slice(0, -1)), wavelength_unit="nm")
