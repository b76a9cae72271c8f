"""Row 44 of the matrix: bad caches, other processors, no compiler, any number of threads.

Batches of any size are in tests/emission/test_photon_source.py.
"""

import shutil
from pathlib import Path

import numba
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command, row
from tests.support.processes import with_numba
from tests.support.scenes import run_bytes


@row(44, "threads-1-to-64")
def test_threads(fault, amc, tmp_path):
    found = []
    for threads in (1, 2, 3, 64):
        out = tmp_path / str(threads)
        assert command("run", amc, "--iterations", 300_000, "--threads", threads, "--out", out, "-q") == 0
        found.append(run_bytes(out))
    assert all(one == found[0] for one in found)


HELPER = """
from aomc_sky.kernels.jit import inner

@inner
def value(x):
    return x + {add}
"""
PROGRAM = """
from aomc_sky.kernels.caller import call
print(call(1), sum(call.stats.cache_hits.values()), sum(call.stats.cache_misses.values()))
"""
CALLER = """
from aomc_sky.kernels.jit import kernel
from aomc_sky.kernels.arithmetic.helper import value

@kernel
def call(x):
    return value(x)
"""


needs_jit = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT's cache")


@needs_jit
@row(44, "stale-cache")
def test_editing_a_helper_recompiles_the_caller(fault, tmp_path):
    """numba alone looks at the file of the caller only, and would go on with the old helper."""
    shutil.copytree(Path(sky.__file__).parent, tmp_path / "aomc_sky", ignore=shutil.ignore_patterns("__pycache__"))
    kernels = tmp_path / "aomc_sky" / "kernels"
    (kernels / "caller.py").write_text(CALLER)
    for add in (1, 10):
        (kernels / "arithmetic" / "helper.py").write_text(HELPER.format(add=add))
        for hits in (0, 1):
            said = with_numba(PROGRAM, PYTHONPATH=str(tmp_path), NUMBA_CACHE_DIR=str(tmp_path / "cache"))
            assert said.split() == [str(1 + add), str(hits), str(1 - hits)]


@needs_jit
@row(44, "no-writable-cache-folder")
def test_no_writable_cache_folder(fault):
    """numba raises RuntimeError where no locator finds a folder; the kernels then compile in memory."""
    program = "import numba.core.caching as c\nc.FunctionCache._impl_class._locator_classes = []\n"
    assert with_numba(program + COUNTS).startswith(COUNTS_SAID)


COUNTS = """
import numpy as np
from aomc_sky.kernels.allocate import aomc_counts
counts = np.zeros((1, 2), dtype=np.int64)
aomc_counts(np.array([[3.0, 1.0]], dtype=np.float32), 8, counts)
print(counts.tolist(), sum(aomc_counts.stats.cache_hits.values()))
"""
COUNTS_SAID = "[[6, 2]]"


@row(44, "cache-folder-cannot-be-made")
def test_a_cache_folder_that_cannot_be_made(fault):
    assert with_numba(COUNTS, NUMBA_CACHE_DIR="/proc/self/none").startswith(COUNTS_SAID)


DAMAGES = {
    "zeroed-cache": lambda data: bytes(len(data)),
    "cut-cache": lambda data: data[: len(data) // 2],
    # in the middle of the machine code, where pickle sees nothing
    "one-bit-cache": lambda data: b"%b%c%b" % (data[: (n := len(data) // 2)], data[n] ^ 1, data[n + 1 :]),
}


@pytest.fixture(scope="module")
def good_cache(tmp_path_factory):
    cache = tmp_path_factory.mktemp("kernels")
    assert with_numba(COUNTS, NUMBA_CACHE_DIR=str(cache)).strip() == f"{COUNTS_SAID} 0"
    return cache


_STAMP = "import aomc_sky.kernels.numba_private as p\np.text_stamp = lambda: 'other'\n"
OTHER_KERNELS = _STAMP + "p.AS_IMPORTED = 'other'\n"
NOCONA = {"NUMBA_CPU_NAME": "nocona", "NUMBA_CPU_FEATURES": ""}
CACHES = {
    # name: runs one after another: program before the kernel, environment, hits of the cache
    **{name: [("", {}, 0), ("", {}, 1)] for name in DAMAGES},
    "another-processor": [("", NOCONA, 0), ("", NOCONA, 1), ("", {}, 1)],
    "code-of-other-kernels-under-the-name": [(OTHER_KERNELS, {}, 0), (OTHER_KERNELS, {}, 1), ("", {}, 0)],
    "upgrade-below-a-running-session": [(_STAMP, {}, 0)],
}


@needs_jit
@row(44, *CACHES)
def test_code_that_is_not_of_this_text_or_processor_is_not_taken(fault, good_cache, tmp_path):
    """Damage is what a crash leaves; after an upgrade below a running session nothing is kept or taken."""
    cache = Path(shutil.copytree(good_cache, tmp_path / "cache"))
    damaged = list(cache.rglob("*.nbc"))
    assert damaged
    for path in damaged if fault in DAMAGES else ():
        path.write_bytes(DAMAGES[fault](path.read_bytes()))
    before = [path.read_bytes() for path in damaged]
    for change, variables, hits in CACHES[fault]:
        said = with_numba(change + COUNTS, NUMBA_CACHE_DIR=str(cache), **variables).strip()
        assert said == f"{COUNTS_SAID} {hits}"
    assert ([path.read_bytes() for path in damaged] == before) == (
        fault not in (*DAMAGES, "code-of-other-kernels-under-the-name")
    )


@needs_jit
@row(44, "code-under-the-name-of-another-signature")
def test_code_of_another_signature(fault, good_cache, tmp_path):
    """The seal is of the types and the processor too."""
    cache = shutil.copytree(good_cache, tmp_path / "cache")
    other = COUNTS.replace("np.zeros((1, 2), dtype=np.int64)", "np.zeros((1, 4), dtype=np.int64)[:, ::2]")
    for _ in range(2):
        assert with_numba(other, NUMBA_CACHE_DIR=str(cache)).strip() == f"{COUNTS_SAID} 0"
        before = {path.name for path in good_cache.rglob("*.nbc")}
        one, two = sorted(cache.rglob("*.nbc"), key=lambda path: path.name not in before)
        shutil.copy(one, two)


@needs_jit
@row(44, "no-room-for-the-cache")
def test_no_room_for_the_cache(fault, tmp_path):
    """No file may grow, so nothing can be stored: the kernel works all the same."""
    limit = "import resource, signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
    assert with_numba(limit + COUNTS, NUMBA_CACHE_DIR=str(tmp_path)).strip() == f"{COUNTS_SAID} 0"
