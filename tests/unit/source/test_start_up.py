"""Which way photons are made never shows in them, and small jobs never load numba."""

import subprocess
import sys

from tests.support.shared import INPUTS

PROGRAM = """
import sys
import aomc_sky as sky
source = sky.read_scene({path!r}, iterations={iterations}).source(seed=1)
if {iterations} > 10**6:
    from aomc_sky.kernels.backend import announce_photons
    announce_photons(source.total)
source.photons(0, 0, 1000)
print("numba" in sys.modules)
"""


def loads_numba(iterations: int) -> bool:
    text = PROGRAM.format(path=str(INPUTS / "overcast"), iterations=iterations)
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True, timeout=120)
    return done.stdout.strip() == "True"


def test_small_jobs_run_without_numba_and_large_ones_with_it():
    assert not loads_numba(10**5)
    assert loads_numba(10**8)
