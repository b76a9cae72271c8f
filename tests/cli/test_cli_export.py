"""``export`` through main(argv): every format from a plan alone, and everything that can stand in its way."""

import json
import resource
import shutil

import numpy as np
import pytest

from aomc_sky import PhotonSource, Plan, read_scene, write_mcpl
from aomc_sky.files import read_mcpl
from tests.support.fault_rows import command
from tests.support.processes import start


@pytest.fixture
def out(amc, tmp_path):
    """A run without photons."""
    folder = tmp_path / "out"
    assert run(amc, "--out", folder) == 0
    return folder


def run(amc, *words):
    many = () if "--iterations" in words else ("--iterations", 20_000)
    return command("run", amc, *many, "--seed", 5, "--format", "none", "-q", *words)


def export(*words):
    return command("export", *words)


def names(folder):
    return {path.name for path in folder.iterdir()}


def source_of(folder):
    return PhotonSource.from_plan(Plan.load(folder / "plan.npz"))


def test_npy_is_what_run_writes(amc, tmp_path):
    options = ["--precision", "float64", "--weights", "--waveband", "2"]
    assert run(amc, *options, "--out", tmp_path / "out") == 0
    words = ("--iterations", 20_000, "--seed", 5, "-q", *options, "--out", tmp_path / "npy")
    assert command("run", amc, *words) == 0
    assert export(tmp_path / "out", "--to", "npy", "-q", "--threads", 3) == 0
    written = {name for name in names(tmp_path / "npy") if name.endswith(".npy")}
    assert names(tmp_path / "out-npy") == {*written, "plan.npz"}
    for name in written:
        assert (tmp_path / "out-npy" / name).read_bytes() == (tmp_path / "npy" / name).read_bytes()


def test_mcpl_is_what_write_mcpl_writes(out, tmp_path, told):
    write_mcpl(source_of(out), tmp_path / "wanted.mcpl")
    assert export(out, "--to", "mcpl") == 0
    assert (tmp_path / "out.mcpl").read_bytes() == (tmp_path / "wanted.mcpl").read_bytes()
    assert read_mcpl(tmp_path / "out.mcpl").header.n_particles == 60_000
    assert "nothing was done again" in told("export", out, "--to", "mcpl").out
    told("export", out, "--to", "mcpl", "--waveband", 1, code=5)
    shown = json.loads(told("export", out, "--to", "mcpl", "--waveband", 1, "--force", "--json").out)
    assert read_mcpl(tmp_path / "out.mcpl").header.n_particles == shown["photons"] == 20_000
    assert (shown["wavebands"], shown["out"]) == ([1], str(tmp_path / "out.mcpl"))
    assert shown["files"]["out.mcpl"]["bytes"] == (tmp_path / "out.mcpl").stat().st_size


def test_netcdf_holds_the_counts(out, tmp_path, told):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    path = tmp_path / "new" / "sky.nc"
    assert export(out, "--to", "netcdf", "--out", path) == 0
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert np.array_equal(data.counts.values.reshape(3, -1), source_of(out).counts)
    (tmp_path / "out.nc").write_text("mine")
    assert export(out, "--to", "netcdf") == 5
    assert (tmp_path / "out.nc").read_text() == "mine"
    assert export(out, "--to", "netcdf", "--force", "-q") == 0


def read_back(folder):
    return read_scene(folder, compat="aomc").source().counts


