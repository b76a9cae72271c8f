"""How one dome is drawn: colours, letters and numbers; patches, rim and marks."""

from __future__ import annotations

import copy
import difflib
import enum
import itertools
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.picture import ANGLE, Dome, Picture, Quantity, Symbol

EXTRA = "plot"
"""The extra that installs matplotlib."""

SIZES_PX = (300, 8000)
"""Smallest and largest width of a picture."""

VOID_COLOUR = "#d4d4d4"
"""Patches without light: a grey that neither colour map has."""

NormWord = Literal["log", "linear"]
NORMS = get_args(NormWord)
"""Norms that have names."""

_SEQUENTIAL, _DIVERGING = "viridis", "RdBu_r"  # for every kind of colour vision
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


def width_of(size_px: int) -> float:
    """Width of a picture of so many dots: letters grow with its square root, so that they suit all sizes. [inch]"""
    if not SIZES_PX[0] <= size_px <= SIZES_PX[1]:
        raise UsageError(f"a picture is {SIZES_PX[0]} to {SIZES_PX[1]} dots wide, got {size_px}")
    return 6.4 * math.sqrt(size_px / 960.0)


class Normalize(Protocol):
    """A norm of matplotlib, for type checkers: the package is optional."""

    autoscale_None: Callable[..., None]  # noqa: N815


@dataclass(frozen=True, kw_only=True, slots=True)
class ColourChoice:
    """Options of the colours; see `aomc_sky.plot`."""

    limits: Sequence[float] | None = None
    cmap: Any = None
    norm: NormWord | Normalize | None = None


USUAL_COLOURS = ColourChoice()


@dataclass(frozen=True, kw_only=True, slots=True)
class Colours:
    """From values to colours, as matplotlib has them; masked values have `VOID_COLOUR`."""

    norm: Any
    cmap: Any
    extend: str


def colours_of(picture: Picture, choice: ColourChoice = USUAL_COLOURS) -> Colours:
    """Colours for all domes of a picture, by default logarithmic over at most four decades.

    By default linear colours start at zero. Those of pulls are linear and reach from -4 to 4, at most from -8 to 8.
    """
    values = np.concatenate([dome.values[dome.has_colour(picture.quantity)] for dome in picture.domes])
    norm = _norm_of(values, choice, picture.quantity)
    usual = picture.quantity.cmap or (_DIVERGING if picture.quantity.is_signed else _SEQUENTIAL)
    cmap = _cmap_of(choice.cmap or usual)
    below, above = bool(np.any(values < norm.vmin)), bool(np.any(values > norm.vmax))
    extend = ("both" if above else "min") if below else "max" if above else "neither"
    return Colours(norm=norm, cmap=cmap.with_extremes(bad=VOID_COLOUR), extend=extend)


def _norm_of(values: np.ndarray, choice: ColourChoice, quantity: Quantity) -> Any:
    """The norm that was chosen, with limits."""
    is_signed = quantity.is_signed or quantity.span is not None
    colors = optional_module("matplotlib.colors", extra=EXTRA)
    if isinstance(choice.norm, colors.Normalize):
        if choice.limits is not None:
            raise UsageError("limits and a norm of matplotlib exclude each other: give the norm its limits")
        norm = copy.copy(choice.norm)
        norm.autoscale_None(values[np.isfinite(values)] if values.size else np.array([0.1, 1.0]))
        return norm
    kind = choice.norm or ("linear" if is_signed else "log")
    if kind not in NORMS or (is_signed and kind == "log"):
        allowed = "linear" if is_signed else "log, linear"
        raise UsageError(f"norm must be one of {allowed}, or a norm of matplotlib, got {choice.norm!r}")
    if choice.limits is not None:
        low, high = _checked(choice.limits, is_logarithmic=kind == "log")
    elif quantity.span is not None:
        low, high = quantity.span
    elif kind == "linear" and not is_signed:
        low, high = 0.0, float(values.max(initial=_LEAST_LIGHT))
    else:
        low, high = _limits(values, is_signed=is_signed)
    return colors.LogNorm(low, high) if kind == "log" else colors.Normalize(low, high)


