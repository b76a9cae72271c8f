"""Angles of models in degrees or in radians: every public one has both, and exactly one is given."""

import copy
import dataclasses
import inspect
import math
import pickle
import pydoc

import mpmath
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.directions import given_angle

OTHER = {"_deg": "_rad", "_rad": "_deg"}
PUBLIC = {name: getattr(sky, name) for name in sky.__all__}
PUBLIC |= {name: pydoc.locate(f"aomc_sky.{module}.{name}") for name, module in sky._OLD.items()}
CALLABLES = {name: thing for name, thing in PUBLIC.items() if callable(thing)}
ANGLES = [
    (name, parameter)
    for name, thing in CALLABLES.items()
    if name not in ("weather_scene", "irradiances")  # entrances: degrees alone, as in the files
    if inspect.isfunction(thing) or dataclasses.is_dataclass(thing)
    for parameter in inspect.signature(thing).parameters
    if parameter[-4:] in OTHER and parameter not in ("latitude_deg", "longitude_deg")  # degrees all over the world
]
MODELS = {
    # what can be built in no time, with all its angles in degrees
    "DirectBeam": {"sun_zenith_deg": 33.0, "sun_azimuth_deg": -70.0, "radius_deg": 0.2665},
    "Moon": {"zenith_deg": 41.0, "azimuth_from_sun_deg": 0.1, "distance_m": 3.8e8},
    "PatchGrid": {"zenith_bounds_deg": [[0.0, 30.0], [30.0, 90.0]], "azimuth_bounds_deg": [[-5.0, 355.0]]},
    "PerezSky": {"sun_zenith_deg": 33.0, "sun_azimuth_deg": 250.0, "epsilon": 3.0, "delta": 0.2},
    "SkyLobe": {
        "kind": "hg", "width": 0.9, "zenith_deg": 33.0, "azimuth_deg": 70.0, "turn_deg": 5.0, "spectrum": (1.0,)
    },
}  # fmt: skip


@pytest.mark.parametrize(("name", "parameter"), ANGLES)
def test_every_angle_has_its_twin(name, parameter):
    parameters = inspect.signature(CALLABLES[name]).parameters
    twin = parameter[:-4] + OTHER[parameter[-4:]]
    assert twin in parameters
    for one in (parameter, twin):
        assert parameters[one].default is None
        assert parameters[one].kind is inspect.Parameter.KEYWORD_ONLY
        assert one in (inspect.getdoc(CALLABLES[name]) or "")


def in_radians(arguments):
    angles = {name: value for name, value in arguments.items() if name.endswith("_deg")}
    others = {name: value for name, value in arguments.items() if name not in angles}
    return others | {f"{name[:-4]}_rad": np.deg2rad(value) for name, value in angles.items()}


@pytest.mark.parametrize("name", MODELS)
def test_both_units_make_one_model(name):
    by_degrees = CALLABLES[name](**MODELS[name])
    by_radians = CALLABLES[name](**in_radians(MODELS[name]))
    for twin in (one for one in (*MODELS[name], *in_radians(MODELS[name])) if one[-4:] in OTHER):
        np.testing.assert_allclose(getattr(by_radians, twin), getattr(by_degrees, twin), rtol=3e-16)
    for model in (by_degrees, by_radians):
        again = [copy.deepcopy(model), dataclasses.replace(model), pickle.loads(pickle.dumps(model))]
        assert {repr(one) for one in again} == {repr(model)}
        if name != "PatchGrid":  # arrays
            assert all(one == model for one in again)
    fields = {field.name for field in dataclasses.fields(by_degrees)}
    angle = next(one for one in (*MODELS[name], *in_radians(MODELS[name])) if one in fields and one[-4:] in OTHER)
    given = MODELS[name] if angle in MODELS[name] else in_radians(MODELS[name])
    changed = dataclasses.replace(by_degrees, **{angle: np.multiply(given[angle], 0.5).tolist()})
    np.testing.assert_allclose(getattr(changed, angle), 0.5 * np.asarray(getattr(by_degrees, angle)))
    for twice in (one for one in MODELS[name] if one.endswith("_deg")):
        with pytest.raises(sky.UsageError, match=r"^\w+ and \w+ are one angle: give one of them$"):
            CALLABLES[name](**{**MODELS[name], twice[:-4] + "_rad": 0.1})
    if name != "SkyLobe":  # whose angles are 0 by default
        needed = next(one for one in MODELS[name] if one.endswith("_deg"))
        with pytest.raises(sky.UsageError, match=f"^give {needed[:-4]}_(deg|rad) or {needed[:-4]}_(deg|rad)$"):
            CALLABLES[name](**{key: value for key, value in MODELS[name].items() if key != needed})


def test_functions_take_both_units():
    path = "inputs/atmosphere/clear_marine.atmo"
    degrees = {"sun_zenith_deg": 40, "sky_zenith_deg": [0, 60], "azimuth_from_sun_deg": [90]}
    how = {"wavelength_nm": 560, "method": "order1"}
    one, other = (sky.solve_atmosphere(path, **how, **angles) for angles in (degrees, in_radians(degrees)))
    np.testing.assert_allclose(other.radiance, one.radiance, rtol=1e-12)
    with pytest.raises(sky.UsageError, match="sun_zenith_deg and sun_zenith_rad are one angle"):
        sky.solve_atmosphere(path, **how, **degrees, sun_zenith_rad=0.7)


def test_multiples_of_90_degrees_are_exact():
    """Other angles are within 1 ulp: tests/conformance/test_stated_errors.py."""
    for degrees in (-360.0, -90.0, 0.0, 90.0, 180.0, 270.0, 360.0):
        radians = float(mpmath.mpf(degrees) * mpmath.pi / 180)
        assert given_angle("x_rad", None, degrees) == radians == math.radians(degrees)
        assert given_angle("x_deg", None, radians) == degrees


@pytest.mark.parametrize("unit", ["deg", "rad"])
@pytest.mark.parametrize("kind", [sky.PerezSky, sky.CIESky, sky.HarrisonCoombesSky, sky.DirectBeam])
def test_repr_has_angles_in_the_unit_in_which_they_were_given(kind, unit):
    more = {sky.PerezSky: {"dni": 850.0, "dhi": 95.0}, sky.CIESky: {"type": 12}}.get(kind, {})
    for zenith, azimuth in ((0.7, 1.1), (0.1, 0.3), (1.23, 0.0)) if unit == "rad" else ((40.0, 121.25), (32.4, 0.3)):
        model = kind(**{f"sun_zenith_{unit}": zenith, f"sun_azimuth_{unit}": azimuth}, **more)
        assert f"sun_zenith_{unit}={zenith}" in repr(model)
        assert not azimuth or f"sun_azimuth_{unit}={azimuth}" in repr(model)
        assert eval(repr(model), vars(sky)) == model


def test_repr_of_a_perez_sky_has_what_was_given():
    model = sky.PerezSky(sun_zenith_deg=40.0, dni=850.0, dhi=95.0)
    assert repr(model) == "PerezSky(sun_zenith_deg=40.0, sun_azimuth_deg=0.0, dni=850.0, dhi=95.0)"
