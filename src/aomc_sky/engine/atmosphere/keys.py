"""What becomes of the sizes and numbers of points that a description asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.formats.atmo.keys import SIZES

DEFAULT_BINS = (45, 180)
"""Equal bins of zenith and azimuth, where neither the user nor the description asks for others."""

DEFAULT_GLOW_ROWS = 18
MOST_BINS = 3600
MOST_SUNS = 1000

ZENITH_ROWS = "scattering texture size for vza"
AZIMUTH_COLUMNS = "scattering texture size for dot(view,sun)"
SUNS = "scattering texture size for sza"
GLOW_ROWS = "light pollution texture size for vza"


@dataclass(frozen=True, kw_only=True, slots=True)
class KeyUse:
    """What a key of the description means here."""

    #: "mapped": it is a size of the table; "met": a lower bound, which the accuracy of the solver exceeds; "unused":
    #: there is nothing here that it could set
    use: str
    why: str  #: to what, or for what reason


_RAYS = KeyUse(use="met", why="optical depths are quadratures along each ray, to 1e-10; there is no table of them")
_IRRADIANCE = KeyUse(use="unused", why="each sun has its own irradiance of the ground; there is no table")
_SEA_LEVEL = KeyUse(use="unused", why="the observer stands at sea level")
_ECLIPSE = KeyUse(use="unused", why="an eclipse is solved in the patches of the table, under one sun and one Moon")
_PATHS = KeyUse(use="unused", why="all orders of an eclipse come from backward paths")

KEY_USES: dict[str, KeyUse] = {
    "transmittance texture size for vza": _RAYS,
    "transmittance texture size for altitude": _RAYS,
    "irradiance texture size for sza": _IRRADIANCE,
    "irradiance texture size for altitude": _IRRADIANCE,
    ZENITH_ROWS: KeyUse(use="mapped", why="its half above the horizon are the zenith rows of the table"),
    AZIMUTH_COLUMNS: KeyUse(use="mapped", why="azimuth columns of the table"),
    SUNS: KeyUse(use="mapped", why="number of suns of --sun-zenith all"),
    "scattering texture size for altitude": _SEA_LEVEL,
    "eclipsed scattering texture size for relative azimuth": _ECLIPSE,
    "eclipsed scattering texture size for vza": _ECLIPSE,
    "eclipsed double scattering texture size for relative azimuth": _ECLIPSE,
    "eclipsed double scattering texture size for vza": _ECLIPSE,
    "eclipsed double scattering texture size for sza": _ECLIPSE,
    "eclipsed double scattering number of azimuth pairs to sample": _PATHS,
    "eclipsed double scattering number of elevation pairs to sample": _PATHS,
    GLOW_ROWS: KeyUse(use="mapped", why="its half above the horizon are the rows of --save-light-pollution"),
    "light pollution texture size for altitude": _SEA_LEVEL,
    "light pollution angular integration points": KeyUse(
        use="unused", why="the light of the ground comes from backward paths, with a standard error"
    ),
    "transmittance integration points": _RAYS,
    "radial integration points": KeyUse(
        use="mapped", why="points of order 1 along a line, at least; its own 100 to 600 are good to 1e-6"
    ),
    "angular integration points": KeyUse(
        use="mapped", why="half its root is the least number of Gauss nodes of a hemisphere of sos; 20 are enough"
    ),
    "angular integration points for eclipse": _PATHS,
}
"""Of every key of `SIZES`."""

assert KEY_USES.keys() == set(SIZES)


def bins_of(sizes: Mapping[str, int]) -> tuple[int, int]:
    """Rows and columns of the table that a description asks for, 3600 at most, those by default where it does not."""
    rows = sizes[ZENITH_ROWS] // 2 if ZENITH_ROWS in sizes else DEFAULT_BINS[0]
    return min(max(rows, 1), MOST_BINS), min(sizes.get(AZIMUTH_COLUMNS, DEFAULT_BINS[1]), MOST_BINS)


def suns_of(sizes: Mapping[str, int]) -> tuple[float, ...]:
    """Zenith angles of as many suns as a description asks for, evenly from 0 to 90. [deg]

    UsageError where the description does not say how many, or more than 1000.
    """
    if SUNS not in sizes:
        raise UsageError(f'--sun-zenith all: the description has no "{SUNS}"')
    if sizes[SUNS] > MOST_SUNS:
        raise UsageError(f'--sun-zenith all: "{SUNS}" is {sizes[SUNS]}, {MOST_SUNS} is the most')
    return tuple(round(float(sun), 10) for sun in np.linspace(0.0, 90.0, sizes[SUNS]))


def glow_rows(sizes: Mapping[str, int]) -> int:
    """Zenith angles of the light of the ground that a description asks for; 18 where it does not. [1 or more]"""
    return max(sizes[GLOW_ROWS] // 2, 1) if GLOW_ROWS in sizes else DEFAULT_GLOW_ROWS


def size_report(sizes: Mapping[str, int]) -> dict[str, dict[str, int | str]]:
    """Every size that a description gives, with its meaning here: JSON values."""
    return {key: {"value": sizes[key], "use": KEY_USES[key].use, "why": KEY_USES[key].why} for key in sorted(sizes)}
