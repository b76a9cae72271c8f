"""Numbers that many kernels and those who fill their tables share."""

from __future__ import annotations

import numpy as np

U32, U64 = np.uint32, np.uint64
ZERO, ONE, TWO, THREE, FOUR = (np.uint64(n) for n in range(5))
S32 = np.uint64(32)
LOW32 = np.uint64(0xFFFFFFFF)
"""Types, and numbers of type uint64: beside a Python integer numba would make a float of one."""

# R2 (Roberts 2018): 2^64 / g and 2^64 / g^2, g^3 = g + 1, rounded to the odd neighbour, so that the
# steps visit all 2^64 fractions
R2_STEP_U = np.uint64(13925035116211876495)
R2_STEP_V = np.uint64(10511698010929265437)
# from the first photon of a ring to that of the next: 2^64 over the golden ratio (odd), furthest from any fraction
RING_STEP = np.uint64(0x9E3779B97F4A7C15)

ACCEPT_STEP = np.uint64(0x9E3779B97F4A7C15)
ACCEPT = np.uint64(1 << 31)
"""Rejection: step of the sequence that decides trial 0, 2^64 over the golden ratio (odd), and the draw of Philox that
does it for photons without a sequence."""

NUMBER_STEPS = np.array([0xA36E8B5385138591, 0xBAF1C66A7A85077F, 0x9629644EAFD5A7D3], dtype=np.uint64)
"""Steps of the numbers that photons of a sky of one patch carry for their host, found by bench/number_steps.py."""
NUMBER_STEPS.flags.writeable = False

BLOCK = 2048
SCRATCH_PHOTONS = BLOCK + 24
"""Photons that the emission works on at a time, and the words of a column of its scratch memory: 24 more, for rows a
multiple of 4 KiB apart collide in the cache."""

PARAMETER_COLUMN, COLUMNS = 8, 15
"""The first column of the parameters of a block's cells in the scratch memory, and its columns."""

PEREZ_CHUNK = 256
PEREZ_WORDS = 18 * (PEREZ_CHUNK + 24)
"""Photons that the rejection works on at a time, and its scratch memory; columns half a page apart would collide."""

LOBE_QUEUE_SIZE = 256
LOBE_COLUMN = LOBE_QUEUE_SIZE + 64
LOBE_WORDS = 24 * LOBE_COLUMN
"""Photons of a full queue of a lobe, whole vectors; the columns of its scratch memory, which stay in the cache."""


def scratch_words(n_lobe: int) -> int:
    """Words of scratch memory that the emission needs for so many lobes."""
    lobe_words = (2 + 3 * LOBE_QUEUE_SIZE) * n_lobe + 3 * LOBE_COLUMN + LOBE_WORDS + SCRATCH_PHOTONS if n_lobe else 0
    return COLUMNS * SCRATCH_PHOTONS + PEREZ_WORDS + lobe_words


def on_cache_lines(values: np.ndarray) -> np.ndarray:
    """A copy that begins on a cache line, so that a row of 64 bytes lies on one."""
    memory = np.empty(values.nbytes + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    copy = memory[begin : begin + values.nbytes].view(values.dtype)
    copy[:] = values
    return copy


LAST_TRIAL = np.uint64(10_000)
"""The last try is taken whatever it is: a cell without light in float32 must not hang a run."""

TILT_STEP = 2.0**-11
"""The slope along which photons are sent inside a cell before the rejection: 10 bits for each direction."""

SLOPE_STEP = 2.0**-30
"""Slopes of the light inside a cell are whole numbers of these."""

NARROW, QUARTER, ANY_WIDTH, IN_MU = (np.uint64(kernel) for kernel in range(4))
"""The azimuth kernel, the loop for most slots: uniform in mu^2 in cells of at most 3 degrees of azimuth, at most 90, of
any width; in mu."""