def _cmap_of(cmap: Any) -> Any:
    maps = optional_module("matplotlib", extra=EXTRA).colormaps
    if not isinstance(cmap, str):
        return cmap
    if cmap not in maps:
        near = difflib.get_close_matches(cmap, maps, n=3)
        advice = f"; near it are {', '.join(near)}" if near else "; for example viridis, magma, cividis, gray"
        raise UsageError(f"matplotlib has no colour map {cmap!r}{advice}")
    return maps[cmap]


def _checked(limits: Sequence[float], *, is_logarithmic: bool) -> tuple[float, float]:
    low, high = (float(x) for x in limits)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise UsageError(f"the range of colours is two increasing numbers, got {low:g} and {high:g}")
    if is_logarithmic and low <= 0:
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
    """Round numbers on a bar: as many as there is room for, so that no two of them touch."""
    ticker = optional_module("matplotlib.ticker", extra=EXTRA)
    if type(colours.norm).__name__ == "Normalize":
        bar.ax.xaxis.set_major_locator(ticker.MaxNLocator(nbins=max(min(most, 9), 1), steps=[1, 2, 5, 10]))
        bar.ax.xaxis.get_major_formatter().set_useMathText(True)
        if (colours.norm.vmin, colours.norm.vmax) == ANGLE.span:
            bar.set_ticks(np.linspace(*ANGLE.span, 5 if most >= 5 else 3))
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


_WIDEST_DEG = 2.0
_BELOW_AT_DEG = 84.0
_BEYOND = 1e300
_LETTERS = {0.0: "E", 90.0: "N", 180.0: "W", 270.0: "S"}
_NUMBERED_EM = 20.7
_NUMBER_EM, _BESIDE_EM = 2.4, 1.25  # of two digits and a degree sign, with a gap, and with half a letter before them
_GAP_IN = 0.04
_RULER = (30.0, 60.0, 90.0)
_NUMBERS = (_RULER, _RULER[::2], _RULER[2:])
"""Numbers of the ruler, from those of a large dome to that of a small one."""

_SIDES = {-1: "right", 0: "center", 1: "left"}
_HEIGHTS = {-1: "top", 0: "center", 1: "bottom"}


@dataclass(frozen=True, kw_only=True, slots=True)
class Panel:
    """Sizes of the axes of a dome."""

    width_in: float
    font_pt: float
    view: View
    top_em: float = 1.35  #: Height of the letters north and south; more is a gap to what is above and below

    @property
    def has_azimuths(self) -> bool:
        """Whether there is room for azimuths between the points of the compass."""
        return 72 * self.width_in > _NUMBERED_EM * self.font_pt

    @property
    def side_in(self) -> float:
        """Room for the letters east and west."""
        return _GAP_IN + self.font_pt / 72

    @property
    def top_in(self) -> float:
        """Room for the letters north and south."""
        return _GAP_IN + self.top_em * self.font_pt / 72

    @property
    def height_in(self) -> float:
        """Height of the axes."""
        return self.width_in - 2 * (self.side_in - self.top_in)

    @property
    def degrees_per_inch(self) -> float:
        """Zenith angle to an inch."""
        return 180.0 / (self.width_in - 2 * self.side_in)


ViewWord = Literal["above", "below"]


class View(enum.Enum):
    """From where the dome is seen; north is up either way.

    ABOVE
        As a map: east to the right, azimuth from +x towards +y counterclockwise.
    BELOW
        As seen by an eye that looks up: east to the left, azimuth clockwise.
    """

    ABOVE = "above"
    BELOW = "below"

    @property
    def sentence(self) -> str:
        """The sentence of the caption."""
        if self is View.ABOVE:
            seen, side, way = "above, as a map", "right", "anticlockwise"
        else:
            seen, side, way = "below, looking up", "left", "clockwise"
        return (
            f"Seen from {seen}: north (+y) up, east (+x) on the {side}; azimuth from 0° in the east to 90° in the "
            f"north, {way}."
        )


def drawn_at(zenith_deg: Any, azimuth_deg: Any, view: View) -> tuple[np.ndarray, np.ndarray]:
    """Position of sky directions on the picture, right and up, in degrees: the zenith angle is the radius."""
    sine, cosine = sin_cos_deg(azimuth_deg)
    radius = np.asarray(zenith_deg, dtype=np.float64)
    return radius * (cosine if view is View.ABOVE else -cosine), radius * sine


