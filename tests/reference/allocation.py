"""Plain twins of the allocation, in Python integers and fractions."""

import hashlib
import itertools
import math
from fractions import Fraction

import numpy as np

BITS = 62


def fixed_point(mass):
    """The exact cumulative in units of 2^-62, each entry rounded to the nearest, halves up."""
    exact = [Fraction(m) for m in mass]
    total = sum(exact, Fraction(0))
    reached = itertools.accumulate(exact, initial=Fraction(0))
    return [math.floor(s / total * (1 << BITS) + Fraction(1, 2)) for s in reached]


def systematic(cumulative, n, offset):
    floors = [(n * c + offset) >> BITS for c in cumulative]
    return [b - a for a, b in itertools.pairwise(floors)]


def largest_remainder(cumulative, mass, n):
    """Floors, and one more for the largest remainders, ties to the lower index; equal masses tie."""
    units = [b - a for a, b in itertools.pairwise(cumulative)]
    if n * len(units) < 1 << BITS:
        fewest = {}
        for u, m in zip(units, mass, strict=True):
            fewest[m] = min(u, fewest.get(m, u))
        units = [fewest[m] for m in mass]
    products = [n * u for u in units]
    counts = [p >> BITS for p in products]
    rest = [p & ((1 << BITS) - 1) for p in products]
    order = sorted(range(len(counts)), key=lambda i: (-rest[i], i))
    for i in order[: n - sum(counts)]:
        counts[i] += 1
    return counts


def exact_probability(mass):
    total = sum((Fraction(m) for m in mass), Fraction(0))
    return [Fraction(m) / total for m in mass]


def philox_words(key, counter):
    """Philox4x32-10, written down from Salmon et al. (2011), as two 64-bit words."""
    c = list(counter)
    k = [key & 0xFFFFFFFF, key >> 32]
    for round_number in range(10):
        if round_number:
            k = [(k[0] + 0x9E3779B9) % 2**32, (k[1] + 0xBB67AE85) % 2**32]
        high0, low0 = divmod(0xD2511F53 * c[0], 2**32)
        high1, low1 = divmod(0xCD9E8D57 * c[2], 2**32)
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
    return (c[0] << 32) | c[1], (c[2] << 32) | c[3]


def offset_of(seed, band):
    """The 62 bits that shift the ladder of a band: the top of the first word of its own counter."""
    digest = hashlib.sha256(f"aomc-sky/2\0{seed}\0stratified\0allocation".encode()).digest()
    word, _ = philox_words(int.from_bytes(digest[:8], "little"), (0, 0, band, 0))
    return word >> 2


def nint(x):
    """Fortran's NINT: to the nearest whole number, halves away from zero."""
    exact = Fraction(float(x))
    return math.floor(exact + Fraction(1, 2)) if exact >= 0 else math.ceil(exact - Fraction(1, 2))


def aomc(weight, n):
    """The AOMC program's walk over (n_zenith, n_azimuth), one 32-bit operation after the other."""
    single = np.float32
    total = single(0)
    for value in weight.astype(single).T.ravel():
        total = single(total + value)
    counts = np.zeros(weight.shape, dtype=np.int64)
    cumulative = launched = 0
    for z, a in np.ndindex(weight.shape):
        if total <= 0:
            continue
        share = single(single(weight[z, a]) / total)
        photons = single(nint(single(share * single(n))))
        cumulative = nint(single(photons + single(cumulative)))
        counts[z, a] = max(cumulative - launched, 0)
        launched = max(cumulative, launched)
    return counts
