"""Which kernels make the photons: the choice itself loads numba, before several threads can import parts of it."""

from tests.support.processes import in_environment

PROGRAM = """
import sys
from aomc_sky.kernels import backend
assert not backend.use_kernels(1) and "numba" not in sys.modules
assert backend.use_kernels(backend.PLAIN_PHOTONS) and "numba" in sys.modules
"""


def test_the_thread_that_takes_the_kernels_loads_numba_for_all():
    in_environment(PROGRAM)