def draw_dome(axes: Any, dome: Dome, quantity: Quantity, colours: Colours, panel: Panel) -> Any:
    """Draw a dome on axes as large as the panel says; the QuadMesh of its patches is returned.

    Its array has a row for each ring. Columns wider than 2 degrees are repeated: their straight edges follow the arc
    within 1.5e-4 of the radius.
    """
    axes.set_axis_off()
    half = panel.degrees_per_inch / 2
    axes.set_xlim(-half * panel.width_in, half * panel.width_in)
    axes.set_ylim(-half * panel.height_in, half * panel.height_in)
    mesh = _draw_patches(axes, dome, quantity, colours, panel.view)
    _draw_rings(axes, panel, "#777777" if quantity.is_signed or quantity is ANGLE else "white")
    _draw_ruler(axes, panel)
    _draw_directions(axes, panel)
    for mark in dome.marks:
        zenith = _BELOW_AT_DEG if mark.symbol is Symbol.SUN_BELOW else mark.zenith_deg
        where = drawn_at(zenith, mark.azimuth_deg, panel.view)
        draw_mark(axes, *where, mark.symbol, panel.font_pt)
    return mesh


def _draw_patches(axes: Any, dome: Dome, quantity: Quantity, colours: Colours, view: View) -> Any:
    axes.fill(*drawn_at(90.0, np.linspace(0.0, 360.0, 361), view), color=VOID_COLOUR, linewidth=0.0, zorder=0)
    zenith, azimuth, repeats = mesh_edges(dome.grid)
    x, y = drawn_at(zenith[:, None], azimuth[None, :], view)
    finite = np.clip(dome.values, -_BEYOND, _BEYOND)  # matplotlib would hide an infinite pull
    values = np.ma.masked_array(finite, ~dome.has_colour(quantity))
    shown = values.reshape(dome.grid.n_zenith, dome.grid.n_azimuth).repeat(repeats, axis=1)
    style = {"norm": colours.norm, "cmap": colours.cmap, "rasterized": True, "linewidth": 0.0, "snap": False}
    # The background shines through between neighbours with smooth edges, so patches without smooth edges lie below.
    # A second smooth mesh hides their jags. `snap` would move the corners of patches to whole dots.
    for is_smooth in (False, True, True):
        mesh = axes.pcolormesh(x, y, shown, antialiased=is_smooth, **style)
    return mesh


