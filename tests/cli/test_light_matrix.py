"""Any sky with its sun, from any entrance: it has the beam, or one sentence says why not."""

import shutil
from typing import Any

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.formats.sky_models import OUR_NAMES, SKY_MODELS
from tests.support.fault_rows import command
from tests.support.fields import field_of
from tests.support.plugins import lay_package
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

SUN = ["--sun-zenith", "40", "--sun-azimuth", "60"]
LIGHT = ["--ghi", "780", "--dhi", "140"]
FLAT = ["--spectrum", "flat"]
KEYWORDS: dict[str, Any] = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 60.0, "ghi": 780.0, "dhi": 140.0}
TOML = '[perez]\nghi = 780\ndhi = 140\nspectrum = "flat"\n[sun]\nzenith_deg = 40\nazimuth_deg = 60\n'
FRACTION = 1 - 140 / 780
NM = ["400", "450", "550", "650"]
"""The wavebands of inputs/perez_sky."""
NAMED = ("perez", "uniform", *sorted({*SKY_MODELS} - {*OUR_NAMES, "cardioidal"}), "plugin")  # which is overcast
FILES = {"csv": "sky.csv", "field": "field.nc"}
SKIES = (*NAMED, "function", *FILES, "atmosphere")
NO_FILE = "is a file, not the name of a sky"
NO_FUNCTION = "there is no sky model 'sky.py'"
REFUSED = {
    ("function", "options"): NO_FUNCTION, ("function", "alone"): NO_FUNCTION, ("function", "toml"): NO_FUNCTION,
    ("csv", "options"): NO_FILE, ("field", "options"): NO_FILE, ("atmosphere", "options"): NO_FILE,
    ("atmosphere", "alone"): NO_FILE, ("atmosphere", "python"): "AtmosphereSky has a beam of its own",
}  # fmt: skip
"""Sky and entrance -> the sentence."""


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder with a scene without sky.toml and difcol.inp, a measured sky, a field, an atmosphere and a plug-in."""
    monkeypatch.chdir(tmp_path)
    amc = copy_scene("perez_sky", tmp_path)
    for name in ("sky.toml", "difcol.inp"):
        (amc.parent / name).unlink()
    directions = [(z, a) for z in (0, 20, 40, 60, 80, 88) for a in range(0, 360, 30)]
    rows = [",".join(f"{x:.4f}" for x in (z, a, *[1 + np.cos(np.radians(z))] * len(NM))) for z, a in directions]
    head = ",".join(["zenith_deg", "azimuth_deg", *(f"L_{nm}" for nm in NM)])
    table = "\n".join(["# azimuth: counterclockwise from east", head, *rows, ""])
    for folder in (tmp_path, amc.parent):
        (folder / "sky.csv").write_text(table)
    code = "def make(*, sun_zenith_rad, sun_azimuth_rad):\n    return lambda z, a, nm: 1.0 + 0.0 * z\n"
    site = lay_package(tmp_path / "site", "example_skies", code, name="plugin", distribution="example-skies")
    monkeypatch.syspath_prepend(site)
    return amc.parent


def write_field(folder):
    zenith, azimuth = np.arange(5.0, 90.0, 10.0), np.arange(15.0, 360.0, 30.0)
    field = field_of(5 * (1 + np.cos(np.radians(zenith)))[:, None] * np.ones((1, azimuth.size)), zenith, azimuth)
    field.attrs["units"] = "10 mW m-2 nm-1 sr-1"
    for target in (folder, folder.parent):
        field.to_netcdf(target / "field.nc", engine="h5netcdf")


def run(files, *words):
    assert command("run", *words, "--iterations", 1000, "--out", files.parent / "out", "-q") == 0


def named(name):
    """Options that name a sky, as somebody would write them who takes a file for a name."""
    word = {"function": "sky.py", "atmosphere": "clear.atmo", **FILES}.get(name, name)
    return ["--sky", word, *(["--sky-option", "type=12"] if name == "cie" else [])]


def by_options(name, files):
    run(files, files, *SUN, *LIGHT, *FLAT, *named(name))


def alone(name, files):
    words = [FILES[name]] if name in FILES else named(name)
    run(files, *words, *SUN, *LIGHT, *(FLAT if name != "field" else []), "--wavelengths", *NM)


def by_toml(name, files):
    if name == "atmosphere":
        for file in ("clear.atmo", "lambbot.inp"):  # its wavelengths, 410 to 680 nm
            shutil.copy(INPUTS / "atmosphere_sky" / file, files)
        solver = 'method = "order1"\nzenith_bins = 4\nazimuth_bins = 8'
        sun = "zenith_deg = 40\nazimuth_deg = 60\ndisc = false"
        text = f'[atmosphere]\nfile = "clear.atmo"\n{solver}\n[sun]\n{sun}\n'
    elif name in FILES:
        text = f'{TOML}[sky]\ntable = "{FILES[name]}"\n'
        if name == "field":
            text = text.replace('spectrum = "flat"\n', "")
    else:
        text = f'{TOML}[sky]\nmodel = "{named(name)[1]}"\n' + ("type = 12\n" if name == "cie" else "")
    (files / "sky.toml").write_text(text)
    run(files, files)


def in_python(name, files):
    how: dict[str, Any] = {"sky": name, "sky_options": {"type": 12} if name == "cie" else None}
    if name == "function":
        how = {"sky": lambda zenith, azimuth, nm: 1.0 + 0.0 * zenith}
    elif name == "csv":
        how = {"sky": sky.read_radiance_csv("sky.csv")}
    elif name == "field":
        xarray = pytest.importorskip("xarray")
        how = {"sky": sky.TabulatedSky.from_xarray(xarray.open_dataarray("field.nc"))}
    elif name == "atmosphere":
        medium = sky.atmosphere.Medium(
            earth_radius_m=6.371e6, top_m=1e5, wavelength_nm=np.array(list(map(float, NM))), constituents=(),
            ground_albedo=np.zeros(4), toa_irradiance=np.ones(4), n_orders=1, sun_angular_radius_deg=0.2665,
        )  # fmt: skip
        how = {"sky": sky.AtmosphereSky(medium=medium, sun_zenith_deg=40.0, sun_azimuth_deg=60.0)}
    scene = sky.weather_scene(wavebands=list(map(float, NM)), n_photons=1000, **KEYWORDS, **how)
    sky.write_run(scene, files.parent / "out")


ENTRANCES = {"options": by_options, "alone": alone, "toml": by_toml, "python": in_python}


def shares_of_field():
    """Of the beam of dni times its spectrum beside 0.05 (1 + cos Z) W m-2 nm-1 sr-1, which keeps its light."""
    light = {"wavebands": list(map(float, NM)), **KEYWORDS, "spectrum": "spectrl2", "sky": "uniform"}
    beam = sky.weather_scene(**light).irradiance.of_component[:, 0]
    return beam / (beam + 0.05 * np.pi * 5 / 3)


@pytest.mark.parametrize("entrance", ENTRANCES)
@pytest.mark.parametrize("name", SKIES)
def test_every_sky_has_its_sun_or_says_why_not(name, entrance, files, capsys):
    expected = FRACTION
    if name == "field":
        write_field(files)
        pytest.importorskip("pvlib")
        expected = shares_of_field()  # in absolute units
    if (name, entrance) in REFUSED:
        with pytest.raises((sky.UsageError, sky.InputFileError, AssertionError)) as caught:
            ENTRANCES[entrance](name, files)
        said = f"{caught.value}\n{capsys.readouterr().err}"
        assert REFUSED[name, entrance] in said
        assert "Traceback" not in said
        return
    ENTRANCES[entrance](name, files)
    zenith, azimuth = np.radians([40, 60])
    sun = np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)])
    photons = [np.load(path)[:, :3] for path in sorted((files.parent / "out").glob("photons-*.npy"))]
    shares = np.array([np.mean(one @ -sun > 1 - 1e-6) for one in photons])
    assert len(shares) == len(NM)
    if name == "atmosphere":
        assert np.all((shares > 0.2) & (shares < 0.95))
    else:
        assert np.all(np.abs(shares - expected) <= 1.001e-3), (shares, expected)
