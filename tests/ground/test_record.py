"""Records with arrays compare by content and never raise; their reprs are one line."""

import dataclasses
import functools
import re

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.emission.irradiance import Irradiance
from tests.support.shared import INPUTS

NOON = {"wavebands": [443.0, 555.0], "n_photons": 1000, "sun_zenith_deg": 40.0, "ghi": 780.0, "dhi": 140.0}


@functools.cache
def source():
    return sky.weather_scene(**NOON).source(seed=1)


MU = np.linspace(0.1, 1.0, 9)
AIR = {"earth_radius_m": 6.371e6, "top_m": 1e5, "constituents": (), "n_orders": 1, "sun_angular_radius_deg": 0.2665}
SPECTRA = {"wavelength_nm": [450.0, 550.0], "ground_albedo": [0.1, 0.2], "toa_irradiance": [1.9, 1.8]}


def lobe(factor):
    return sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=factor * np.array([1e-8, 2e-8]))


def background(factor):
    file = sky.lobes.background_of_lobes({"town": lobe(factor)}, [450.0, 550.0])
    return sky.lobes.BackgroundSky(animations=file.animations, wavelength_nm=file.wavelength_nm, curves=file.curves)


def medium(factor):
    return sky.atmosphere.Medium(**AIR, **{name: factor * np.array(row) for name, row in SPECTRA.items()})


def plan(factor):
    components = [dataclasses.replace(one, mass=factor * one.mass) for one in source().plan.components]
    return dataclasses.replace(source().plan, components=components)


def field(factor):
    return sky.RadianceField.from_points(
        np.degrees(np.arccos(MU)), 43.75 * np.arange(9), factor * MU, wavelength_nm=550
    )


FOUR = sky.PatchGrid.regular(2, 4)
RECORDS = {
    "Scene": lambda f: sky.weather_scene(**NOON | {"ghi": 780 * f}), "Plan": plan, "SkyLobe": lobe, "Medium": medium,
    "PhotonBatch": lambda f: dataclasses.replace(source().photons(0), ux=np.float32(f) * source().photons(0).ux),
    "Component": lambda f: plan(f).components[1], "Wavebands": lambda f: sky.Wavebands([443.0 * f, 555.0 * f]),
    "PatchGrid": lambda f: sky.PatchGrid.regular(4, int(8 * f)), "BackgroundSky": background, "RadianceField": field,
    "SkyTable": lambda f: sky.files.SkyTable(wavelength_nm=np.array([500.0]), radiance=f * np.ones((1, 3, 5))),
    "BackgroundFile": lambda f: sky.lobes.background_of_lobes({"town": lobe(f)}, [450.0, 550.0]),
    "LobeSky": lambda f: sky.background_at(background(f), 0.0),
    "WeightedLobe": lambda f: sky.background_at(background(f), 0.0).lobes[0],
    "TabulatedSky": lambda f: sky.TabulatedSky(wavelength_nm=[450.0, 550.0], values=f * np.ones((2, 8)), grid=FOUR),
    "AtmosphereSky": lambda f: sky.AtmosphereSky(medium=medium(f), sun_zenith_deg=30.0, grid=FOUR),
}  # fmt: skip
"""Public records that hold arrays, by a factor that changes numbers of each."""


@pytest.mark.parametrize("name", RECORDS)
def test_equal_records_are_equal_others_are_not_and_reprs_are_short(name):
    one, other, changed = (RECORDS[name](factor) for factor in (1.0, 1.0, 1.25))
    assert one == other
    assert one != changed
    assert one != "another thing"
    assert one != RECORDS["Scene" if name != "Scene" else "Plan"](1.0)
    assert repr(one).startswith((f"{name}(", f"<{name}"))
    assert len(repr(one)) < 300


def test_records_and_arrays():
    scene = sky.weather_scene(**NOON)
    assert np.isnan(scene.sky_wavelength_nm).all()
    assert scene == sky.weather_scene(**NOON)
    reprs = " ".join(repr(RECORDS[name](1.0)) for name in ("Scene", "Plan", "PhotonBatch", "Component"))
    assert re.findall(r"<(\w+)[^>]*?(\d+) (?:photons|to|cells)", reprs) == [
        ("Scene", "2000"), ("Plan", "2000"), ("PhotonBatch", "0"), ("Component", "8100")
    ]  # fmt: skip
    batch = source().photons(0)
    for array in (np.zeros(4), np.zeros((1000, 9)), batch.ux):
        assert (batch == array) is False
        assert (array == batch) is False
        assert (batch != array) is True
    assert batch not in [np.zeros(3)]


def test_slices_and_arrays_of_a_batch():
    batch = source().photons(0)
    part = batch[100:250]
    assert part == source().photons(0, 100, 250)
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
    assert sky.atmosphere.read_atmo(atmosphere) == sky.atmosphere.read_atmo(atmosphere)
    assert sky.atmosphere.read_atmo(atmosphere) != sky.atmosphere.read_atmo(INPUTS / "atmosphere_sky" / "clear.atmo")
    assert len(repr(sky.atmosphere.read_atmo(atmosphere))) < 900
    assert Irradiance(of_component=np.ones((300, 2))) == Irradiance(of_component=np.ones((300, 2)))
    pytest.importorskip("mcpl")
    sky.write_mcpl(source(), tmp_path / "a.mcpl")
    one, other = (sky.files.read_mcpl(tmp_path / "a.mcpl").particles() for _ in range(2))
    assert one == other
    assert len(repr(one)) < 400


def test_positions_of_the_sun_compare():
    pytest.importorskip("pvlib")
    day = np.datetime64("2026-06-21T00:00") + np.arange(24) * np.timedelta64(1, "h")
    assert sky.sun_position(day, 43.0, 7.0) == sky.sun_position(day, 43.0, 7.0)
    assert sky.sun_position(day, 43.0, 7.0) != sky.sun_position(day, 44.0, 7.0)
