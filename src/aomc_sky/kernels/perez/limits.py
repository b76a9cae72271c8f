"""When two orders of Gauss points agree on a tile of a Perez sky: numbers that both forms of the sums share."""

from __future__ import annotations

AGREE_4, AGREE_6, AGREE_8 = 2e-10, 1e-9, 3e-11
"""Orders 4, 6 and 8 are taken where they agree to this share of the patch with orders 3, 4 and 6.

The difference is the error of the lower order; that of the one taken is below 1e-11 of the patch.
"""

FAR_4, FAR_6, FAR_8 = 2.0, 0.6, 0.25
"""Half the lengths of a tile between it and the sun from which the agreement of these orders is no accident."""

THIN = 0.25
"""A tile that is narrower in azimuth than this share of its height has half the order in azimuth."""

LONGEST_EDGE = 0.1
"""Longest tile that is integrated at once where the edge of an unlit region crosses it. [rad]"""

SMALLEST = 1e-9
"""Length from which down a tile is taken as it is. [rad]"""

WIDEST_DECAY = 8.0
"""Largest change of the exponent of the aureole over a tile, beyond which Gauss points could miss it."""

NEGLIGIBLE = -40.0
"""Exponent of the aureole from which down it is not there."""

HALF_PI = 1.5707963267948966
STEP = HALF_PI * HALF_PI
SNAP = 1e-12
