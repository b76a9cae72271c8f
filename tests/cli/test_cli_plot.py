"""``aomc-sky plot``: what it draws of each kind of path, where the file goes, and what it refuses."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.shared import INPUTS

pytest.importorskip("matplotlib")

SMALL = ["--size", "300"]


@pytest.fixture
def run(amc, tmp_path):
    assert main(["run", str(amc), "--out", str(tmp_path / "out"), "-q"]) == 0
    return tmp_path / "out"


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
    # the folder gives the same picture beside itself
    assert drawn(told, amc.parent)["out"] == str(amc.parent) + ".png"
    assert amc.parent.with_suffix(".png").read_bytes() == data
    found = drawn(told, amc, "--show", "counts", "--waveband", "3", "--waveband", "1", "--out", tmp_path / "sky.svg")
    assert found["quantity"] == "photons per steradian [sr-1]"
    assert found["domes"] == ["waveband 3, 640 nm", "waveband 1, 555 nm"]
    assert ET.parse(tmp_path / "sky.svg").getroot().tag.endswith("svg")
    found = drawn(told, amc.parent / "skydist.inp", "--waveband", "2")
    assert (found["of"], len(found["domes"])) == ("table", 1)


def test_a_picture_for_a_paper_has_its_own_colours_and_no_sentences(amc, tmp_path):
    words = ["--cmap", "gray", "--norm", "linear", "--scale", "each", "--no-caption", "--title", ""]
    assert main(["plot", str(amc), "--out", str(tmp_path / "p.svg"), *words, *SMALL, "-q"]) == 0
    assert main(["plot", str(amc), "--out", str(tmp_path / "q.svg"), *SMALL, "-q"]) == 0
    paper, usual = ((tmp_path / name).read_text() for name in ("p.svg", "q.svg"))
    assert "Seen from" in usual
    assert "Seen from" not in paper


def test_a_run_and_its_pulls(run, told):
    found = drawn(told, run)
    assert (found["of"], found["quantity"]) == ("run", "photons per steradian [sr-1]")
    assert found["out"] == f"{run}.png"
    pull = drawn(told, run, "--pull", "--waveband", "2")
    assert pull["out"] == f"{run}-pull.png"
    assert pull["quantity"].startswith("pull")
    assert pull["domes"] == ["waveband 2, 580 nm"]
    assert sorted(path.name for path in run.parent.glob("*.png")) == ["out-pull.png", "out.png"]


@pytest.mark.parametrize(("words", "against"), [((), "plan"), (("--method", "iid"), "masses")])
def test_pulls_of_drawn_counts_are_against_the_masses(words, against, amc, tmp_path, told):
    """Counts that were drawn are not compared with themselves: the map has colours, and the largest pull a size."""
    out = tmp_path / "pulled"
    assert main(["run", str(amc), "--iterations", "40000", "--out", str(out), "-q", *words]) == 0
    pull = drawn(told, out, "--pull")
    largest = pull["largest_pull"]
    off = (largest["observed"] - largest["expected"]) / largest["expected"] ** 0.5
    assert (largest["against"], largest["pull"]) == (against, pytest.approx(off, rel=1e-9))
    # the largest of some 500 pulls of the normal law lies outside 2 to 5.5 once in 1e5
    assert 2.0 < abs(largest["pull"]) < 5.5 if words else abs(largest["pull"]) < 0.5
    text = told("plot", out, "--pull", *SMALL).out
    assert f"largest pull: waveband {largest['waveband']}, against {against}, zenith_deg " in text
    assert f"pull {largest['pull']:.6g}" in text


def test_a_netcdf_file(run, tmp_path, told):
    pytest.importorskip("h5netcdf")
    pytest.importorskip("xarray")
    told("export", run, "--to", "netcdf", "--out", tmp_path / "run.nc", "-q")
    found = drawn(told, tmp_path / "run.nc")
    assert found["domes"] == ["waveband 1, 555 nm", "waveband 2, 580 nm", "waveband 3, 640 nm"]
    assert found["quantity"] == "photons per steradian [sr-1]"
    (tmp_path / "other.nc").write_bytes(b"no HDF5")
    for name, words, code in (("run.nc", ("--waveband", 4), 2), ("other.nc", (), 3), ("absent.nc", (), 3)):
        told("plot", tmp_path / name, *words, code=code)


def test_a_background_sky_at_several_times_and_at_one(tmp_path, told):
    pytest.importorskip("h5py")
    night = INPUTS / "night_sky" / "night.h5"
    found = drawn(told, night, "--out", tmp_path / "n.png", "--frames", "2", "--animation", "city")
    assert found["domes"] == ["00:00 local time", "12:00 local time"]
    time = ["--time", "2026-02-14T21:30:00Z", "--wavelength", "450", "650", "--animation", "starlight"]
    assert drawn(told, night, *time, "--out", tmp_path / "s.png")["domes"] == ["450 nm", "650 nm"]


def test_an_atmosphere_is_solved_by_its_command(tmp_path, told):
    pytest.importorskip("h5netcdf")
    model = str(INPUTS / "atmosphere" / "molecules_only.atmo")
    assert f"write aomc-sky atmosphere {model} --out sky.nc" in told("plot", model, code=2).err
    solved = ["--out", str(tmp_path / "sky.nc"), "--wavelength", "600", "--bins", "3", "4", "--orders", "1", "-q"]
    assert main(["atmosphere", model, *solved]) == 0
    found = drawn(told, tmp_path / "sky.nc")
    assert (len(found["domes"]), found["quantity"]) == (1, "radiance [W m-2 sr-1 nm-1]")
    turned = (tmp_path / "sky.nc", "--azimuth-convention", "clockwise from the sun")
    assert "write --sun-azimuth DEG" in told("plot", *turned, code=3).err
    assert drawn(told, *turned, "--sun-azimuth", 20)["domes"] == ["600 nm"]


def test_more_bands_than_a_picture_holds_are_told(tmp_path, told):
    table = sky.TabulatedSky(
        wavelength_nm=[500.0], values=np.ones((1, 6)), grid=sky.PatchGrid.regular(2, 3), has_wavelength=False
    )
    bands = sky.Wavebands(wavelength_nm=np.linspace(400.0, 700.0, 30))
    scene = sky.Scene(wavebands=bands, n_photons=100, components=(table,))
    scene.source(0).plan.save(tmp_path / "plan.npz")
    out = told("plot", tmp_path, "--out", tmp_path / "p.png", *SMALL).out
    assert "12 domes" in out
    assert "30 wavebands, 12 spread over them are drawn; choose with --waveband I" in out


def test_a_run_without_photons_has_no_pulls(amc, tmp_path, told):
    assert main(["run", str(amc), "--out", str(tmp_path / "out"), "--format", "none", "-q"]) == 0
    assert "--format npy" in told("plot", tmp_path / "out", "--pull", code=2).err
    assert main(["plot", str(tmp_path / "out"), *SMALL, "-q"]) == 0


def test_polarisation_of_a_run(tmp_path, told):
    """`--quantity` draws a run whose light is polarised; a picture has one quantity."""
    model = sky.PerezSky(sun_zenith_deg=60.0, epsilon=6.0, delta=0.1, polarisation=sky.RayleighPattern())
    run = tmp_path / "run"
    sky.write_run(sky.Scene(wavebands=[550.0], n_photons=100, components=model), run, seed=1)
    for quantity, words in (("dop", "degree of linear"), ("aop", "angle of")):
        assert words in told("plot", run, "--quantity", quantity, "--out", tmp_path / f"{quantity}.svg").out
    assert "--pull and --quantity are 2 pictures" in told("plot", run, "--quantity", "dop", "--pull", code=2).err
