"""Radiance fields in the layouts of programs and instruments: names, dimensions, units and attributes as they write."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fields import NM, angles_of, radiance, through_a_file

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
    for field in (eradiate()["radiance"], through_a_file(eradiate(), tmp_path / "eradiate.nc")):
        check(read(field, azimuth_convention="enu_from_east"), 0.02)
    bare = read(eradiate()["radiance"])  # its azimuths count from +x, as ours
    check(bare, 0.02)
    assert any("does not say from where azimuths count" in remark for remark in bare.remarks)


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
    """Irregular angles, clockwise from north; unfinished pointings are gaps and are said."""
    made = hypernets()
    field = through_a_file(made, tmp_path / "series.nc", variable="downwelling_radiance")
    python_field = made.set_coords(["viewing_zenith_angle", "viewing_azimuth_angle"])["downwelling_radiance"]
    for one in (field, python_field):
        with pytest.warns(sky.InputWarning, match=r"5\.\d % of the light comes from beyond the measured directions"):
            table = read(one, grid=sky.PatchGrid.regular(36, 72))
        check(table, 0.03)
        assert any("30 of 1500 directions have no value" in remark for remark in table.remarks)
        assert any("% of the light comes from beyond" in remark for remark in table.remarks)
    with pytest.raises(sky.SceneError, match="2 variables of numbers: 'downwelling_radiance', 'upwelling_radiance'"):
        through_a_file(hypernets(), tmp_path / "series.nc")


def test_libradtran_and_disort(tmp_path):
    """umu is negative for light from the sky, and upward directions are left out; phi counts as uvspec's."""
    umu, phi = -np.cos(np.deg2rad(np.arange(1.0, 90.0, 2.0))), np.arange(0.0, 360.0, 4.0)
    ours = np.mod(-90 - phi, 360)  # phi 0 is the sky in the south, 90 in the west
    zenith = np.rad2deg(np.arccos(-umu))
    values = radiance(zenith[:, None], ours, NM[:, None, None])
    both = np.concatenate([values, -1e-17 * values[:, ::-1]], axis=1)  # upward radiance over a black ground, rounded
    made = xarray.DataArray(
        both,
        dims=("lambda", "umu", "phi"),
        coords={
            "lambda": ("lambda", NM, {"units": "nm"}),
            "umu": np.concatenate([umu, -umu[::-1]]),
            "phi": ("phi", phi, {"units": "degrees"}),
        },
        name="uu",
    )
    for field in (made, through_a_file(made, tmp_path / "uu.nc")):
        table = read(field, azimuth_convention="west_of_south")
        check(table, 0.02)
        assert "45 zenith angles below the horizon were left out" in table.remarks


def test_sasktran2(tmp_path):
    """radiance over wavelength, los and stokes, the letters of stokes as a coordinate; the angles are assigned."""
    zenith, azimuth = (a.ravel() for a in np.meshgrid(np.linspace(1, 85, 29), np.arange(0.0, 360.0, 6.0)))
    values = np.stack([radiance(zenith, azimuth, NM[:, None])] + [np.full((2, zenith.size), -1e-3)] * 2, axis=-1)
    made = xarray.DataArray(values, dims=("wavelength", "los", "stokes"), name="radiance")
    made = made.assign_coords(wavelength=NM, stokes=["I", "Q", "U"], **angles_of("los", zenith, azimuth))
    check(read(made.isel(stokes=0)), 0.02)
    check(read(through_a_file(made, tmp_path / "sk.nc", isel={"stokes": 0})), 0.02)
    table = read(made)  # all pairs of zenith angles and azimuths
    check(table, 0.02)
    np.testing.assert_allclose(table.values_q, -1e-3, rtol=0.03)
    with pytest.raises(sky.SceneError, match=r"without gaps; .* field.isel\(stokes=0\)"):
        read(made.isel(los=slice(0, -1)))
