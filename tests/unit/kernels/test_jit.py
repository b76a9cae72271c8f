"""The disk cache of the kernels is never stale, and a folder that cannot be written stops nothing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import aomc_sky

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT's cache")

CALLER = """
from aomc_sky.kernels.jit import kernel
from aomc_sky.kernels.helper import value

@kernel
def call(x):
    return value(x)
"""
HELPER = """
from aomc_sky.kernels.jit import inner

@inner
def value(x):
    return x + {add}
"""
PROGRAM = """
import numpy as np
from aomc_sky.kernels.caller import call
print(call(1), sum(call.stats.cache_hits.values()), sum(call.stats.cache_misses.values()))
"""


def run(package: Path, cache: Path) -> list[int]:
    environment = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True, timeout=120
    )
    return [int(word) for word in done.stdout.split()]


def test_editing_a_helper_recompiles_the_caller(tmp_path):
    shutil.copytree(Path(aomc_sky.__file__).parent, tmp_path / "aomc_sky", ignore=shutil.ignore_patterns("__pycache__"))
    kernels = tmp_path / "aomc_sky" / "kernels"
    (kernels / "caller.py").write_text(CALLER)
    (kernels / "helper.py").write_text(HELPER.format(add=1))
    cache = tmp_path / "cache"
    assert run(tmp_path, cache) == [2, 0, 1]
    assert run(tmp_path, cache) == [2, 1, 0]
    (kernels / "helper.py").write_text(HELPER.format(add=10))
    assert run(tmp_path, cache) == [11, 0, 1]
    assert run(tmp_path, cache) == [11, 1, 0]


def test_no_writable_cache_folder(tmp_path):
    """numba raises RuntimeError where no locator finds a folder; the kernels then compile in memory."""
    program = (
        "import numba.core.caching as c\n"
        "c.FunctionCache._impl_class._locator_classes = []\n"
        "from aomc_sky.kernels.statistics import block_sums\n"
        "import numpy as np\n"
        "print(block_sums(np.array([-0.5, -1.0], np.float32)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.strip() == "(1.5, 3.0)"


def test_kernels_ask_for_the_widest_vectors():
    from aomc_sky.kernels.jit import _WIDEST_VECTORS, KernelCompiler

    @numba.njit(pipeline_class=KernelCompiler)
    def twice(x):
        return x + x

    assert twice(2) == 4
    (text,) = twice.inspect_llvm().values()
    assert _WIDEST_VECTORS in text
