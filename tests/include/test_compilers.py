"""Other compilers and another processor make the same photons of the same file: a sum over their bits."""

import shutil

import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from tests.support.host_programs import needs, run
from tests.support.shared import REPOSITORY
from tests.support.source_files import FLAGS_OF_HOST, SCENES, biased, needs_gcc, source_of

pytestmark = [needs_gcc, pytest.mark.slow]
PROGRAM = REPOSITORY / "tests" / "reference" / "source_driver.c"
FLAGS = ("-O0", "-O2", "-O3")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Source files of every law, and what gcc says of their photons, 2e5 of each band and some one by one."""
    folder = tmp_path_factory.mktemp("files")
    names = []
    for name in SCENES:
        for precision in ("float32", "float64"):
            names.append(folder / f"{len(names):02d}.sky")
            placement = "r2" if len(names) % 3 else "philox"
            order = "shuffled" if len(names) % 2 else "patch"
            source = source_of(name, 100_003, precision=precision, order=order, placement=placement)
            sky.write_source(source, names[-1])
    for name in ("disc and table", "lobes and all"):
        names.append(folder / f"{len(names):02d}.sky")
        sky.write_source(biased(name, 100_003), names[-1])
    return names, sums(["gcc", "-O2"], folder, names)


def sums(compiler, folder, names, runner=()):
    """Lines of the driver: a code and a sum for each file."""
    flags = ["-DDRIVER_MAIN", "-Wall", "-Wextra", f"-I{include_dir()}", "-o", "driver", str(PROGRAM), "-lm"]
    run([*compiler, *flags], folder)
    lines = run([*runner, "./driver", *map(str, names)], folder).splitlines()
    assert len(lines) == len(names)
    return lines


def test_gcc_reads_every_file(files):
    assert all(line.startswith("0 ") for line in files[1])


@pytest.mark.parametrize("flags", [*FLAGS, "-O3 -march=native", "-Os"])
def test_clang(files, flags, tmp_path):
    if shutil.which("clang") is None:
        pytest.skip("clang not installed")
    assert sums(["clang", *flags.split()], tmp_path, files[0]) == files[1]


def test_a_host_under_fast_math_links_the_header_compiled_apart(files, tmp_path):
    """`-Ofast` for all but aomc_sky.c, and flush-to-zero for the process; planted: no such unit."""
    run(["gcc", "-O3", "-c", f"-I{include_dir()}", str(include_dir() / "aomc_sky.c")], tmp_path)
    for compiler in ("gcc", "clang"):
        if shutil.which(compiler) is not None:
            apart = [compiler, "-Ofast", "-march=native", "-DAOMC_SKY_DECLARE_ONLY", "aomc_sky.o"]
            assert sums(apart, tmp_path, files[0]) == files[1]
            lines = sums([compiler, "-Ofast"], tmp_path, files[0])
            assert all(line.startswith("-11 ") for line in lines)


@pytest.mark.parametrize("flags", FLAGS)
def test_aarch64(files, flags, tmp_path):
    compiler, emulator = _aarch64()
    assert sums([compiler, flags, "-static"], tmp_path, files[0], [emulator]) == files[1]


def test_aarch64_contracts_where_nothing_forbids_it(files, tmp_path):
    compiler, emulator = _aarch64()
    lines = sums([compiler, "-O2", "-static", FLAGS_OF_HOST], tmp_path, files[0], [emulator])
    assert all(line.startswith("-11 ") for line in lines)


def _aarch64():
    compiler = "aarch64-linux-gnu-gcc"
    emulator = next(filter(shutil.which, ("qemu-aarch64", "qemu-aarch64-static")), None)
    if shutil.which(compiler) is None or emulator is None:
        pytest.skip("aarch64-linux-gnu-gcc or qemu-aarch64 not installed (Debian: gcc-aarch64-linux-gnu, qemu-user)")
    return compiler, emulator


@needs("nvcc")
def test_code_for_a_gpu_contracts_nothing(tmp_path):
    """The driver of test_gpu.py, compiled only: that test runs it where a GPU is."""
    driver = REPOSITORY / "tests" / "reference" / "gpu_driver.cu"
    run(["nvcc", "-fmad=false", f"-I{include_dir()}", "-ptx", "-o", "driver.ptx", str(driver)], tmp_path)
    text = (tmp_path / "driver.ptx").read_text()
    assert ".entry" in text
    assert "fma." not in text
