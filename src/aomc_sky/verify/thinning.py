"""Keyed random choices of a verification: a fair coin for each photon, and blocks to look at."""

from __future__ import annotations

import numpy as np

from aomc_sky.sampling.streams import stream_key

THINNING = "verify-coin"
BLOCKS = "verify-blocks"
"""Names of the streams; no photon is made from them."""

_WORD = 64
_WORDS_PER_STEP = 4  # numpy's Philox gives four words for each value of its counter


def is_kept(key: int, start: int, n: int) -> np.ndarray:
    """Whether photons [start, start + n) are kept: a fair coin for each.

    Bit i of the words of Philox4x64-10 by a key from `thinning_key`: any split of a file keeps the same photons.
    """
    per_step = _WORD * _WORDS_PER_STEP
    step, offset = divmod(start, per_step)
    generator = np.random.Philox(key=[key, 0], counter=[step, 0, 0, 0])
    words = np.asarray(generator.random_raw((offset + n + _WORD - 1) // _WORD), dtype="<u8")
    return np.unpackbits(words.view(np.uint8), bitorder="little")[offset : offset + n].view(bool)


def thinning_key(seed: int) -> int:
    """Key of the choice of photons of a seed."""
    return stream_key(seed, THINNING)


def chosen_blocks(seed: int, band: int, n_blocks: int, fraction: float) -> np.ndarray:
    """Blocks of a band that a resampling looks at: ceil(fraction x n_blocks) different ones in rising order."""
    n = min(n_blocks, int(np.ceil(fraction * n_blocks)))
    generator = np.random.Generator(np.random.Philox(key=[stream_key(seed, BLOCKS), band]))
    return np.sort(generator.choice(n_blocks, size=n, replace=False)) if n else np.zeros(0, dtype=np.int64)
