"""Random numbers of a step of paths that are followed backwards, one block of Philox for each path."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.constants import LOW32, S32, U64
from aomc_sky.kernels.arithmetic.elementary import log_of_parts, split_power
from aomc_sky.kernels.arithmetic.rng import philox4x32
from aomc_sky.kernels.jit import inlined_reader
from aomc_sky.kernels.phase.scatter import cos_sin

_INV32 = 2.0**-32

_cos_sin = inlined_reader(cos_sin)

FLIGHT, TURN, COSINE, SINE, SPARE = range(5)
N_NUMBER = 5
"""Rows of a step's numbers: how far, by what angle, cosine and sine of the azimuth, one more."""


@inlined_reader
def uniform(word):
    """Middle of one of 2^32 parts of (0, 1)."""
    return (np.float64(word) + 0.5) * _INV32


@inlined_reader
def minus_log(x):
    """-log(x) of a number in (0, 1), without a branch."""
    m, power = split_power(x)
    is_low = m < 0.7071067811865476
    m = m + m if is_low else m
    power = power - 1.0 if is_low else power
    return -log_of_parts(m - 1.0, power)


@inlined_reader
def fill_numbers(address, step, path, n, flight, turn, cosine, sine, spare):
    """Numbers of a step of n paths; `flight` is an optical depth, of step 0 the uniform number that it comes from."""
    low, high = address[2] & LOW32, address[2] >> S32
    for i in range(n):
        w0, w1, w2, w3 = philox4x32(U64(path[i]), U64(step), address[0], address[1], low, high)
        x = uniform(w0)
        flight[i] = x if step == 0 else minus_log(x)
        turn[i] = uniform(w1)
        cosine[i], sine[i] = _cos_sin(uniform(w2))
        spare[i] = uniform(w3)
