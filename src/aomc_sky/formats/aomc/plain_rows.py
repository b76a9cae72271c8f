"""Rows of three whole numbers and a value, read as arrays."""

from __future__ import annotations

import numpy as np

_N_COLUMNS = 4
_MOST_DIGITS = 8


def plain_rows(text: bytes) -> tuple[np.ndarray, np.ndarray] | None:
    """Whole numbers int64 (3, n) and values float64 (n,) of a text whose every line has four plain numbers, else None.

    Blanks stand between numbers, whole numbers have at most eight digits and no sign. The values are those of `float`.
    """
    rows = [line.split() for line in text.splitlines()]
    if not rows or any(len(row) != _N_COLUMNS for row in rows):
        return None
    *whole, value = zip(*rows, strict=True)
    if not all(word.isdigit() and len(word) <= _MOST_DIGITS for column in whole for word in column):
        return None
    try:
        values = np.array([float(word) for word in value])
    except ValueError:
        return None
    return np.array([[int(word) for word in column] for column in whole], np.int64), values