def mesh_edges(grid: PatchGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges of the rings, edges of columns no wider than 2 degrees, and how many of these each column has."""
    zenith = np.append(grid.zenith_bounds_deg[:, 0], grid.zenith_bounds_deg[-1, 1])
    start, width = grid.azimuth_bounds_deg[:, 0], np.diff(grid.azimuth_bounds_deg, axis=1).ravel()
    repeats = np.maximum(np.ceil(width / _WIDEST_DEG - 1e-9), 1).astype(int)
    parts = [a + w * np.arange(n) / n for a, w, n in zip(start, width, repeats, strict=True)]
    return zenith, np.append(np.concatenate(parts), grid.azimuth_bounds_deg[-1, 1]), repeats


def ink() -> Any:
    """The colour of letters in the style of the user, such as `dark_background`."""
    return optional_module("matplotlib", extra=EXTRA).rcParams["text.color"]


def _pale() -> dict[str, Any]:
    """The style of less important letters and lines: #555555 where black is the colour of letters on white."""
    return {"color": ink(), "alpha": 2 / 3}


def _draw_rings(axes: Any, panel: Panel, colour: str) -> None:
    around, view = np.linspace(0.0, 360.0, 361), panel.view
    for ring in (30.0, 60.0):
        axes.plot(*drawn_at(ring, around, view), color=colour, alpha=0.45, linewidth=0.6)
    for azimuth in _directions(panel):
        axes.plot(*drawn_at([0.0, 90.0], azimuth, view), color=colour, alpha=0.3, linewidth=0.5)
    axes.plot(*drawn_at(90.0, around, view), color=ink(), linewidth=0.8)


def _draw_ruler(axes: Any, panel: Panel) -> None:
    """Zenith angles of the rings and the rim, below the dome, where no patch is hidden."""
    inch = panel.degrees_per_inch
    top = -90.0 - 0.6 * _GAP_IN * inch
    font_pt = 0.8 * panel.font_pt
    style = {"ha": "center", "va": "top", "fontsize": font_pt, **_pale()}
    room_pt = 72 * _RULER[0] / inch  # between two of them, and between the letter of south and the first
    numbers = _NUMBERS[int(room_pt < _NUMBER_EM * font_pt) + int(room_pt < _BESIDE_EM * panel.font_pt)]
    for angle in _RULER:
        axes.plot([angle, angle], [top, top - 0.03 * inch], linewidth=0.6, **_pale())
        if angle in numbers:
            axes.text(angle, top - 0.045 * inch, f"{angle:g}°", **style)
    axes.plot([_RULER[0], _RULER[-1]], [top, top], linewidth=0.6, **_pale())


def _directions(panel: Panel) -> np.ndarray:
    return np.arange(0.0, 360.0, 45.0 if panel.has_azimuths else 90.0)


def _draw_directions(axes: Any, panel: Panel) -> None:
    """Letters of the compass, and azimuths between them: "90° N" would read as a latitude."""
    radius = 90.0 + _GAP_IN * panel.degrees_per_inch
    for azimuth in _directions(panel):
        x, y = (float(v) for v in drawn_at(radius, azimuth, panel.view))
        letter = _LETTERS.get(float(azimuth), "")
        number = f"azimuth\n{azimuth:g}°" if azimuth == 45.0 else f"{azimuth:g}°"
        across, up = (round(v / radius) for v in (x, y))
        size, colour = (panel.font_pt, {"color": ink()}) if letter else (0.85 * panel.font_pt, _pale())
        style = {"ha": _SIDES[across], "va": _HEIGHTS[up], "fontsize": size, "linespacing": 1.3, **colour}
        axes.text(x, y, letter or number, **style)


_COMPASS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


def draw_mark(axes: Any, x: Any, y: Any, symbol: Symbol, font_pt: float) -> None:
    """Draw a mark at data coordinates."""
    for style in mark_styles(symbol, font_pt):
        axes.plot([float(x)], [float(y)], **style)


def mark_styles(symbol: Symbol | str, font_pt: float) -> list[dict[str, Any]]:
    """Lines of a mark as large as a letter: white in a dark rim, so that it shows on any colour.

    A word instead of a symbol is the meaning of patches without a colour.
    """
    effects = optional_module("matplotlib.patheffects", extra=EXTRA)
    size = 1.05 * font_pt
    if not isinstance(symbol, Symbol):
        edge = {"markeredgecolor": "#888888", "markeredgewidth": 0.6}
        return [{"marker": "s", "markersize": font_pt, "markerfacecolor": VOID_COLOUR, "linestyle": "none", **edge}]
    rim = [effects.withStroke(linewidth=0.3 * font_pt, foreground="black")]
    line = {"linestyle": "none", "clip_on": False, "zorder": 5, "path_effects": rim, "markeredgewidth": 0.13 * font_pt}
    ring = {"marker": "o", "markersize": size, "markerfacecolor": "none", "markeredgecolor": "white"}
    ring |= {"gid": f"mark-{symbol.name.lower()}", **line}
    if symbol is Symbol.SUN_BELOW:
        ring |= {"marker": "^", "markerfacecolor": "white"}
    if symbol is Symbol.SUN_OF_AMC:
        strokes = [(0.5 * x, 0.5 * y) if k == 0 else (x, y) for x, y in _COMPASS for k in (0, 1)]
        ring |= {"marker": optional_module("matplotlib.path", extra=EXTRA).Path(strokes, [1, 2] * 4)}
        ring["markersize"] = 1.35 * size
    if symbol is Symbol.LOBE:
        ring["marker"] = "D"
    dot = {"marker": "o", "markersize": 0.3 * size, "color": "white", **line}
    return [ring, dot] if symbol is Symbol.BEAM else [ring]
