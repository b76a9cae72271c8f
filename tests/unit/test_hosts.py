"""Programs in C and Fortran get the photons of Python to the bit, and say what is wrong."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import embed_flags, include_dir
from aomc_sky.cli.main import main
from aomc_sky.errors import AomcSkyError
from tests.support.fortran import needs_gfortran
from tests.support.host_programs import EXAMPLES, compile_c, make, needs_host, run
from tests.support.shared import INPUTS

SCENES = [
    ("clear_day", "iterations=200000"),
    pytest.param("perez_sky", "iterations=30000", marks=pytest.mark.slow),
    ("document_example", "compat=aomc"),
    pytest.param("perez_sky", "iterations=30000 placement=philox", marks=pytest.mark.slow),
    pytest.param("sparse_sky", "order=patch", marks=pytest.mark.slow),
    pytest.param("sun_and_sky", "iterations=30000 sky=uniform", marks=pytest.mark.slow),
    pytest.param("overcast", "iterations=30000 method=iid", marks=pytest.mark.slow),
]


@pytest.fixture(scope="module")
def c_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hosts") / "c"
    shutil.copytree(EXAMPLES / "c", folder, ignore=shutil.ignore_patterns("sky_means"))
    make(folder)
    return folder


@pytest.fixture(scope="module")
def fortran_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hosts") / "fortran"
    shutil.copytree(EXAMPLES / "fortran", folder, ignore=shutil.ignore_patterns("sky_means", "*.o", "*.mod"))
    make(folder, "sky_means")
    return folder


@pytest.fixture(scope="module")
def checks(tmp_path_factory):
    """What host_checks prints: lines by their name, and its photons."""
    folder = tmp_path_factory.mktemp("checks")
    run_folder = folder / "run"
    assert (
        main(["run", str(INPUTS / "clear_day"), "--seed", "5", "--iterations", "2000", "--out", str(run_folder), "-q"])
        == 0
    )
    text = run([str(compile_c("host_checks", folder)), str(INPUTS / "clear_day"), str(run_folder)], folder)
    texts = dict(line.split(": ", 1) for line in text.splitlines() if ": " in line)
    numbers = {
        n: int(v)
        for n, v in (line.rsplit(" ", 1) for line in text.splitlines() if line.split()[-1].lstrip("-").isdigit())
    }
    photons = [line.split()[1:] for line in text.splitlines() if line.startswith("photon ")]
    return texts, numbers, photons


def source_of(name, options, seed):
    """The source that the words of a host mean."""
    words = dict(word.split("=") for word in options.split())
    reading = {k: int(v) if k == "iterations" else v for k, v in words.items() if k in ("iterations", "sky", "compat")}
    sampling = {k: v for k, v in words.items() if k not in reading}
    return sky.read_scene(INPUTS / name, **reading).source(seed, **sampling)


def all_bytes(source):
    bands = (source.photons(band) for band in range(source.n_bands))
    return b"".join(np.stack([batch.ux, batch.uy, batch.uz]).tobytes() for batch in bands)


@needs_host
@pytest.mark.parametrize(("name", "options"), SCENES)
def test_c_gets_the_same_bits(c_folder, name, options):
    wanted = all_bytes(source_of(name, options, 11))
    threads = {"clear_day": "3", "perez_sky": "1"}.get(name, "2")
    output = run(["./sky_means", str(INPUTS / name), "11", options, "out.bin"], c_folder, OMP_NUM_THREADS=threads)
    assert (c_folder / "out.bin").read_bytes() == wanted
    assert len(output.splitlines()) == 1 + source_of(name, options, 11).n_bands


@needs_host
@needs_gfortran
@pytest.mark.parametrize(
    ("name", "options"), [("sparse_sky", "order=patch"), ("overcast", "iterations=30000 precision=float64")]
)
def test_fortran_gets_the_same_bits(fortran_folder, name, options):
    command = ["./sky_means", str(INPUTS / name), "11", options, "out.bin"]
    run(command, fortran_folder, OMP_NUM_THREADS="2")
    assert (fortran_folder / "out.bin").read_bytes() == all_bytes(source_of(name, options, 11))


@needs_host
def test_errors_have_a_text(checks):
    texts, numbers, _ = checks
    assert numbers["missing"] == numbers["option"] == numbers["null path"] == numbers["no plan"] == -1
    assert "no such file" in texts["missing text"]
    assert numbers["missing scene is NULL"] == 1
    assert texts["option text"] == "unknown option 'presision'; did you mean 'precision'?"
    assert texts["null path text"] == "aomc_sky_open: a pointer is NULL"
    assert (numbers["bands of none"], numbers["bands"]) == (0, 3)
    assert numbers["band -1"] == numbers["band beyond"] == -1
    assert texts["band -1 text"] == "band -1 does not exist; bands run from 0 to 2"
    assert numbers["next of no band is NULL"] == 1


@needs_host
def test_ends_and_wrong_calls(checks):
    _, numbers, _ = checks
    zero = (
        "open",
        "band 0",
        "none wanted",
        "none wanted, no array",
        "at the end",
        "beyond",
        "second open",
        "wide",
        "run",
    )
    assert [numbers[name] for name in zero] == [0] * len(zero)
    assert [numbers[name] for name in ("photons", "nm", "eight", "last", "eight wide")] == [1000, 440, 8, 3, 8]
    yes = ("error is empty", "double is NULL", "single is NULL", "the rest is untouched")
    assert [numbers[name] for name in yes] == [1] * len(yes)
    assert [numbers[name] for name in ("closed", "no context", "bad start", "bad count", "no array")] == [
        -1,
        -1,
        -2,
        -3,
        -4,
    ]
    assert numbers["other scene is open"] == 8


@needs_host
def test_a_run_folder_gives_its_photons(checks):
    _, numbers, photons = checks
    assert (numbers["run"], numbers["run band"], numbers["run photons"], numbers["run eight"]) == (0, 0, 2000, 8)
    batch = sky.read_scene(INPUTS / "clear_day", iterations=2000).source(5).photons(0, 0, 8)
    wanted = [[f"{word:08x}" for word in row] for row in batch.directions.view(np.uint32)]
    assert photons == wanted


@needs_host
def test_header_is_c_plus_plus_too(tmp_path):
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed")
    (tmp_path / "use.cpp").write_text('#include "aomc_sky_embed.h"\nint main() { return aomc_sky_bands(0) != 0; }\n')
    command = ["g++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{include_dir()}", "-c", "use.cpp"]
    assert run(command, tmp_path) == ""


@needs_host
def test_wrong_commands_of_the_examples(c_folder):
    for arguments, said in (
        (["nowhere", "1"], "no such file"),
        ([], "usage"),
        ([str(INPUTS / "clear_day"), "1", "order=up"], "'patch'"),
        ([str(INPUTS / "clear_day"), "1e3"], "SEED is no whole number"),
        ([str(INPUTS / "clear_day"), "-1"], "SEED is no whole number"),
    ):
        done = subprocess.run(["./sky_means", *arguments], cwd=c_folder, capture_output=True, text=True, check=False)
        assert done.returncode != 0
        assert said in done.stderr
        assert "Traceback" not in done.stderr


@needs_host
def test_which_python_is_started(c_folder):
    """The environment names another one; what is not there is said."""
    command = ["./sky_means", str(INPUTS / "clear_day"), "1", "iterations=10"]
    environment = {**os.environ, "AOMC_SKY_PYTHON": "/no/such/python3"}
    done = subprocess.run(command, cwd=c_folder, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, "there is no Python /no/such/python3" in done.stderr) == (1, True)
    environment = {**os.environ, "AOMC_SKY_PYTHON": f"{sys.base_prefix}/bin/python3", "PYTHONPATH": ""}
    done = subprocess.run(command, cwd=c_folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 or "set AOMC_SKY_PYTHON to the Python that has aomc-sky" in done.stderr


def test_info_prints_the_folder(capsys):
    assert main(["info", "--include-dir"]) == 0
    assert capsys.readouterr().out.strip() == str(include_dir())
    assert all(
        (include_dir() / name).is_file() for name in ("aomc_sky_embed.h", "aomc_sky_embed.f90", "aomc_sky_embed.c")
    )
    assert main(["info"]) == 2
    assert main(["info", "--include-dir", "somewhere"]) == 2


def test_missing_headers_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr("aomc_sky.cli.commands.info.sysconfig.get_paths", lambda: {"include": str(tmp_path)})
    with pytest.raises(AomcSkyError, match="python3-dev"):
        embed_flags()


def test_missing_library_is_named(monkeypatch):
    monkeypatch.setattr("aomc_sky.cli.commands.info.Path.exists", lambda path: path.name == "Python.h")
    with pytest.raises(AomcSkyError, match="libpython"):
        embed_flags()


def test_static_library_where_there_is_no_shared_one(monkeypatch):
    monkeypatch.setattr("aomc_sky.cli.commands.info.Path.exists", lambda path: path.suffix in (".h", ".a"))
    flags = embed_flags()
    assert "-no-pie" in flags
    assert "-Wl,--export-dynamic" in flags
    assert any(flag.endswith(".a") for flag in flags)
