"""What the decorator of the kernels asks the compiler for; for its cache see tests/faults/test_machine_faults.py."""

import numba
import pytest

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")


def test_kernels_ask_for_the_widest_vectors():
    from aomc_sky.kernels.jit import _WIDEST_VECTORS, KernelCompiler

    @numba.njit(pipeline_class=KernelCompiler)
    def twice(x):
        return x + x

    assert twice(2) == 4
    (text,) = twice.inspect_llvm().values()
    assert _WIDEST_VECTORS in text
