"""Programs in C, C++, Fortran and CUDA that take photons from a source file: they are short, and the bits are ours."""

import re
import subprocess

import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from tests.support.builds import apart
from tests.support.host_programs import EXAMPLES, FLAGS, MPI, QUICK, copied, make, needs, needs_host, report_of, run
from tests.support.shared import INPUTS

SCENES = {
    "clear_day": {"iterations": 200_000},
    "perez_sky": {"iterations": 30_000, "placement": "philox"},
    "sparse_sky": {"order": "patch"},
    "document_example": {"compat": "aomc"},
    "overcast": {"iterations": 30_000, "method": "iid"},
}
PROGRAMS = ["c/sky_means.c", "c/sky_openmp.c", "c/sky_mpi.c", "c/sky_threads.cpp", "cuda/sky_means.cu"]
PROGRAMS += ["fortran/sky_means.f90", "fortran/aomc_light.f90"]


def source_of(name, **sampling):
    words = SCENES[name] | sampling
    reading = {key: words.pop(key) for key in ("iterations", "compat") if key in words}
    return sky.read_scene(INPUTS / name, **reading).source(11, **words)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The C programs, built, and the files of all scenes."""
    folder = copied("c", tmp_path_factory.mktemp("hosts"))
    for name in SCENES:
        sky.write_source(source_of(name), folder / f"{name}.sky")
    make(folder, "sky_means")
    return folder


@pytest.fixture(scope="module")
def fortran_folder(tmp_path_factory):
    folder = copied("fortran", tmp_path_factory.mktemp("hosts"))
    make(folder, "sky_means", flags=QUICK)
    return folder


def test_every_example_is_short():
    lines = {program: len((EXAMPLES / program).read_text().splitlines()) for program in (*PROGRAMS, "c/ocean.c")}
    assert lines.pop("c/ocean.c") <= 250
    assert max(lines.values()) <= 60


def refused(command, folder, code=1):
    """What a program says that ends with an error and prints nothing."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (code, "")
    return done.stderr


@needs_host
@pytest.mark.parametrize("name", SCENES)
def test_c_gets_the_same_bits(folder, name):
    assert run(["./sky_means", f"{name}.sky"], folder) == report_of(source_of(name))


@needs_host
@pytest.mark.parametrize(
    ("program", "start", "words"),
    [
        ("sky_openmp", [], []),
        pytest.param("sky_threads", [], ["{}"], marks=needs("g++")),
        pytest.param("sky_mpi", ["mpirun", "-n", "{}"], [], marks=needs("mpicc", "mpirun")),
    ],
)
def test_threads_and_ranks_get_the_same_bits(folder, program, start, words):
    make(folder, program, flags=apart(FLAGS))
    for n in ("1", "3"):
        command = [word.format(n) for word in (*start, f"./{program}", "clear_day.sky", *words)]
        assert run(command, folder, OMP_NUM_THREADS=n, **MPI) == report_of(source_of("clear_day"))


@needs_host
def test_what_is_wrong_is_said(folder):
    good = (folder / "overcast.sky").read_bytes()
    (folder / "cut.sky").write_bytes(good[:-64])
    (folder / "changed.sky").write_bytes(good[:5000] + bytes([good[5000] ^ 1]) + good[5001:])
    (folder / "wide.sky").write_bytes(source_of("overcast", precision="float64").to_bytes())
    said = {"nowhere": "cannot be read", "cut": "cut off", "changed": "damaged", "wide": "the other precision"}
    for name, says in said.items():
        assert says in refused(["./sky_means", f"{name}.sky"], folder)


def contracted(ptx):
    """Operations that round once for two, and products and sums that a later compiler may still join."""
    return re.findall(r"\b(?:fma|mad)\.[\w.]*f(?:32|64)|\b(?:mul|add|sub)\.(?:ftz\.)?f(?:32|64)\b", ptx)


@needs("nvcc", "make")
@pytest.mark.slow
def test_the_kernel_has_no_contracted_operation(folder):
    """The code is made and searched; tests/include/test_gpu.py runs such code where a GPU is."""
    copy = copied("cuda", folder)
    make(copy, "sky_means", "sky_means.ptx")
    text = (copy / "sky_means.ptx").read_text()
    assert "sqrt.rn.f64" in text  # the laws are in it
    assert contracted(text.replace("atom.global.add.f64", "")) == []
    wrong = ["nvcc", "-O3", "-fmad=true", f"-I{include_dir()}", "-ptx", "-o", "wrong.ptx", "sky_means.cu"]
    run(wrong, copy)
    assert "fma.rn.f32" in contracted((copy / "wrong.ptx").read_text())  # planted: nvcc's own choice


@needs_host
@pytest.mark.parametrize("example", ["c", "fortran", "cuda"])
def test_make_without_the_command_says_one_thing(tmp_path, example):
    copy = copied(example, tmp_path)
    command = ["make", "AOMC_SKY=no-such-aomc-sky"]
    (line,) = refused(command, copy, 2).splitlines()
    assert "write: make AOMC_SKY=" in line
    run([*command, "clean"], copy)


@needs_host
@needs("gfortran")
@pytest.mark.parametrize("threads", ["1", "3"])
def test_fortran_gets_the_same_bits(fortran_folder, folder, threads):
    said = run(["./sky_means", str(folder / "perez_sky.sky")], fortran_folder, OMP_NUM_THREADS=threads)
    theirs, ours = (
        [[float(nm), *words] for nm, _, *words in map(str.split, text.splitlines())]
        for text in (said.lower(), report_of(source_of("perez_sky")))
    )
    assert theirs == ours
