"""The three lobes with 60 digits, from their definitions; masses by plain quadrature over the world's sphere."""

import mpmath as mp

DIGITS = 60


def density(kind, param0, param1, m):
    """Per steradian, for a direction of any length."""
    with mp.workdps(DIGITS):
        x, y, z = (mp.mpf(float(c)) for c in m)
        length = mp.sqrt(x * x + y * y + z * z)
        x, y, z, a, b = x / length, y / length, z / length, mp.mpf(float(param0)), mp.mpf(float(param1))
        if kind == "hg":
            return (1 - a * a) / (4 * mp.pi * (1 + a * a - 2 * a * z) ** mp.mpf(1.5))
        if z <= 0:
            return mp.mpf(0)
        slope2 = (x / a) ** 2 + (y / b) ** 2
        if kind == "ggx":
            return z / (mp.pi * a * b * (slope2 + z * z) ** 2)
        return mp.exp(-slope2 / z**2) / (mp.pi * a * b * z**3)


def direction(kind, param0, param1, u, v):
    """Inverse of the radial law at u and azimuth v of a turn."""
    with mp.workdps(DIGITS):
        u, v, a, b = (mp.mpf(float(c)) for c in (u, v, param0, param1))
        cos, sin = mp.cos(2 * mp.pi * v), mp.sin(2 * mp.pi * v)
        if kind == "hg":
            mu = 2 * u - 1 if a == 0 else (1 + a * a - ((1 - a * a) / (1 - a + 2 * a * u)) ** 2) / (2 * a)
            side = mp.sqrt((1 - mu) * (1 + mu))
            return side * cos, side * sin, mu
        radius = mp.sqrt(u / (1 - u)) if kind == "ggx" else mp.sqrt(-mp.log(1 - u))
        x, y = a * radius * cos, b * radius * sin
        length = mp.sqrt(x * x + y * y + 1)
        return x / length, y / length, 1 / length


def hg_above(g, cosine, weighting):
    """Mass of a tilted lobe above the horizon by its Legendre series, for g up to about 0.9."""
    with mp.workdps(40):
        g, cosine = mp.mpf(float(g)), mp.mpf(cosine)
        total, low, high, order = mp.mpf(0), mp.mpf(1), cosine, 0
        while order < 700:
            if order:
                low, high = high, ((2 * order + 1) * cosine * high - order * low) / (order + 1)
            total += (2 * order + 1) * g**order * low * _half(order, weighting) / 2
            order += 1
        return total


def _half(order, weighting):
    """Integral of P_order(mu), or of mu P_order(mu), over 0 to 1."""
    if weighting == "plain":
        return mp.mpf(1) if order == 0 else (_at_zero(order - 1) - _at_zero(order + 1)) / (2 * order + 1)
    if order == 0:
        return mp.mpf(1) / 2
    if order == 1:
        return mp.mpf(1) / 3
    return -_at_zero(order) / ((order - 1) * (order + 2)) if order % 2 == 0 else mp.mpf(0)


def _at_zero(order):
    if order % 2:
        return mp.mpf(0)
    half = order // 2
    return (-1) ** half * mp.binomial(order, half) / mp.mpf(4) ** half
