"""Arguments behind an address, as Python lays them down; tests/emission/test_host.py reads them in compiled code."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from aomc_sky.kernels.arguments import typed, words_of

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")


def test_arguments_as_words():
    """A number is a word, an array its address and length; None and True are types alone."""
    frozen = np.arange(3.0)
    frozen.flags.writeable = False
    column = np.zeros(4, np.float32)
    arguments = (np.uint64(2**64 - 1), np.int32(-1), np.float64(-2.0), None, True, (np.uint8(7), column), frozen)
    kinds = "uint64, int32, float64, none, bool, Tuple(uint8, array(float32, 1d, C)), array(float64, 1d, C)"
    assert str(typed(arguments)) == f"Tuple({kinds})"
    address, at = column.ctypes.data, frozen.ctypes.data
    assert words_of(arguments) == [2**64 - 1, 2**32 - 1, 0xC000000000000000, 7, address, 4, at, 3]


@pytest.mark.parametrize("wrong", [1, 1.0, "text", np.zeros((2, 2)), np.zeros(4)[::2]])
def test_what_cannot_stand_in_a_block_is_refused(wrong):
    with pytest.raises(TypeError, match="cannot stand in a block"):
        typed((wrong,))
