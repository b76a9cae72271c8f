"""One dome on one pair of axes: exact patches, rings and directions around them, marks."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.content import Dome, Mark, Quantity, Symbol
from aomc_sky.pictures.drawing.style import EXTRA, VOID_COLOUR, Colours, outlined

_WIDEST_DEG = 2.0
_LABEL_SIDES = (67.5, 247.5)
_BELOW_AT_DEG = 84.0
_BEYOND = 1e300
_LETTERS = {0.0: "E", 90.0: "N", 180.0: "W", 270.0: "S"}
_LARGE_IN, _SMALL_IN = 3.4, 2.3
_GAP_IN = 0.04
_SIDES = {-1: "right", 0: "center", 1: "left"}
_HEIGHTS = {-1: "top", 0: "center", 1: "bottom"}


@dataclass(frozen=True, kw_only=True, slots=True)
class Panel:
    """Size of the axes of a dome, and what room that leaves."""

    #: Width of the axes. [inch]
    width_in: float
    #: Size of the letters. [pt]
    font_pt: float
    #: From where the dome is seen.
    view: View

    @property
    def is_large(self) -> bool:
        """Whether there is room for directions between the four main ones."""
        return self.width_in > _LARGE_IN

    @property
    def is_small(self) -> bool:
        """Whether the main directions are letters without their degrees."""
        return self.width_in < _SMALL_IN

    @property
    def side_in(self) -> float:
        """Room for the directions east and west."""
        return _GAP_IN + self.font_pt / 72 * (1.0 if self.is_small else 2.5)

    @property
    def top_in(self) -> float:
        """Room for the directions north and south."""
        return _GAP_IN + 1.35 * self.font_pt / 72

    @property
    def height_in(self) -> float:
        """Height of the axes."""
        return self.width_in - 2 * (self.side_in - self.top_in)

    @property
    def degrees_per_inch(self) -> float:
        """Zenith angle to an inch."""
        return 180.0 / (self.width_in - 2 * self.side_in)


class View(enum.Enum):
    """From where the dome is seen; north is up either way.

    ABOVE
        As a map: east to the right, azimuth from +x towards +y counterclockwise.
    BELOW
        As seen by an eye that looks up: east to the left, azimuth clockwise.
    """

    ABOVE = "above"
    BELOW = "below"

    @classmethod
    def named(cls, name: str) -> View:
        """The view of a name."""
        try:
            return cls(name)
        except ValueError:
            raise UsageError(f"the dome is seen from 'above' or 'below', not from {name!r}") from None

    @property
    def sentence(self) -> str:
        """What the picture says of it."""
        if self is View.ABOVE:
            seen, side, way = "above, as a map", "right", "anticlockwise"
        else:
            seen, side, way = "below, looking up", "left", "clockwise"
        return (
            f"Seen from {seen}: north (+y) up, east (+x) on the {side}; azimuth from 0° in the east to 90° in the "
            f"north, {way}."
        )


def place(zenith_deg: Any, azimuth_deg: Any, view: View) -> tuple[np.ndarray, np.ndarray]:
    """Where sky directions are drawn, right and up, in degrees: the zenith angle is the radius."""
    sine, cosine = sin_cos_deg(azimuth_deg)
    radius = np.asarray(zenith_deg, dtype=np.float64)
    return radius * (cosine if view is View.ABOVE else -cosine), radius * sine


def draw_dome(axes: Any, dome: Dome, quantity: Quantity, colours: Colours, panel: Panel) -> Any:
    """Draw a dome on axes as large as the panel says; the QuadMesh of its patches comes back.

    Its array has a row for each ring; a column wider than 2 degrees is repeated, so that its straight edges follow the
    arc within 1.5e-4 of the radius.
    """
    axes.set_axis_off()
    half = panel.degrees_per_inch / 2
    axes.set_xlim(-half * panel.width_in, half * panel.width_in)
    axes.set_ylim(-half * panel.height_in, half * panel.height_in)
    mesh = _draw_patches(axes, dome, quantity, colours, panel.view)
    _draw_rings(axes, panel, dome.marks, "#777777" if quantity.is_signed else "white")
    _draw_directions(axes, panel)
    for mark in dome.marks:
        zenith = _BELOW_AT_DEG if mark.symbol is Symbol.SUN_BELOW else mark.zenith_deg
        where = place(zenith, mark.azimuth_deg, panel.view)
        draw_mark(axes, *where, mark.symbol, panel.font_pt)
    return mesh


def _draw_patches(axes: Any, dome: Dome, quantity: Quantity, colours: Colours, view: View) -> Any:
    axes.fill(*place(90.0, np.linspace(0.0, 360.0, 361), view), color=VOID_COLOUR, linewidth=0.0, zorder=0)
    zenith, azimuth, repeats = mesh_edges(dome.grid)
    x, y = place(zenith[:, None], azimuth[None, :], view)
    finite = np.clip(dome.values, -_BEYOND, _BEYOND)  # matplotlib would hide an infinite pull
    values = np.ma.masked_array(finite, ~dome.has_colour(quantity))
    shown = values.reshape(dome.grid.n_zenith, dome.grid.n_azimuth).repeat(repeats, axis=1)
    mesh = axes.pcolormesh(x, y, shown, norm=colours.norm, cmap=colours.cmap, rasterized=True, antialiased=False)
    mesh.set_linewidth(0.0)
    return mesh


def mesh_edges(grid: PatchGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges of the rings, edges of columns no wider than 2 degrees, and how many of these each column has."""
    zenith = np.append(grid.zenith_bounds_deg[:, 0], grid.zenith_bounds_deg[-1, 1])
    start, width = grid.azimuth_bounds_deg[:, 0], np.diff(grid.azimuth_bounds_deg, axis=1).ravel()
    repeats = np.maximum(np.ceil(width / _WIDEST_DEG - 1e-9), 1).astype(int)
    parts = [a + w * np.arange(n) / n for a, w, n in zip(start, width, repeats, strict=True)]
    return zenith, np.append(np.concatenate(parts), grid.azimuth_bounds_deg[-1, 1]), repeats


