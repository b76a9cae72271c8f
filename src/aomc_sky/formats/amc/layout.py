"""The lines of amc.inp: label, name, columns and range of every value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

FIRST_COLUMN = 49
MOST_ITERATIONS = 2**62


@dataclass(frozen=True, kw_only=True, slots=True)
class Field:
    """One line of amc.inp."""

    name: str  #: Attribute of `AmcConfig`
    title: str  #: Name for a person
    label: str  #: What stands before the value; only its number is ever looked at
    width: int  #: Columns of the value, from column 49
    decimals: int | None  #: d of Fw.d; None for an integer
    allowed: str  #: The range in words
    is_allowed: Callable[[float], bool]  #: The range as the program checks it


def _integer(name: str, title: str, label: str, width: int, low: int, high: int) -> Field:
    return Field(
        name=name,
        title=title,
        label=label,
        width=width,
        decimals=None,
        allowed=f"{low} to {high}" if high < MOST_ITERATIONS else f"{low} or more",
        is_allowed=lambda v: low <= v <= high,
    )


def _flag(name: str, title: str, label: str) -> Field:
    return Field(
        name=name,
        title=title,
        label=label,
        width=1,
        decimals=None,
        allowed="0 or 1",
        is_allowed=lambda v: v in (0, 1),
    )


def _real(name: str, title: str, label: str, decimals: int, low: float, high: float) -> Field:
    return Field(
        name=name,
        title=title,
        label=label,
        width=12,
        decimals=decimals,
        allowed=f"{low:g} to {high:g}",
        is_allowed=lambda v: low <= v <= high,
    )


_POLAR_CAP = _flag("use_polar_cap", "polar cap flag", "           Use polar cap as grid?(yes=1, no=0):")

_GRID_CELLS = Field(
    name="n_grid_cells",
    title="grid cells",
    label="14)Number of cells in X-Y direction(0=NOGRID) :",
    width=8,
    decimals=None,
    allowed="0 or an odd number up to 101",
    is_allowed=lambda v: v == 0 or (1 <= v <= 101 and v % 2 == 1),
)

_FIELDS = (
    _integer("iterations", "iterations", "1)Iterations                                  :", 12, 1, MOST_ITERATIONS),
    _flag("light_source", "light source", "2)Light source from model(0) or file(1)       :"),
    _integer("direct_azimuth_deg", "direct azimuth", " a) direct azimuth angle(deg)                 :", 8, 0, 359),
    _integer("direct_zenith_deg", "direct zenith", " b) direct zenith angle(deg)                  :", 8, 0, 89),
    _integer("n_constituents", "constituents", "3)number of system constituents               :", 8, 1, 20),
    _real("depth_m", "depth", "4)depth (M)                                   :", 2, 0, 10_000),
    _real("side_m", "side", "5)side boundaries (M)                         :", 2, 0, 100_000),
    _integer("n_recording_layers", "recording layers", "6)Number of depth recording layers            :", 8, 0, 500),
    _real("layer_thickness_m", "layer thickness", "  a) Thickness of each recording layer        :", 4, -1, 500),
    _integer("n_alpha_intervals", "alpha intervals", "7)# of alpha intervals to bin (MAX=180)       :", 8, 1, 180),
    _integer("n_phi_intervals", "phi intervals", "8)# of phi intervals to bin (MAX=180)         :", 8, 1, 360),
    _flag("interval_type", "interval type", "           Interval type (ang = 1,cos = 0)    :"),
    _flag("log_absorption", "absorption log", "9)X,Y,Z for absorption (yes=1,no=0)           :"),
    _flag("log_bottom", "bottom log", "10)BOT.-output(yes=1,no=0)                    :"),
    _flag("log_side", "side log", "11)SIDE-output(yes=1,no=0)                    :"),
    _flag("spf_from_file", "SPF from file", "12)SPF from file? (yes=1,no=0)                :"),
    _integer("n_spf_angles", "SPF angles", "   a) Number of angles                        :", 8, 0, 360),
    _integer(
        "n_concentration_layers", "concentration layers", "13)# of concentration dependent layers        :", 8, 1, 100
    ),
    _GRID_CELLS,
    _real("cell_size_m", "cell size", "      Cell size (in unit meters)              :", 6, 0, 100_000),
    _flag("surfer_output", "Surfer output", "      Output to Surfer format (yes=1,no=0)    :"),
    Field(
        name="footprint",
        title="footprint",
        label="15)Light source: point[1],circle[2],rect.[3]  :",
        width=1,
        decimals=None,
        allowed="1, 2 or 3",
        is_allowed=lambda v: v in (1, 2, 3),
    ),
    _real("circle_diameter_m", "circle diameter", "    a)If circle, define diameter              :", 6, 0, 1e7),
    _real("rectangle_x_m", "rectangle dX", "    b)If rectangle, define dX                 :", 6, 0, 1e7),
    _real("rectangle_y_m", "rectangle dY", "    c)          and define dY                 :", 6, 0, 1e7),
    _flag("bottom_target", "bottom target", "16)Bottom target: NO[0],YES[1]                :"),
    _real("target_x_m", "target dX", "      define dX                               :", 6, 0, 1e7),
    _real("target_y_m", "target dY", "      define dY                               :", 6, 0, 1e7),
    _flag("normalize_to_water", "normalisation", "17)Normalize output to air(0) or water(1)     :"),
    _integer("n_wavebands", "wavebands", "18)Number of wavebands (minimum = 1)          :", 8, 1, 500),
)

_POLAR_CAP_INDEX = 11


def fields_of_layout(with_polar_cap: bool) -> tuple[Field, ...]:
    """Fields in file order: 30, or 31 with the older layout's polar cap flag."""
    if not with_polar_cap:
        return _FIELDS
    return (*_FIELDS[:_POLAR_CAP_INDEX], _POLAR_CAP, *_FIELDS[_POLAR_CAP_INDEX:])


def has_polar_cap_line(lines: list[str]) -> bool:
    """Whether line 12 carries the label of the older layout."""
    return len(lines) > _POLAR_CAP_INDEX and "polar cap" in lines[_POLAR_CAP_INDEX][: FIRST_COLUMN - 1].lower()