def test_aomc_launches_the_counts_of_a_run_on_degrees(amc, tmp_path, told):
    (amc.parent / "abs.inp").write_text("water")
    words = ("export", tmp_path / "far" / "away", "--to", "aomc", "--scene", amc)
    assert run(amc, "--bins", "degrees", "--out", words[1]) == 0
    (note,) = (line for line in told(*words).out.splitlines() if line.startswith("note"))
    assert note.endswith("the AOMC program also reads conc.inp, scat.inp, spf.inp from the folder of skydist.inp")
    made = tmp_path / "far" / "away-aomc"
    assert names(made) == {"plan.npz", "skydist.inp", "amc.inp", "lambbot.inp", "abs.inp", "counts.csv"}
    for name in ("conc.inp", "scat.inp", "spf.inp"):
        (amc.parent / name).write_text("water")
    assert "note" not in told(*words).out
    assert np.array_equal(read_back(made), source_of(made).counts)
    other = words[1].with_name("other")
    alone = told("export", words[1], "--to", "aomc", "--out", other).out
    assert "write 20000 in line 1 of amc.inp and 1 in line 2" in alone
    assert names(other) == {"plan.npz", "skydist.inp", "counts.csv"}


def test_aomc_never_touches_the_files_of_a_scene(amc, out, told):
    before = {path.name: path.read_bytes() for path in amc.parent.iterdir()}
    other = shutil.copytree(amc.parent, amc.parent.with_name("other"))
    for words in ((amc.parent, "--scene", amc, "--force"), (other,), (other, "--force")):
        told("export", out, "--to", "aomc", "--out", *words, code=2)
    for folder in (amc.parent, other):
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_file_that_was_cut_is_made_anew(out):
    """An unfinished run will do; files that are whole stay as they are."""
    (out / "manifest.json").unlink()
    made = out.with_name("out-csv")
    assert export(out, "--to", "csv", "-q") == 0
    whole, first = {path.name: path.read_bytes() for path in made.iterdir()}, (made / "photons-0001.csv").stat()
    (made / "photons-0002.csv").write_bytes(whole["photons-0002.csv"][:-1])
    (made / "photons-0003.csv").unlink()
    assert export(out, "--to", "csv", "-q") == 0
    assert {path.name: path.read_bytes() for path in made.iterdir()} == whole
    assert len(whole) == 4
    assert (made / "photons-0001.csv").stat().st_mtime_ns == first.st_mtime_ns


def test_other_files_in_the_run_leave_it_verified(out, told):
    pytest.importorskip("h5netcdf")
    for words in (["mcpl", "--out", out / "more.mcpl"], ["netcdf", "--out", out]):
        told("export", out, "--to", *words, "-q")
    told("verify", out, "-q")


def test_a_map_is_what_its_name_says(out, tmp_path, told):
    def words(name, *more):
        return ("export", out, "--to", "envmap", "--out", tmp_path / name, *more)

    begins = {"npy": b"\x93NUMPY", "hdr": b"#?RADIANCE\n", "exr": b"v/1\x01"}
    for ending, first in begins.items():
        path = tmp_path / f"sky.{ending}"
        assert command(*words(path, "--waveband", 2, "-q")) == 0
        assert path.read_bytes().startswith(first)
        assert json.loads(path.with_name(f"sky.{ending}.json").read_text())["wavelength_nm"] == [580.0]
    told(*words("sky.hdr", "--waveband", 1), code=5)
    assert command(*words("sky.hdr", "--waveband", 1, "--force", "-q")) == 0
    (tmp_path / "new.exr.json").write_text("of somebody")
    told(*words("new.exr"), code=5)
    assert not (tmp_path / "new.exr").exists()
    (tmp_path / "v1.2").mkdir()
    assert command(*words("v1.2", "-q")) == 0
    assert names(tmp_path / "v1.2") == {"envmap.npy", "envmap.json", "plan.npz"}


@pytest.mark.parametrize("to", ["npy", "netcdf"])
def test_a_full_disk_leaves_nothing_half(out, tmp_path, to):
    if to == "netcdf":
        pytest.importorskip("h5netcdf")
    limit = {"npy": 200_000, "netcdf": 2000}[to]
    process = start(
        *("export", out, "--to", to, "--out", tmp_path / "made"),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    _, err = process.communicate(timeout=60)
    assert process.returncode == 6, err
    assert err.startswith(b"aomc-sky: error: cannot write")
    assert names(tmp_path / "made") <= {"plan.npz"}
