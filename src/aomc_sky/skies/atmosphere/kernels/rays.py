"""Positions on a straight ray through a spherical atmosphere: + - x / sqrt alone, for arrays and for kernels.

One source gives both the same bits. No difference is taken with a number as large as the earth's radius.
"""

from __future__ import annotations

import numpy as np


def lowest_altitude(radius, altitude, mu):
    """Altitude of the point of a whole straight line that is nearest to the earth's centre; below 0 in the ground."""
    return altitude - (radius + altitude) * mu * mu / (1.0 + np.sqrt((1.0 - mu) * (1.0 + mu)))


def way_from_ground(radius, mu, altitude):
    """Way along a ray from the ground to an altitude, and that altitude's distance from the line's lowest point."""
    rise = altitude * (altitude + 2.0 * radius)
    start = radius * mu
    root = np.sqrt(start * start + rise)
    return rise / (start + root), root
