"""How pictures look: sizes, colours, scales and their ticks."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.pictures.content import Picture

EXTRA = "plot"
"""The extra that installs matplotlib."""

SIZES_PX = (300, 8000)
"""Smallest and largest width of a picture."""

VOID_COLOUR = "#d4d4d4"
"""Patches without light: a grey that neither colour map has."""

_SEQUENTIAL, _DIVERGING = "viridis", "RdBu_r"  # both can be told apart with every kind of colour vision
_MOST_DECADES = 4.0
_LEAST_LIGHT = 1e-200  # smaller numbers have no digits left for a scale
_LEAST_RATIO = 2.0
_PLAIN = 1e-3, 1e5  # between these a bar has plain numbers, else powers of ten
_STEPS: tuple[tuple[float, ...], ...] = (
    (1.0,),
    (1.0, 3.0),
    (1.0, 2.0, 5.0),
    (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0),
    (*(n / 10 for n in range(10, 20, 2)), *(n / 10 for n in range(20, 100, 5))),
    tuple(n / 20 for n in range(20, 200)),
)
"""Mantissas of the numbers of a bar, from few to many."""
_LEAST_PULL, _MOST_PULL = 4.0, 8.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Scale:
    """Width of a picture in inches, its dots per inch, and its letters."""

    #: Width. [inch]
    width_in: float
    #: Dots per inch.
    dpi: float

    @classmethod
    def of(cls, size_px: int) -> Scale:
        """The scale of a picture `size_px` wide: letters grow with the square root of the size.

        Letters of a fixed number of dots would be lost on a large picture, letters that grow with the picture cannot
        be read on a small one.
        """
        if not SIZES_PX[0] <= size_px <= SIZES_PX[1]:
            raise UsageError(f"a picture is {SIZES_PX[0]} to {SIZES_PX[1]} dots wide, got {size_px}")
        width = 6.4 * math.sqrt(size_px / 960.0)
        return cls(width_in=width, dpi=size_px / width)


@dataclass(frozen=True, kw_only=True, slots=True)
class Colours:
    """Values to colours."""

    #: Limits and scale.
    norm: Any
    #: Colours; that of masked values is `VOID_COLOUR`.
    cmap: Any
    #: Ends of the bar beyond which values lie. One of "neither", "min", "max", "both".
    extend: str


def colours_of(picture: Picture, limits: Sequence[float] | None = None) -> Colours:
    """Colours that serve all domes of a picture: logarithmic, for pulls linear.

    By default the ends of the bar are those of the domes, at most four decades, and for pulls as far from zero on both
    sides, 4 to 8. Given limits must be two rising numbers, positive where colours are logarithmic.
    """
    colors = optional_module("matplotlib.colors", extra=EXTRA)
    is_signed = picture.quantity.is_signed
    values = np.concatenate([dome.values[dome.has_colour(picture.quantity)] for dome in picture.domes])
    low, high = _checked(limits, is_signed=is_signed) if limits is not None else _limits(values, is_signed=is_signed)
    norm = colors.Normalize(low, high) if is_signed else colors.LogNorm(low, high)
    maps = optional_module("matplotlib", extra=EXTRA).colormaps
    cmap = maps[_DIVERGING if is_signed else _SEQUENTIAL].with_extremes(bad=VOID_COLOUR)
    below, above = bool(np.any(values < low)), bool(np.any(values > high))
    return Colours(
        norm=norm, cmap=cmap, extend=("both" if above else "min") if below else "max" if above else "neither"
    )


def palette_of(colours: Colours) -> bytes:
    """256 colours for the frames of an animation: 192 of the map, and greys for letters and lines."""
    mapped = np.rint(255 * colours.cmap(np.linspace(0.0, 1.0, 192))[:, :3])
    greys = np.repeat(np.rint(np.linspace(0.0, 255.0, 63))[:, None], 3, axis=1)
    void = [[int(VOID_COLOUR[k : k + 2], 16) for k in (1, 3, 5)]]
    return np.vstack([mapped, greys, void]).astype(np.uint8).tobytes()


def _checked(limits: Sequence[float], *, is_signed: bool) -> tuple[float, float]:
    low, high = (float(x) for x in limits)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise UsageError(f"the range of colours is two rising numbers, got {low:g} and {high:g}")
    if not is_signed and low <= 0:
        raise UsageError(f"the range of logarithmic colours is positive, got {low:g} to {high:g}")
    return low, high


def _limits(values: np.ndarray, *, is_signed: bool) -> tuple[float, float]:
    if is_signed:
        largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        reach = min(max(math.ceil(largest), _LEAST_PULL), _MOST_PULL)
        return -reach, reach
    if values.size == 0:
        return 0.1, 1.0
    high = max(float(values.max()), _LEAST_LIGHT)
    low = max(float(values.min()), high / 10**_MOST_DECADES)
    if high / low < _LEAST_RATIO:  # nearly even: a scale that does not blow up rounding
        middle = math.sqrt(low) * math.sqrt(high)
        low, high = middle / math.sqrt(_LEAST_RATIO), middle * math.sqrt(_LEAST_RATIO)
    return low, high


def tick_numbers(bar: Any, colours: Colours, *, most: int) -> None:
    """Round numbers on a logarithmic bar: as many as there is room for, so that no two of them touch."""
    ticker = optional_module("matplotlib.ticker", extra=EXTRA)
    if type(colours.norm).__name__ == "LogNorm":
        bar.set_ticks(round_numbers(colours.norm.vmin, colours.norm.vmax, most))
        is_plain = colours.norm.vmin >= _PLAIN[0] and colours.norm.vmax < _PLAIN[1]
        text = "{:g}".format if is_plain else power_text
        bar.ax.xaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: text(value)))
        bar.ax.xaxis.set_minor_formatter(ticker.NullFormatter())


def round_numbers(low: float, high: float, most: int) -> list[float]:
    """Round numbers between two positive ones, none nearer to the next than 1 / `most` of their logarithm."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    within = (low * (1 - 1e-9), high * (1 + 1e-9))
    best: list[float] = []
    for steps in _STEPS:
        every = [step * 10.0**n for n in range(first, last + 1) for step in steps]
        found = [value for value in every if within[0] <= value <= within[1]]
        room = math.log(high / low) / most
        apart = all(math.log(after / before) >= room for before, after in itertools.pairwise(found))
        if apart and len(best) < len(found) <= most:
            best = found
    return best


def power_text(value: float) -> str:
    """A number with a power of ten."""
    exponent = math.floor(math.log10(value) + 1e-9)
    mantissa = f"{value / 10.0**exponent:.3g}"
    return f"$10^{{{exponent}}}$" if mantissa == "1" else f"${mantissa}\\times10^{{{exponent}}}$"


def plain_text(text: str) -> str:
    """Text as it stands, whatever is in a file's name: no formulas, no letters that the font does not have."""
    shown = "".join(c if c == "\n" or (c.isprintable() and ord(c) < 0x530) else "?" for c in text)
    return shown.replace("\\", "/").replace("$", r"\$")


def plain_label(label: str) -> str:
    """A label of a colour bar without the signs of its formulas."""
    return re.sub(r"\$\^\{([^}]*)\}\$", r"\1", label)


def outlined(width: float = 2.0) -> list[Any]:
    """A dark rim, so that white letters can be read on any colour."""
    return [optional_module("matplotlib.patheffects", extra=EXTRA).withStroke(linewidth=width, foreground="black")]
