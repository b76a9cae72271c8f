"""Masses of tilted lobes above the horizon with 40 digits."""

import mpmath as mp


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
