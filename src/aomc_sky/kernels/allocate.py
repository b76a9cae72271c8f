"""Allocations that go cell by cell: multinomial, and the AOMC program's rounding."""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.kernels.arithmetic.constants import ONE, U64, ZERO
from aomc_sky.kernels.arithmetic.elementary import exp_level, log_level, uniform_f64
from aomc_sky.kernels.arithmetic.rng import philox_pair
from aomc_sky.kernels.jit import inner, kernel

_WHOLE = np.uint64(1 << 62)
_INVERSION_LIMIT = 10.0
_TAIL = 1e-20


@inner
def _log1p(x):
    """log(1 + x) for x > -1, within 3 ulp (Kahan's quotient)."""
    y = 1.0 + x
    if y == 1.0:
        return x
    return log_level(y) * (x / (y - 1.0))


@inner
def _stirling_rest(k):
    """Log k! - ((k + 1/2) log(k + 1) - (k + 1) + log(2 pi) / 2); absolute error below 1e-11."""
    if k < 10.0:
        factorial = np.float64(1.0)
        j = 2.0
        while j <= k:
            factorial *= j
            j += 1.0
        return log_level(factorial) - ((k + 0.5) * log_level(k + 1.0) - (k + 1.0) + 0.9189385332046728)
    x = k + 1.0
    y = 1.0 / (x * x)
    return (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - y / 1680.0) * y) * y) / x


@inner
def _uniforms(key, cell, band, draw):
    a, b = philox_pair(key, cell, band, draw)
    return uniform_f64(a), uniform_f64(b)


@inner
def _binomial_by_inversion(n, p, u):
    """Smallest k whose distribution function exceeds u, for n p below 10 and p up to 1/2.

    Rounding may leave a rest of u that no later term uses up. Beyond the mean, the search therefore ends when the rest
    of the distribution is far below 2^-53, the resolution of u.
    """
    term = exp_level(n * _log1p(-p))
    odds = p / (1.0 - p)
    mean = n * p
    k = 0.0
    while u >= term and k < n:
        u -= term
        k += 1.0
        term *= odds * (n - k + 1.0) / k
        if k > mean and term < _TAIL:
            break
    return k


@inner
def _mode_constants(n, p, mode):
    """The parts of `_log_ratio` that do not depend on k."""
    slope = log_level((p / (1.0 - p)) * ((n - mode + 1.0) / (mode + 1.0)))
    return slope, _stirling_rest(mode) + _stirling_rest(n - mode)


@inner
def _log_ratio(n, k, mode, slope, at_mode):
    """Log of the probability of k over that of the mode, in a form that does not cancel for large n.

    log k! = (k + 1/2) log(k + 1) - (k + 1) + rest: differences of the large terms are log1p of a ratio.
    """
    d = k - mode
    return (
        d * slope
        - (k + 0.5) * _log1p(d / (mode + 1.0))
        + (n - k + 0.5) * _log1p(d / (n - k + 1.0))
        + at_mode
        - _stirling_rest(k)
        - _stirling_rest(n - k)
    )


@inner
def _binomial_by_rejection(n, p, key, cell, band):
    """Transformed rejection with squeeze, Hoermann's BTRS (1993), for n p (1 - p) from 5 and p up to 1/2."""
    q = 1.0 - p
    spread = math.sqrt(n * p * q)
    b = 1.15 + 2.53 * spread
    a = -0.0873 + 0.0248 * b + 0.01 * p
    centre = n * p + 0.5
    inside = 0.92 - 4.2 / b
    alpha = (2.83 + 5.1 / b) * spread
    mode = np.floor((n + 1.0) * p)
    slope, at_mode = _mode_constants(n, p, mode)
    draw = ZERO
    while True:
        u, v = _uniforms(key, cell, band, draw)
        draw += ONE
        u -= 0.5
        us = 0.5 - abs(u)
        if us == 0.0 or v == 0.0:
            continue
        k = np.floor((2.0 * a / us + b) * u + centre)
        if us >= 0.07 and v <= inside:
            return k
        if k < 0.0 or k > n:
            continue
        if log_level(v * alpha / (a / (us * us) + b)) <= _log_ratio(n, k, mode, slope, at_mode):
            return k


@inner
def _binomial(n, part, rest, key, cell, band):
    """Photons out of n that fall on a part of the rest; part < rest, both in units of 2^-62."""
    other = rest - part
    flipped = part > other
    # the smaller side from integers: 1 - p in floats has lost its digits where p is close to 1
    small = np.float64(other if flipped else part) / np.float64(rest)
    if n * small < _INVERSION_LIMIT:
        k = _binomial_by_inversion(n, small, _uniforms(key, cell, band, ZERO)[0])
    else:
        k = _binomial_by_rejection(n, small, key, cell, band)
    return n - k if flipped else k


@kernel
def multinomial_counts(cumulative, n, key, band, counts):
    """Conditional binomials, cell by cell; cell i draws from counter (i, band, draw) of the key."""
    left = np.float64(n)
    for i in range(counts.size):
        mass = cumulative[i + 1] - cumulative[i]
        rest = _WHOLE - cumulative[i]
        if mass == ZERO or left == 0.0:
            counts[i] = 0
        elif mass == rest:
            counts[i] = np.int64(left)
            left = 0.0
        else:
            k = _binomial(left, mass, rest, key, U64(i), band)
            counts[i] = np.int64(k)
            left -= k


@inner
def _nint(x):
    """Nearest integer of a float32, halves away from zero, as Fortran's NINT."""
    y = np.float64(x)
    return np.int64(np.floor(y + 0.5)) if y >= 0 else np.int64(np.ceil(y - 0.5))


@kernel
def aomc_counts(weight, n, counts):
    """The AOMC 1.2.2 program's photons per patch; weight float32 and counts int64 (n_zenith, n_azimuth)."""
    total = np.float32(0)
    for a in range(weight.shape[1]):
        for z in range(weight.shape[0]):
            total = np.float32(total + weight[z, a])
    iterations = np.float32(n)
    running = 0
    launched = 0
    for z in range(weight.shape[0]):
        for a in range(weight.shape[1]):
            counts[z, a] = 0
            if total > np.float32(0):
                share = np.float32(weight[z, a] / total)
                photons = np.float32(_nint(np.float32(share * iterations)))
                running = _nint(np.float32(photons + np.float32(running)))
                if running > launched:
                    counts[z, a] = running - launched
                    launched = running
