"""Photons that a GPU makes with aomc_sky.h are those of the package, bit for bit. Skipped where no GPU is."""

import ctypes
import functools
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.cli.commands.info import include_dir
from tests.support.host_programs import run
from tests.support.shared import REPOSITORY
from tests.support.source_files import SCENES, WAYS, Driver, compare, same_bits, source_of

DRIVER = REPOSITORY / "tests" / "reference" / "gpu_driver.cu"
CHANGED = -11
"""What aomc_sky_witness says of photons that are not those of the file."""


@functools.cache
def gpu(flags="-fmad=false"):
    if shutil.which("nvcc") is None or shutil.which("nvidia-smi") is None:
        pytest.skip("no nvcc or no GPU")
    if subprocess.run(["nvidia-smi", "-L"], capture_output=True, check=False).stdout.count(b"GPU ") == 0:
        pytest.skip("no GPU")
    folder = Path(tempfile.mkdtemp(prefix="aomc-sky-gpu-"))
    make = ["nvcc", "-O3", "-arch=native", *flags.split(), "-shared", "-Xcompiler", "-fPIC", f"-I{include_dir()}"]
    run([*make, "-o", "driver.so", str(DRIVER)], folder)
    library = ctypes.CDLL(str(folder / "driver.so"))
    shutil.rmtree(folder)
    library.driver_seconds.restype = ctypes.c_double
    return Driver(library)


@pytest.mark.parametrize(("name", "precision", "order", "placement"), WAYS)
def test_every_law_order_placement_and_precision(name, precision, order, placement):
    driver = gpu()
    source = source_of(name, 2011, precision=precision, order=order, placement=placement)
    compare(driver, source)
    assert driver.witness == 0


@pytest.mark.parametrize("name", SCENES)
def test_method_iid_and_a_million_photons(name):
    driver = gpu()
    compare(driver, source_of(name, method="iid"))
    compare(driver, source_of(name, 1_000_003), 1_000_003)


@pytest.mark.parametrize("name", ["table", "perez", "lobes and all"])
def test_witnesses_find_contraction(name):
    """Planted: nvcc's own choice joins products and sums."""
    right, contracted = gpu(), gpu("-fmad=true")
    source = source_of(name)
    for driver in (right, contracted):
        driver.open(source)
    rows = [np.empty((3, source.n_photons(0)), source.dtype) for _ in range(2)]
    for driver, out in zip((right, contracted), rows, strict=True):
        driver.fill(0, out)
    assert not same_bits(*rows)
    assert right.witness == 0
    assert contracted.witness == CHANGED
