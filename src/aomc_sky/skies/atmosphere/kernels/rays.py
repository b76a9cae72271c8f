"""Where a straight ray through a spherical atmosphere is: + - x / sqrt alone, for arrays and for kernels to compile.

One source for both gives both the same bits. Nothing is subtracted from something as large as the earth.
"""

from __future__ import annotations

import numpy as np


def lowest_altitude(radius, altitude, mu):
    """Altitude of the point of a whole straight line that is nearest to the earth's centre; below 0 in the ground."""
    return altitude - (radius + altitude) * mu * mu / (1.0 + np.sqrt((1.0 - mu) * (1.0 + mu)))


def way_from_ground(radius, mu, altitude):
    """Way along a ray that leaves the ground under the cosine mu to an altitude, and the altitude's distance from where
    the whole line is lowest.
    """
    rise = altitude * (altitude + 2.0 * radius)
    start = radius * mu
    root = np.sqrt(start * start + rise)
    return rise / (start + root), root
