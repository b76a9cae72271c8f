"""Rows of three whole numbers and a value, read as arrays: every row at once, digit by digit in words of eight."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.arithmetic.decimals import nearest_floats

_N_COLUMNS = 4
_WORD = 8
_BLANK, _NEW_LINE, _POINT, _E = 32, 10, ord("."), ord("e")
_WHOLE_POWERS = 10 ** np.arange(19, dtype=np.int64)


def plain_rows(text: bytes) -> tuple[np.ndarray, np.ndarray] | None:
    """Whole numbers int64 (3, n) and values float64 (n,) of a text whose every line has four plain numbers, else None.

    Blanks stand between numbers, whole numbers have at most eight digits and no sign. The values are those of `float`.
    """
    tokens = _tokens(text)
    if tokens is None:
        return None
    start, end = tokens
    # the eight characters before each place
    words = np.ndarray((len(text) + 1,), "<u8", buffer=b"0" * _WORD + text, strides=(1,))
    length = end[:3] - start[:3]
    whole, is_whole = _numbers(words, end[:3], length)
    if length.max() > _WORD or not is_whole.all():
        return None
    values = _values(text, words, start[3], end[3])
    return None if values is None else (whole, values)


def _tokens(text: bytes) -> tuple[np.ndarray, np.ndarray] | None:
    """Where the numbers of each row start and end, (4, n) each; None unless every line has four."""
    characters = np.frombuffer(text, np.uint8)
    is_word = np.empty(characters.size + 2, bool)
    is_word[0] = is_word[-1] = False
    np.greater(characters, _BLANK, out=is_word[1:-1])
    edges = np.flatnonzero(is_word[1:] != is_word[:-1])
    n_rows, left = divmod(edges.size, 2 * _N_COLUMNS)
    line_end = np.flatnonzero(characters == _NEW_LINE)
    if left or not n_rows or line_end.size != n_rows - (not text.endswith(b"\n")):
        return None
    start, end = (np.ascontiguousarray(edges.reshape(n_rows, -1)[:, k::2].T) for k in (0, 1))
    if np.any(line_end < end[3, : line_end.size]) or np.any(line_end[: n_rows - 1] >= start[0, 1:]):
        return None
    return start, end


_ZEROS, _ABOVE_NINE, _SIGNS = (np.uint64(0x0101010101010101 * byte) for byte in (0x30, 0x76, 0x80))
_ODD, _SIXTEEN, _EIGHT = np.uint64(0x000000FF000000FF), np.uint64(16), np.uint64(8)
_TEN, _TO_MILLION, _TO_TEN_THOUSAND = np.uint64(10), np.uint64(0x000F424000000064), np.uint64(0x0000271000000001)
_UPPER = np.uint64(32)


def _numbers(words: np.ndarray, end: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whole number of the last `length` characters before each place, and whether all are digits; of 0 or less: 0."""
    unwanted = _EIGHT * np.clip(_WORD - length, 0, _WORD - 1).astype(np.uint64)
    word = ((words[end] ^ _ZEROS) >> unwanted) << unwanted
    word *= length > 0
    are_digits = ((word + _ABOVE_NINE | word) & _SIGNS) == 0
    word = word * _TEN + (word >> _EIGHT)  # of two neighbours, then of all four pairs
    word = ((word & _ODD) * _TO_MILLION + (word >> _SIXTEEN & _ODD) * _TO_TEN_THOUSAND) >> _UPPER
    return word.view(np.int64), are_digits


def _values(text: bytes, words: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray | None:
    """Values of the last column; None where one is no number."""
    characters = np.frombuffer(text, np.uint8)
    stop, exponent, is_plain = end, np.zeros(end.size, np.int64), np.ones(end.size, bool)
    if b"e" in text or b"E" in text:
        stop = _place(end, np.flatnonzero(characters | _BLANK == _E))
        sign = characters.take(stop + 1, mode="clip")
        first = stop + 1 + ((sign == ord("+")) | (sign == ord("-")))
        size, exponent, has_exponent = end - first, np.zeros(end.size, np.int64), stop < end
        number, are_digits = _numbers(words, end, size)
        exponent = np.where(has_exponent, np.where(sign == ord("-"), -number, number), 0)
        is_plain &= ~has_exponent | (are_digits & (size > 0) & (size <= 3))
    point = np.minimum(_place(end, np.flatnonzero(characters == _POINT)), stop)
    before, behind = point - start, np.maximum(stop - point - 1, 0)
    digits, are_digits = _numbers(words, point, before)
    is_plain &= are_digits & (before > 0) & (before <= _WORD)
    is_plain &= (before + behind <= 18) | (digits == 0)
    digits = digits * _WHOLE_POWERS.take(behind, mode="clip")
    for k in range(3):
        if k and behind.max() <= k * _WORD:
            break
        number, are_digits = _numbers(words, np.maximum(stop - k * _WORD, 0), behind - k * _WORD)
        digits += number * 10 ** (k * _WORD) if k < 2 else np.minimum(number, 800) * 10**16
        is_plain &= are_digits & ((number < 800) | (k < 2))
    is_plain &= behind <= 3 * _WORD
    values = nearest_floats(np.where(is_plain, digits, 0), np.where(is_plain, exponent - behind, 0))
    for row in np.flatnonzero(~is_plain):
        try:
            values[row] = float(text[start[row] : end[row]])
        except ValueError:
            return None
    return values


def _place(end: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The place that stands in each number which ends here; of one without, its end."""
    found = end.copy()
    row = np.searchsorted(end, places, side="right") if places.size != end.size else slice(None)
    found[row] = places
    return found
