"""Records with arrays compare by content and never raise; their reprs are one line."""

import copy
import dataclasses
import re

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.emission.irradiance import Irradiance
from tests.support.shared import INPUTS

NOON = {"wavebands": [443.0, 555.0], "n_photons": 1000, "sun_zenith_deg": 40.0, "ghi": 780.0, "dhi": 140.0}


def records():
    scene = sky.weather_scene(**NOON)
    source, grid = scene.source(seed=1), sky.PatchGrid.regular(4, 8)
    table = sky.SkyTable(wavelength_nm=np.array([500.0]), radiance=np.ones((1, 3, 5)))
    return [scene, source.plan, source.photons(0), scene.components[1], scene.wavebands, grid, table]


MU = np.linspace(0.1, 1.0, 9)
AIR = {"earth_radius_m": 6.371e6, "top_m": 1e5, "constituents": (), "n_orders": 1, "sun_angular_radius_deg": 0.2665}
SPECTRA = {"wavelength_nm": [450.0, 550.0], "ground_albedo": [0.1, 0.2], "toa_irradiance": [1.9, 1.8]}


def models(factor=1.0):
    """Public records of sky models that hold arrays; the factor changes numbers of each."""
    town = sky.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=factor * np.array([1e-8, 2e-8]))
    file = sky.background_of_lobes({"town": town}, [450.0, 550.0])
    background = sky.BackgroundSky(animations=file.animations, wavelength_nm=file.wavelength_nm, curves=file.curves)
    table, zenith = factor * np.ones((2, 8)), np.degrees(np.arccos(MU))
    night = sky.background_at(background, 0.0)
    air = sky.Medium(**AIR, **{name: factor * np.array(row) for name, row in SPECTRA.items()})
    return {
        "SkyLobe": town,
        "BackgroundFile": file,
        "BackgroundSky": background,
        "LobeSky": night,
        "WeightedLobe": night.lobes[0],
        "TabulatedSky": sky.TabulatedSky(wavelength_nm=[450.0, 550.0], values=table, grid=sky.PatchGrid.regular(2, 4)),
        "RadianceField": sky.RadianceField.from_points(zenith, 43.75 * np.arange(9), factor * MU, wavelength_nm=550.0),
        "Medium": air,
        "AtmosphereSky": sky.AtmosphereSky(medium=air, sun_zenith_deg=30.0, grid=sky.PatchGrid.regular(3, 4)),
    }


@pytest.mark.parametrize("name", models())
def test_models_with_arrays_compare_and_have_short_reprs(name):
    one, other, changed = models()[name], models()[name], models(1.25)[name]
    assert one == other
    assert one != changed
    assert one != "another thing"
    assert repr(one).startswith(name + "(")
    assert len(repr(one)) < 300


def changed(record):
    if isinstance(record, sky.Plan):
        halves = [dataclasses.replace(c, mass=c.mass / 2) for c in record.components]
        return dataclasses.replace(record, components=halves)
    other = copy.copy(record)
    name = next(f.name for f in dataclasses.fields(record) if isinstance(getattr(record, f.name), np.ndarray))
    array = np.array(getattr(record, name))
    array.flat[0] += 1
    object.__setattr__(other, name, array)
    return other


@pytest.mark.parametrize("k", range(7))
def test_equal_records_are_equal_and_others_are_not(k):
    one, other = records()[k], records()[k]
    assert one == other
    assert one != changed(other)
    assert one != "another thing"
    assert one != records()[k - 1]


def test_records_and_arrays():
    scene = sky.weather_scene(**NOON)
    assert np.isnan(scene.sky_wavelength_nm).all()
    assert scene == sky.weather_scene(**NOON)
    reprs = " ".join(map(repr, records()[:4]))
    assert re.findall(r"<(\w+)[^>]*?(\d+) (?:photons|to|cells)", reprs) == [
        ("Scene", "2000"), ("Plan", "2000"), ("PhotonBatch", "0"), ("Component", "8100")
    ]  # fmt: skip
    batch = records()[2]
    for array in (np.zeros(4), np.zeros((1000, 9)), batch.ux):
        assert (batch == array) is False
        assert (array == batch) is False
        assert (batch != array) is True
    assert batch not in [np.zeros(3)]


def test_slices_and_arrays_of_a_batch():
    source = sky.weather_scene(**NOON).source(seed=1)
    batch = source.photons(0)
    part = batch[100:250]
    assert part == source.photons(0, 100, 250)
    assert batch[:-10].start == 0
    assert len(batch[:-10]) == 990
    assert np.shares_memory(part.ux, batch.ux)
    assert list(batch.to_dict()) == ["ux", "uy", "uz", "patch"]
    with pytest.raises(TypeError, match="slices"):
        batch[3]
    with pytest.raises(ValueError, match="follow each other"):
        batch[::2]


def test_what_readers_give_compares_and_is_short(tmp_path):
    atmosphere = INPUTS / "atmosphere" / "molecules_only.atmo"
    assert sky.read_atmo(atmosphere) == sky.read_atmo(atmosphere)
    assert sky.read_atmo(atmosphere) != sky.read_atmo(INPUTS / "atmosphere_sky" / "clear.atmo")
    assert len(repr(sky.read_atmo(atmosphere))) < 900
    assert Irradiance(of_component=np.ones((300, 2))) == Irradiance(of_component=np.ones((300, 2)))
    pytest.importorskip("mcpl")
    sky.write_mcpl(sky.weather_scene(**NOON).source(seed=1), tmp_path / "a.mcpl")
    one, other = (sky.read_mcpl(tmp_path / "a.mcpl").particles() for _ in range(2))
    assert one == other
    assert len(repr(one)) < 400


def test_positions_of_the_sun_compare():
    pytest.importorskip("pvlib")
    day = np.datetime64("2026-06-21T00:00") + np.arange(24) * np.timedelta64(1, "h")
    assert sky.sun_position(day, 43.0, 7.0) == sky.sun_position(day, 43.0, 7.0)
    assert sky.sun_position(day, 43.0, 7.0) != sky.sun_position(day, 44.0, 7.0)