def _draw_rings(axes: Any, panel: Panel, marks: Sequence[Mark], colour: str) -> None:
    around, view = np.linspace(0.0, 360.0, 361), panel.view
    for ring in (30.0, 60.0):
        axes.plot(*place(ring, around, view), color=colour, alpha=0.45, linewidth=0.6)
    for azimuth in _directions(panel):
        axes.plot(*place([0.0, 90.0], azimuth, view), color=colour, alpha=0.3, linewidth=0.5)
    axes.plot(*place(90.0, around, view), color="black", linewidth=0.8)
    # the labels stand on the side without the sun
    sun = next((m.azimuth_deg for m in marks if m.symbol is not Symbol.LOBE), 0.0)
    side = _LABEL_SIDES[int(sin_cos_deg(sun - _LABEL_SIDES[0])[1] > 0)]
    style = {"color": "white", "fontsize": 0.85 * panel.font_pt, "path_effects": outlined(1.6)}
    for ring in (30.0, 60.0):
        axes.text(*place(ring, side, view), f"{ring:g}°", ha="center", va="center", **style)


def _directions(panel: Panel) -> np.ndarray:
    return np.arange(0.0, 360.0, 45.0 if panel.is_large else 90.0)


def _draw_directions(axes: Any, panel: Panel) -> None:
    radius = 90.0 + _GAP_IN * panel.degrees_per_inch
    for azimuth in _directions(panel):
        x, y = (float(v) for v in place(radius, azimuth, panel.view))
        letter = _LETTERS.get(float(azimuth), "")
        across, up = (round(v / radius) if letter else v / abs(v) for v in (x, y))
        number = "" if panel.is_small else f"{azimuth:g}°"
        between = "\n" if across and letter and number else " "
        text = f"{number}{between}{letter}".strip()
        ha, va = _SIDES[int(across)], _HEIGHTS[int(up)]
        size, colour = (panel.font_pt, "black") if letter else (0.85 * panel.font_pt, "#555555")
        axes.text(x, y, text, ha=ha, va=va, fontsize=size, color=colour, linespacing=0.95)


def draw_mark(axes: Any, x: Any, y: Any, symbol: Symbol, font_pt: float) -> None:
    """Draw a mark at data coordinates: white in a dark rim, so that it is seen on any colour.

    A ring with a point is the beam, a ring the sun, a triangle the sun below the horizon, a dotted ring a narrow lobe.
    Its size is in proportion to the letters.
    """
    effects = optional_module("matplotlib.patheffects", extra=EXTRA)
    size = 1.05 * font_pt
    rim = [effects.withStroke(linewidth=0.3 * font_pt, foreground="black")]
    ring = {"marker": "o", "markersize": size, "markerfacecolor": "none", "markeredgecolor": "white"}
    line = {"linestyle": "none", "clip_on": False, "zorder": 5, "path_effects": rim, "markeredgewidth": 0.13 * font_pt}
    if symbol is Symbol.SUN_BELOW:
        ring |= {"marker": "^", "markerfacecolor": "white"}
    if symbol is Symbol.LOBE:
        ring |= {"marker": "D"}
    axes.plot([float(x)], [float(y)], gid=f"mark-{symbol.name.lower()}", **ring, **line)
    if symbol is Symbol.BEAM:
        axes.plot([float(x)], [float(y)], marker="o", markersize=0.3 * size, color="white", **line)
