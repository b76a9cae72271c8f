"""Arguments of an enumeration take its members and their words, and refuse everything else."""

import enum
import importlib
import inspect
import pkgutil
import re

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS

ENUMERATIONS = {
    value.__name__: value
    for module in pkgutil.walk_packages(sky.__path__, "aomc_sky.")
    if "__main__" not in module.name
    for value in vars(importlib.import_module(module.name)).values()
    if isinstance(value, type) and issubclass(value, enum.Enum) and value.__module__.startswith("aomc_sky")
}


def arguments():
    """Public functions and classes, and the arguments of theirs that are annotated as members of an enumeration."""
    found = {}
    rooms = {"": sky, **{f"{name}.": getattr(sky, name) for name in ("directions", "perez", "rayleigh", "lobes")}}
    for prefix, room in rooms.items():
        public = sky.__all__ if room is sky else [name for name in vars(room) if not name.startswith("_")]
        for name in public:
            thing = getattr(room, name)
            methods = vars(thing) if isinstance(thing, type) and not issubclass(thing, enum.Enum) else ()
            callables = {name: thing} | {f"{name}.{one}": getattr(thing, one) for one in methods if one[0] != "_"}
            for called, function in callables.items():
                if not callable(function) or (
                    isinstance(function, type) and issubclass(function, (enum.Enum, BaseException))
                ):
                    continue
                for parameter in inspect.signature(function).parameters.values():
                    words = set(re.findall(r"\w+", str(parameter.annotation)))
                    for kind in words & set(ENUMERATIONS):
                        found[prefix + called, parameter.name] = ENUMERATIONS[kind]
    return found


GRID = {"grid": sky.PatchGrid.regular(1, 2), "wavelength_nm": [500.0], "values": np.ones((1, 2))}
POINTS = ([0.0, 40.0, 40.0], [0.0, 0.0, 180.0], [1.0, 1.0, 1.0])
TABLE = {"wavelength_nm": np.array([500.0]), "radiance": np.ones((1, 1, 1)), "path": "skydist.inp"}
FIELD = sky.RadianceField.from_points(*POINTS, is_absolute=False)
CELL = {"name": "a", "strength": np.ones(1), "mass": np.ones((1, 1)), "cell": np.zeros((1, 6))}


def scan(value):
    return sky.read_radiance_csv(INPUTS / "measured" / "sky.csv", azimuth_convention=value)


def measured(value):
    fields = ("wavelength_nm", "direction", "values")
    return sky.RadianceField(**{name: getattr(FIELD, name) for name in fields}, convention=value)


def picture(value):
    pytest.importorskip("matplotlib")
    return sky.plot(sky.Scene(wavebands=[500.0], n_photons=10, components="uniform"), azimuth_convention=value)


def from_xarray(value):
    xarray = pytest.importorskip("xarray")
    coordinates = {"zenith": ("zenith", [20.0, 60.0], {"units": "degree"}), "wavelength": 500.0}
    coordinates |= {"azimuth": ("azimuth", [0.0, 90.0, 180.0, 270.0], {"units": "degree"})}
    field = xarray.DataArray(np.ones((2, 4)), dims=("zenith", "azimuth"), coords=coordinates, name="radiance")
    return sky.TabulatedSky.from_xarray(
        field, azimuth_convention=value, radiance_unit="relative", wavelength_unit="nm", sun_azimuth_deg=0.0
    )


CALLS = {
    ("Component", "law"): lambda value: sky.Component(**CELL, law=value),
    ("Footprint", "shape"): lambda value: sky.Footprint(shape=value, size_x_m=1.0, size_y_m=1.0),
    ("RadianceField", "convention"): measured,
    ("RadianceField.from_points", "convention"): lambda value: sky.RadianceField.from_points(
        *POINTS, is_absolute=False, convention=value
    ),
    ("SkyTable", "declared_bins"): lambda value: sky.SkyTable(**TABLE, declared_bins=value),
    ("SkyTable", "declared_values"): lambda value: sky.SkyTable(**TABLE, declared_values=value),
    ("TabulatedSky", "weighting"): lambda value: sky.TabulatedSky(**GRID, weighting=value),
    ("TabulatedSky.from_xarray", "azimuth_convention"): from_xarray,
    ("allocate", "method"): lambda value: sky.allocate(np.ones((2, 2)), 7, method=value),
    ("plot", "azimuth_convention"): picture,
    ("read_radiance_csv", "azimuth_convention"): scan,
    ("verify_counts", "method"): lambda value: sky.verify_counts([1, 1], [1.0, 1.0], method=value),
    ("write_skydist", "bins"): lambda value: sky.write_skydist(sky.SkyTable(**TABLE), "skydist.inp", bins=value),
    ("write_skydist", "values"): lambda value: sky.write_skydist(sky.SkyTable(**TABLE), "skydist.inp", values=value),
    ("directions.sky_angles", "frame"): lambda value: sky.directions.sky_angles(np.array([0.0, 0.6, -0.8]), value),
    ("directions.sky_from_travel", "frame"): lambda value: sky.directions.sky_from_travel([0.0, 0.6, -0.8], value),
    ("directions.to_enu_azimuth_deg", "convention"): lambda value: sky.directions.to_enu_azimuth_deg(30.0, value, 10.0),
    ("directions.travel_from_sky", "frame"): lambda value: sky.directions.travel_from_sky(30.0, 0.0, value),
}
"""A call of each of them."""
BY_NUMBER = {("Component", "law")}
"""A law is its number, which is part of files."""


def test_every_public_argument_of_an_enumeration_has_a_call():
    assert set(CALLS) == set(arguments())


@pytest.mark.parametrize("which", CALLS, ids=".".join)
def test_what_is_no_member_is_refused(which, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for wrong in ("nothing", 99, 1.5, b"up", ["up"]):
        with pytest.raises((sky.UsageError, sky.InputFileError, ValueError)):
            CALLS[which](wrong)
    assert not list(tmp_path.iterdir())


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")
@pytest.mark.parametrize("which", set(CALLS) - BY_NUMBER, ids=".".join)
def test_words_are_members(which, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for member in arguments()[which]:
        word = member.value if isinstance(member.value, str) else member.name.lower()
        try:
            expected = CALLS[which](member)
        except (sky.AomcSkyError, ValueError) as error:  # a member that goes with other arguments
            with pytest.raises(type(error), match=re.escape(str(error)[:60])):
                CALLS[which](word)
            continue
        for written in (word, word.upper()):
            found = CALLS[which](written)
            if isinstance(found, np.ndarray | tuple):
                np.testing.assert_array_equal(found, expected)


def test_light_comes_from_above_in_the_frame_that_is_named():
    up, down = (sky.directions.travel_from_sky(30.0, 0.0, frame) for frame in ("UP", "down"))
    np.testing.assert_allclose((up[2], down[2]), (-np.cos(np.pi / 6), np.cos(np.pi / 6)), rtol=1e-15)
    assert sky.directions.to_enu_azimuth_deg(30.0, "north_clockwise") == 60.0
    for wrong in ("sideways", None, 0):
        with pytest.raises(sky.UsageError, match=r"frame must be one of 'up', 'down', got"):
            sky.directions.travel_from_sky(30.0, 0.0, wrong)
