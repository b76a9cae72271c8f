"""The two phase functions with 50 digits, from their definitions: cdf by closed form, inverse by bisection."""

import mpmath as mp
import numpy as np

DIGITS = 50


def rayleigh_pdf(mu, gamma):
    g, m = mp.mpf(gamma), mp.mpf(mu)
    return mp.mpf(3) / 8 * (1 + 3 * g + (1 - g) * m**2) / (1 + 2 * g)


def rayleigh_cdf(mu, gamma):
    g, m = mp.mpf(gamma), mp.mpf(mu)
    return mp.mpf(1) / 2 + m * (3 * (1 + 3 * g) + (1 - g) * m**2) / (8 * (1 + 2 * g))


def hg_pdf_sr(mu, g):
    g = mp.mpf(g)
    return (1 - g**2) / (4 * mp.pi * (1 + g**2 - 2 * g * mu) ** mp.mpf(1.5))


def hg_cdf(mu, g):
    """The textbook's form with digits to spare for its cancellation."""
    g = mp.mpf(g)
    if g == 0:
        return (1 + mu) / 2
    with mp.workdps(DIGITS + 40):
        return (1 - g**2) / (2 * g) * (1 / mp.sqrt(1 + g**2 - 2 * g * mu) - 1 / (1 + g))


def inverse(cdf, xi, parameter):
    """mu with cdf(mu) = xi, by bisection to 1e-69, for 1 - mu of a needle may be 1e-45."""
    with mp.workdps(DIGITS + 40):
        xi = mp.mpf(xi)
        if xi in (0, 1):
            return 2 * xi - 1
        if cdf(mp.mpf(0), parameter) == xi:
            return mp.mpf(0)
        low, high = mp.mpf(-1), mp.mpf(1)
        for _ in range(230):
            middle = (low + high) / 2
            if cdf(middle, parameter) < xi:
                low = middle
            else:
                high = middle
        return (low + high) / 2


def ulps(found, exact):
    """Distance of a float from the exact number, in units of the last place of the latter."""
    kind = type(found)
    size = abs(float(exact))
    spacing = float(np.spacing(kind(size))) if size else float(np.finfo(kind).smallest_subnormal)
    return float(abs(mp.mpf(float(found)) - exact) / spacing)
