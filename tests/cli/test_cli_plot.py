"""``aomc-sky plot``: what it draws of each kind of path, where the file goes, and what it refuses."""

import json
import xml.etree.ElementTree as ET

import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS

pytest.importorskip("matplotlib")

SMALL = ["--size", "300"]


def drawn(told, *arguments):
    return json.loads(told("plot", *arguments, *SMALL, "--json").out)


def test_a_scene_before_its_run_and_a_sky_file(amc, tmp_path, told):
    found = drawn(told, amc)
    assert found["out"] == str(amc.with_name("amc.png"))
    assert (found["of"], found["quantity"]) == ("scene", "radiance / irradiance of the surface [sr-1]")
    assert found["domes"] == ["waveband 1, 555 nm", "waveband 2, 580 nm", "waveband 3, 640 nm"]
    data = amc.with_name("amc.png").read_bytes()
    assert data.startswith(b"\x89PNG")
    assert int.from_bytes(data[16:20], "big") == 300
    assert len(data) == found["bytes"]
    paper = ("--cmap", "gray", "--norm", "linear", "--scale", "each", "--no-caption")
    for words in ((), paper):
        drawn(told, amc, "--waveband", 1, "--out", tmp_path / "sky.svg", *words)
        assert ("Seen from" in (tmp_path / "sky.svg").read_text()) == (words == ())
    # the folder gives the same picture beside itself
    assert drawn(told, amc.parent)["out"] == str(amc.parent) + ".png"
    assert amc.parent.with_suffix(".png").read_bytes() == data
    found = drawn(told, amc, "--show", "counts", "--waveband", "3", "--waveband", "1", "--out", tmp_path / "sky.svg")
    assert found["quantity"] == "photons per steradian [sr-1]"
    assert found["domes"] == ["waveband 3, 640 nm", "waveband 1, 555 nm"]
    assert ET.parse(tmp_path / "sky.svg").getroot().tag.endswith("svg")
    found = drawn(told, amc.parent / "skydist.inp", "--waveband", "2")
    assert (found["of"], len(found["domes"])) == ("table", 1)


def test_a_background_sky_at_several_times_and_at_one(tmp_path, told):
    pytest.importorskip("h5py")
    night = INPUTS / "night_sky" / "night.h5"
    found = drawn(told, night, "--out", tmp_path / "n.png", "--frames", "2", "--animation", "city")
    assert found["domes"] == ["00:00 local time", "12:00 local time"]
    time = ["--time", "2026-02-14T21:30:00Z", "--wavelength", "450", "650", "--animation", "starlight"]
    assert drawn(told, night, *time, "--out", tmp_path / "s.png")["domes"] == ["450 nm", "650 nm"]


@pytest.mark.parametrize(("words", "against"), [((), "plan"), (("--method", "iid"), "masses")])
def test_a_run_and_its_pulls(words, against, amc, tmp_path, told):
    """Counts that were drawn are not compared with themselves: the map has colours, and the largest pull a size."""
    run = tmp_path / "out"
    told("run", amc, "--iterations", 40_000, "--out", run, "-q", *words)
    if not words:
        found = drawn(told, run, "--waveband", "2")
        assert (found["of"], found["quantity"]) == ("run", "photons per steradian [sr-1]")
        assert (found["out"], found["domes"]) == (f"{run}.png", ["waveband 2, 580 nm"])
    pull = drawn(told, run, "--pull")
    assert pull["out"] == f"{run}-pull.png"
    largest = pull["largest_pull"]
    off = (largest["observed"] - largest["expected"]) / largest["expected"] ** 0.5
    assert (largest["against"], largest["pull"]) == (against, pytest.approx(off, rel=1e-9))
    # the largest of some 500 pulls of the normal law lies outside 2 to 5.5 once in 1e5
    assert 2.0 < abs(largest["pull"]) < 5.5 if words else abs(largest["pull"]) < 0.5


def test_a_netcdf_file_has_its_codes(amc, tmp_path, told):
    pytest.importorskip("h5netcdf")
    pytest.importorskip("xarray")
    told("run", amc, "--format", "none", "--out", tmp_path / "out", "-q")
    told("export", tmp_path / "out", "--to", "netcdf", "--out", tmp_path / "run.nc", "-q")
    found = drawn(told, tmp_path / "run.nc")
    assert (len(found["domes"]), found["quantity"]) == (3, "photons per steradian [sr-1]")
    (tmp_path / "other.nc").write_bytes(b"no HDF5")
    for name, words, code in (
        ("run.nc", ("--waveband", 4), 2),
        ("other.nc", (), 3),
        ("absent.nc", (), 3),
        ("out", ("--pull",), 2),  # without photons it has none
        ("out", (), 0),
    ):
        told("plot", tmp_path / name, *words, *SMALL, code=code)


def test_a_table_of_an_atmosphere(tmp_path, told):
    pytest.importorskip("h5netcdf")
    model = INPUTS / "atmosphere" / "molecules_only.atmo"
    assert f"write aomc-sky atmosphere {model} --out sky.nc" in told("plot", model, code=2).err
    table = ("--out", tmp_path / "sky.nc", "--wavelength", 600, "--bins", 3, 4, "--orders", 1, "-q")
    told("atmosphere", model, *table)
    assert drawn(told, tmp_path / "sky.nc")["quantity"] == "radiance [W m-2 sr-1 nm-1]"
    turned = (tmp_path / "sky.nc", "--azimuth-convention", "clockwise from the sun")
    assert "write --sun-azimuth DEG" in told("plot", *turned, code=3).err
    assert drawn(told, *turned, "--sun-azimuth", 20)["domes"] == ["600 nm"]


def test_a_quantity_of_a_run(tmp_path, told):
    model = sky.PerezSky(sun_zenith_deg=60.0, epsilon=6.0, delta=0.1, polarisation=sky.RayleighPattern())
    run = tmp_path / "run"
    sky.write_run(sky.Scene(wavebands=[550.0], n_photons=100, components=model), run, seed=1)
    assert "degree of linear" in drawn(told, run, "--quantity", "dop")["quantity"]
    told("plot", run, "--quantity", "dop", "--pull", code=2)
