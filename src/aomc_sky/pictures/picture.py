"""Content of a picture: domes of patches with their values, marks on them, and the quantity of the colours."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.grid import PatchGrid

MOST_PANELS = 12
"""Domes of one picture: more could not be read."""


class Symbol(enum.Enum):
    """Meaning of a mark; the value is its line in the key of the picture."""

    BEAM = "direct beam: marked, not in the colours"
    SUN = "the sun"
    SUN_OF_AMC = "the sun of amc.inp; the light is that of the table alone"
    SUN_BELOW = "azimuth of the sun, which is below the horizon"
    LOBE = "a lobe narrower than a patch: its patches hold the mean"


@dataclass(frozen=True, kw_only=True, slots=True)
class Mark:
    """A direction that is marked on the dome."""

    #: zenith_deg, azimuth_deg: Sky direction, azimuth from +x (east) towards +y (north). [deg, 0 to 180 and any turn]
    zenith_deg: float
    azimuth_deg: float
    symbol: Symbol


@dataclass(frozen=True, kw_only=True, slots=True)
class Quantity:
    """The quantity of the colours."""

    #: Name and unit, beside the colour bar.
    label: str
    #: Colours that part at zero, linear; else logarithmic colours of values from 0.
    is_signed: bool = False
    #: Meaning of patches without a colour.
    void: str = "no light"
    #: Ends of linear colours that are always the same, and their colour map; NaN has no colour.
    span: tuple[float, float] | None = None
    cmap: str = ""


RADIANCE = Quantity(label="radiance [W m$^{-2}$ sr$^{-1}$ nm$^{-1}$]")
RELATIVE_RADIANCE = Quantity(label="radiance / irradiance of the surface [sr$^{-1}$]")
PHOTONS = Quantity(label="photons per steradian [sr$^{-1}$]", void="no photons")
PULL = Quantity(
    label="pull: (photons - expected) / standard deviation", is_signed=True, void="too few photons expected to say"
)

DEGREE = Quantity(label="degree of linear polarisation", span=(0.0, 1.0), cmap="viridis")
ANGLE = Quantity(
    label="angle of polarisation [degrees]", span=(-90.0, 90.0), cmap="twilight", void="no light, or not polarised"
)
STOKES = {"dop": DEGREE, "aop": ANGLE}


@dataclass(frozen=True, kw_only=True, slots=True)
class Dome:
    """One dome: a value for each patch."""

    #: The patches; rings and columns without gaps.
    grid: PatchGrid
    #: Zenith-major, in the unit of the picture; NaN, and 0 where values are no pulls: no colour. Infinite pulls have
    #: the colour beyond the end of the bar. [shape (n_patch,)]
    values: np.ndarray
    #: Above the dome; a second line is smaller.
    title: str = ""
    #: Sun, beam, narrow lobes.
    marks: tuple[Mark, ...] = ()

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.float64).ravel()
        if values.size != self.grid.n_patches:
            raise UsageError(f"{values.size} values do not fit a grid of {self.grid.n_patches} patches")
        values.flags.writeable = False
        object.__setattr__(self, "values", values)

    @property
    def is_hemisphere(self) -> bool:
        """Whether the patches cover the hemisphere."""
        return float(self.grid.solid_angle_sr.sum()) > 2.0 * math.pi * (1.0 - 1e-9)

    def has_colour(self, quantity: Quantity) -> np.ndarray:
        """Which patches have a colour, bool, shape (n_patch,)."""
        return ~np.isnan(self.values) if quantity.is_signed or quantity.span else self.values > 0


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """Domes that share their colours."""

    #: One or more.
    domes: tuple[Dome, ...]
    quantity: Quantity
    #: Above all domes.
    title: str = ""
    #: Sentences below them.
    notes: tuple[str, ...] = ()

    @property
    def sun_sentence(self) -> tuple[str, ...]:
        """The direction of the sun in words, if all domes have the same sun."""
        suns = {(m.zenith_deg, m.azimuth_deg) for dome in self.domes for m in dome.marks if m.symbol in _SUNS}
        return tuple(f"The sun is {direction_words(*sun)}." for sun in suns) if len(suns) == 1 else ()


_SUNS = (Symbol.BEAM, Symbol.SUN, Symbol.SUN_OF_AMC, Symbol.SUN_BELOW)
_POINTS = ("east", "northeast", "north", "northwest", "west", "southwest", "south", "southeast")


def direction_words(zenith_deg: float, azimuth_deg: float) -> str:
    """A sky direction in words, its azimuth also as a compass shows it."""
    if round(zenith_deg, 1) == 0:
        return "at the zenith"
    height = f"{zenith_deg:.3g}° from the zenith" if zenith_deg <= 90 else f"{zenith_deg - 90:.3g}° below the horizon"
    azimuth = round(azimuth_deg, 1) % 360.0
    compass = round((90.0 - azimuth) % 360.0, 1)
    return f"{height} in the {_POINTS[round(azimuth / 45.0) % 8]} (azimuth {azimuth:g}°, compass {compass:g}°)"


def spread(bands: Sequence[int]) -> list[int]:
    """All of some bands, or 12 evenly spread over them, the first and the last among them."""
    if len(bands) <= MOST_PANELS:
        return list(bands)
    return [bands[round(k * (len(bands) - 1) / (MOST_PANELS - 1))] for k in range(MOST_PANELS)]


_LEAST_PULL = 0.005
"""Smaller pulls are rounding."""

PLANNED = (
    "Pulls are against the counts of the plan, which spreads photons evenly: a correct map is white. "
    "Independent photons would give pulls of size 1."
)
DRAWN = "Pulls are against the masses, from which the counts were drawn: correct photons give pulls of size 1."


def pull_picture(maps: Sequence[tuple[str, PatchGrid, np.ndarray]], *, title: str = "", note: str = PLANNED) -> Picture:
    """Maps of pulls side by side, 12 spread over them where there are more; colours part at zero.

    Each is a title, its zones and their pulls: NaN if too few photons are expected. `note` gives the expected size of
    pulls.
    """
    chosen = [maps[k] for k in spread(range(len(maps)))]
    domes = tuple(_pull_dome(*one) for one in chosen)
    hidden = len(maps) - len(chosen)
    notes = (note, f"{len(maps)} wavebands, {len(chosen)} of them shown.") if hidden else (note,)
    return Picture(domes=domes, quantity=PULL, title=title, notes=notes)


def _pull_dome(name: str, grid: PatchGrid, pulls: np.ndarray) -> Dome:
    """A map with its largest pull above it, or why there is none."""
    size = np.nan_to_num(np.abs(pulls), nan=0.0, posinf=np.inf)
    if np.all(np.isnan(pulls)):
        return Dome(grid=grid, values=pulls, title=f"{name}\ntoo few photons for pulls")
    if size.max(initial=0.0) < _LEAST_PULL:  # of photons that a plan spreads evenly
        return Dome(grid=grid, values=pulls, title=f"{name}\nno pull above {_LEAST_PULL:g}")
    return Dome(grid=grid, values=pulls, title=f"{name}\nlargest pull {pulls.ravel()[np.argmax(size)]:+.2f}")
