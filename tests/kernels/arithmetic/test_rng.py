"""Philox against its published known answers: for arrays, compiled, and as the allocation calls it."""

import numpy as np
import pytest

from aomc_sky.kernels.arithmetic import rng
from aomc_sky.kernels.jit import shared
from aomc_sky.plan import streams

# Random123, kat_vectors: philox4x32 10, counter, key, words
KNOWN = [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@shared
def compiled_pair(key, rank, band, draw):
    return rng.philox_pair(key, rank, band, draw)


@pytest.mark.parametrize(("counter", "key", "words"), KNOWN)
def test_known_answers(counter, key, words):
    got = rng.philox4x32(*(np.uint64(x) for x in (*counter, *key)))
    assert tuple(int(w) for w in got) == words
    rank, whole_key = counter[0] | counter[1] << 32, key[0] | key[1] << 32
    pair = ((words[0] << 32) | words[1], (words[2] << 32) | words[3])
    assert streams.philox_pair(whole_key, rank, counter[2], counter[3]) == pair
    arguments = np.uint64(whole_key), np.array([rank], np.uint64), np.uint64(counter[2]), np.uint64(counter[3])
    assert tuple(int(w[0]) for w in rng.philox_pair(*arguments)) == pair
    assert tuple(int(w) for w in compiled_pair(arguments[0], np.uint64(rank), *arguments[2:])) == pair


def test_r2_steps_are_the_plastic_number():
    from mpmath import findroot, mp, mpf

    from aomc_sky.kernels.arithmetic.constants import R2_STEP_U, R2_STEP_V

    with mp.workdps(50):
        g = findroot(lambda x: x**3 - x - 1, 1.32)
        for step, power in ((R2_STEP_U, 1), (R2_STEP_V, 2)):
            assert int(step) % 2 == 1
            assert abs(mpf(int(step)) - mpf(2) ** 64 / g**power) <= 1
