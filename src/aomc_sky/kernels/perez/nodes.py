"""Gauss points of the integrals over tiles, and when two orders of them agree: numbers for both forms of the sums.

Points and weights on (0, 1) come from 40 digits: numpy computes them with a library that may differ.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.perez.law import HALF_PI

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

STEP = HALF_PI * HALF_PI
"""A square of quarter turns. [sr]"""

SNAP = 1e-12
"""Length below which the sun stands on an edge of a patch. [quarter turns]"""

X3 = np.array([0.11270166537925831, 0.5, 0.8872983346207417])
W3 = np.array([0.2777777777777778, 0.4444444444444444, 0.2777777777777778])
X4 = np.array([0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263])
W4 = np.array([0.17392742256872692, 0.32607257743127305, 0.32607257743127305, 0.17392742256872692])
X6 = np.array(
    [
        0.03376524289842399,
        0.16939530676686773,
        0.38069040695840156,
        0.6193095930415985,
        0.8306046932331322,
        0.966234757101576,
    ]
)
W6 = np.array(
    [
        0.08566224618958518,
        0.1803807865240693,
        0.23395696728634552,
        0.23395696728634552,
        0.1803807865240693,
        0.08566224618958518,
    ]
)
X8 = np.array(
    [
        0.019855071751231884,
        0.10166676129318664,
        0.2372337950418355,
        0.4082826787521751,
        0.591717321247825,
        0.7627662049581645,
        0.8983332387068134,
        0.9801449282487681,
    ]
)
W8 = np.array(
    [
        0.05061426814518813,
        0.11119051722668724,
        0.15685332293894363,
        0.181341891689181,
        0.181341891689181,
        0.15685332293894363,
        0.11119051722668724,
        0.05061426814518813,
    ]
)
X10 = np.array(
    [
        0.01304673574141414,
        0.06746831665550775,
        0.1602952158504878,
        0.2833023029353764,
        0.4255628305091844,
        0.5744371694908156,
        0.7166976970646236,
        0.8397047841495122,
        0.9325316833444922,
        0.9869532642585859,
    ]
)
W10 = np.array(
    [
        0.03333567215434407,
        0.0747256745752903,
        0.10954318125799102,
        0.13463335965499817,
        0.14776211235737644,
        0.14776211235737644,
        0.13463335965499817,
        0.10954318125799102,
        0.0747256745752903,
        0.03333567215434407,
    ]
)

NODES, WEIGHTS = np.zeros((11, 10)), np.zeros((11, 10))
"""The same with a row per order."""
for _x, _w in ((X3, W3), (X4, W4), (X6, W6), (X8, W8), (X10, W10)):
    NODES[_x.size, : _x.size] = _x
    WEIGHTS[_x.size, : _x.size] = _w
