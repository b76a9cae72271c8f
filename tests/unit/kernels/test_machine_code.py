"""Machine code that is kept on the disk: taken where all it follows from is the same, and compiled anew else."""

from __future__ import annotations

import shutil
from pathlib import Path

import numba
import numpy as np
import pytest

from aomc_sky.kernels.machine_code import kinds_of, words_of
from tests.support.processes import with_numba

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")

SUMS = """
import sys
import numpy as np
from aomc_sky.kernels import machine_code
{change}
sums = np.zeros(2)
machine_code.Kernel("batches.compiled", "block_sums").bound()(np.array([-0.5, -1.0], np.float32), sums)
print(sums.tolist(), "aomc_sky.kernels.batches.compiled" in sys.modules)
"""
KEPT, COMPILED = "[1.5, 3.0] False", "[1.5, 3.0] True"


def said(cache: Path, change: str = "", **variables: str) -> str:
    """Sums of a kernel, and whether it was compiled."""
    return with_numba(SUMS.format(change=change), NUMBA_CACHE_DIR=str(cache), **variables).strip()


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> Path:
    cache = tmp_path_factory.mktemp("kernels")
    assert said(cache) == COMPILED
    assert said(cache) == KEPT
    return cache


@pytest.fixture
def cache(good, tmp_path) -> Path:
    return shutil.copytree(good, tmp_path / "cache")


OTHERS = {
    "the text of a kernel": {"change": "machine_code.kernel_stamp = lambda: 'other kernels'"},
    "the processor": {"change": "import llvmlite.binding\nllvmlite.binding.get_host_cpu_name = lambda: 'nocona'"},
    "a setting of numba": {"NUMBA_OPT": "2"},
    "llvmlite": {"change": "import llvmlite\nllvmlite.__version__ = '0.1'"},
}


@pytest.mark.parametrize("what", OTHERS)
def test_code_is_not_taken_where_something_else_is_other(what, cache):
    assert said(cache, **OTHERS[what]) == COMPILED


def changed_bit(data: bytes) -> bytes:
    return data[:-500] + bytes([data[-500] ^ 1]) + data[-499:]


DAMAGES = {"cut": lambda data: data[:-100], "zeroed": lambda data: bytes(len(data)), "one bit": changed_bit}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_code_is_compiled_anew_and_kept(damage, cache):
    (entry,) = cache.rglob("*.entry")
    entry.write_bytes(DAMAGES[damage](entry.read_bytes()))
    assert said(cache) == COMPILED
    assert said(cache) == KEPT


def test_code_that_needs_what_the_process_has_not_is_compiled_anew(cache):
    """Sound bytes under the right name, which do not link."""
    wrong = "machine_code.Cache.read = lambda self, key: b'nowhere\\n' + b'no machine code'"
    assert said(cache, wrong) == COMPILED


def test_code_that_others_may_write_is_not_taken(cache):
    (entry,) = cache.rglob("*.entry")
    entry.parent.chmod(0o777)
    assert said(cache) == COMPILED


def test_nothing_is_kept_where_no_file_may_grow(tmp_path):
    limit = "import resource, signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))"
    assert said(tmp_path, limit) == COMPILED
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_arguments_as_words():
    """A number is a word, an array its address and length, one that is not contiguous its stride, too."""
    column = np.zeros((4, 3), np.float32)[:, 1]
    frozen = np.arange(3.0)
    frozen.flags.writeable = False
    arguments = (np.uint64(2**64 - 1), np.int32(-1), np.float64(-2.0), None, True, (np.uint8(7), column), frozen)
    assert kinds_of(arguments) == ("<u8", "<i4", "<f8", None, "True", ("|u1", "<f4[:]"), "<f8[]")
    address, at = column.ctypes.data, frozen.ctypes.data
    assert words_of(arguments) == [2**64 - 1, 2**32 - 1, 0xC000000000000000, 7, address, 4, 12, at, 3]
    assert words_of((np.empty(0),))[1] == 0
    for wrong in (1, 1.0, "text", np.zeros((2, 2))):
        with pytest.raises(TypeError):
            kinds_of((wrong,))
        with pytest.raises(TypeError):
            words_of((wrong,))
