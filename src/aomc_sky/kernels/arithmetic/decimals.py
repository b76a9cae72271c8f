"""Many floats to and from decimal digits at once, as `repr` writes and `float` reads them."""

from __future__ import annotations

import functools

import numpy as np

from aomc_sky.kernels.arithmetic.error_free import product_error, two_sum

WIDTH = 24
"""Characters of the longest text of a float64."""

_LOW, _HIGH = 1e-250, 1e250
"""Where neither a power of ten nor a half of a factor leaves the normal numbers; `repr` writes the others."""

_DOUBT = 2.0**-30
"""How near to a limit a number goes to `repr`: its 17 digits before the point are known to 1e-14 of the last."""

_BLOCK = 16_384
_ZERO, _POINT = np.frombuffer(b"0.", np.uint8)
_FOUR_DIGITS = np.frombuffer(b"".join(b"%04d" % k for k in range(10_000)), np.uint32)


def shortest_texts(values: np.ndarray) -> np.ndarray:
    """Characters of each value, uint8 (n, 24): those of `repr(float(value))` in their order, zero bytes between them.

    Of the decimal numbers that lie nearer to the value than to any other float64, the one with the fewest digits, and
    of these the nearest: found with 17 digits in twice the precision. Where this cannot decide, `repr` does.
    """
    values = np.ascontiguousarray(values, np.float64)
    texts = np.zeros((values.size, WIDTH), np.uint8)
    for start in range(0, values.size, _BLOCK):
        _write(values[start : start + _BLOCK], texts[start : start + _BLOCK])
    return texts


def _write(values: np.ndarray, texts: np.ndarray) -> None:
    sure = (values >= _LOW) & (values < _HIGH)
    digits, exponent, decided = _shortest(np.where(sure, values, 1.5))
    sure &= decided
    rows = np.flatnonzero(~sure)
    texts[rows] = np.array([repr(v) for v in values[rows].tolist()], f"S{WIDTH}").view(np.uint8).reshape(-1, WIDTH)
    characters, lowest = _characters(digits), int(exponent.min())
    for e in (np.flatnonzero(np.bincount(exponent - lowest)) + lowest).tolist():
        rows = np.flatnonzero(sure & (exponent == e))
        texts[rows] = _laid_out(characters[rows], e)


@functools.cache
def _power_of_ten(k: int) -> tuple[float, float]:
    """10^k as the sum of two float64, to 2^-106."""
    above, below = 10 ** max(k, 0), 10 ** max(-k, 0)
    high = above / below
    n, d = high.as_integer_ratio()
    return high, (above * d - n * below) / (below * d)


def _powers_of_ten(exponent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    lowest = int(exponent.min())
    parts = zip(*(_power_of_ten(k) for k in range(lowest, int(exponent.max()) + 1)), strict=True)
    high, low = (np.array(part)[exponent - lowest] for part in parts)
    return high, low


def _shortest(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Seventeen digits, zeros at their end where fewer are enough, power of ten of the first, whether it is sure."""
    exponent = np.floor(np.log10(x)).astype(np.int64)
    high, low = _powers_of_ten(16 - exponent)
    head = x * high
    tail = product_error(x, high, head) + x * low
    whole = np.floor(tail)
    n, part = head.astype(np.int64) + whole.astype(np.int64), tail - whole
    half_gap = np.spacing(x) * 0.5 * high  # anything nearer than this reads back as x
    found, doubt = n + (part >= 0.5), np.abs(part - 0.5) < _DOUBT
    for unit in (10, 100):
        tens = n // unit
        rest = (n - tens * unit) + part
        up = rest > unit / 2
        distance = np.where(up, unit - rest, rest)
        doubt |= (np.abs(rest - unit / 2) < _DOUBT) | (np.abs(distance - half_gap) < _DOUBT)
        found = np.where(distance < half_gap, (tens + up) * unit, found)
    at_power_of_two = (x.view(np.int64) & (2**52 - 1)) == 0  # its lower neighbour is nearer
    return found, exponent, ~(doubt | at_power_of_two) & (found >= 10**16) & (found < 10**17)


def _characters(digits: np.ndarray) -> np.ndarray:
    """Characters of numbers of 17 digits, uint8 (n, 17), zero bytes in place of zeros at the end."""
    words = np.empty((digits.size, 5), np.uint32)
    left = digits
    for column in range(4, -1, -1):
        rest = left // 10_000
        words[:, column] = _FOUR_DIGITS[left - rest * 10_000]
        left = rest
    characters = words.view(np.uint8)[:, 3:]
    ending = np.flatnonzero(digits % 10 == 0)
    for column in range(16, 0, -1):
        characters[ending, column] = 0
        ending = ending[characters[ending, column - 1] == _ZERO]
    return characters


def _laid_out(characters: np.ndarray, exponent: int) -> np.ndarray:
    """Digits with their point and their power of ten, where `repr` writes them."""
    text = np.zeros((len(characters), WIDTH), np.uint8)
    if -4 <= exponent < 0:
        text[:, : 1 - exponent] = _ZERO
        text[:, 1] = _POINT
        text[:, 1 - exponent : 18 - exponent] = characters
    elif 0 <= exponent < 16:
        text[:, : exponent + 1] = np.maximum(characters[:, : exponent + 1], _ZERO)
        text[:, exponent + 1] = _POINT
        text[:, exponent + 2] = np.maximum(characters[:, exponent + 1], _ZERO)
        text[:, exponent + 3 : 18] = characters[:, exponent + 2 :]
    else:
        power = b"e%+03d" % exponent
        text[:, 0], text[:, 2:18] = characters[:, 0], characters[:, 1:]
        text[:, 1] = np.where(characters[:, 1], _POINT, 0)
        text[:, 18 : 18 + len(power)] = np.frombuffer(power, np.uint8)
    return text


_EXACT = 10.0 ** np.arange(23)
"""Powers of ten that are float64 themselves."""

_CLOSE = 1.0 - 2.0**-40
"""Of half a gap between two floats: a number nearer to the middle goes to `float`, for it is known to 2^-50 of it."""


def nearest_floats(digits: np.ndarray, exponent: np.ndarray) -> np.ndarray:
    """The float64 nearest to digits x 10^exponent of each, as `float` reads it: int64 (n,), digits 0 to 9e18."""
    power = _EXACT.take(np.abs(exponent), mode="clip")
    number = digits.astype(np.float64)
    values = np.where(exponent < 0, number / power, number * power)  # of two exact numbers
    rows = np.flatnonzero((digits > 2**53) | (np.abs(exponent) > 22))
    if rows.size:
        values[rows] = _rounded_once(digits[rows], exponent[rows])
    return values


def _rounded_once(digits: np.ndarray, exponent: np.ndarray) -> np.ndarray:
    is_near = np.abs(exponent) < 200  # all products are normal numbers
    high, low = _powers_of_ten(np.where(is_near, exponent, 0))
    number = digits.astype(np.float64)
    rest = (digits - number.astype(np.int64)).astype(np.float64)
    product = number * high
    values, left = two_sum(product, product_error(number, high, product) + (number * low + rest * high))
    at_power_of_two = (values.view(np.int64) & (2**52 - 1)) == 0
    doubt = ~is_near | at_power_of_two | (np.abs(left) > 0.5 * _CLOSE * np.spacing(values))
    for row in np.flatnonzero(doubt):
        values[row] = float(f"{digits[row]}e{exponent[row]}")
    return values
