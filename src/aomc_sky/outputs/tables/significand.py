"""Numbers whose significands are cut to fewer bits: they need less space once the file is compressed."""

from __future__ import annotations

import numpy as np


def rounded_significand(values: np.ndarray, n_bits: int) -> np.ndarray:
    """Round to the nearest numbers with significands of so many bits, ties to even.

    Parameters
    ----------
    values : ndarray, float64
        Numbers; zeros, NaN and infinities stay what they are.
    n_bits : int
        Bits of the significand. [1 to 24]

    Returns
    -------
    ndarray, float32
        Within 2^-n_bits of the values, as a share of them, where these lie in the range of float32's normal numbers,
        1.2e-38 to 3.4e38.
    """
    fraction, exponent = np.frexp(np.asarray(values, dtype=np.float64))
    return np.ldexp(np.rint(np.ldexp(fraction, n_bits)), exponent - n_bits).astype(np.float32)
