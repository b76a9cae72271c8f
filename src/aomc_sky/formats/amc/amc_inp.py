"""amc.inp: 30 fixed-column values, one per line, from column 49 on (31 in the older layout)."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.formats.amc.layout import fields_of_layout, has_polar_cap_line
from aomc_sky.formats.amc.lines import read_fields
from aomc_sky.formats.text_file import Report, read_bytes, split_lines


class LightSource(enum.IntEnum):
    """Line 2 of amc.inp: the model's own source, or a sky file."""

    MODEL = 0
    FILE = 1


class Footprint(enum.IntEnum):
    """Shape of the lit area of the sea surface."""

    POINT = 1
    CIRCLE = 2
    RECTANGLE = 3


@dataclass(frozen=True, kw_only=True, slots=True)
class AmcConfig:
    """The values of amc.inp as the AOMC program reads them; see docs/formats/amc.md for each.

    Lengths are in metres, angles in degrees; `use_polar_cap` is None in the 30-line layout.
    """

    iterations: int
    light_source: LightSource
    direct_azimuth_deg: int
    direct_zenith_deg: int
    n_constituents: int
    depth_m: float
    side_m: float
    n_recording_layers: int
    layer_thickness_m: float
    n_alpha_intervals: int
    n_phi_intervals: int
    use_polar_cap: bool | None = None
    interval_type: int
    log_absorption: bool
    log_bottom: bool
    log_side: bool
    spf_from_file: bool
    n_spf_angles: int
    n_concentration_layers: int
    n_grid_cells: int
    cell_size_m: float
    surfer_output: bool
    footprint: Footprint
    circle_diameter_m: float
    rectangle_x_m: float
    rectangle_y_m: float
    bottom_target: bool
    target_x_m: float
    target_y_m: float
    normalize_to_water: int
    n_wavebands: int


_KINDS: dict[str, Any] = {
    "light_source": LightSource,
    "footprint": Footprint,
    "use_polar_cap": bool,
    "log_absorption": bool,
    "log_bottom": bool,
    "log_side": bool,
    "spf_from_file": bool,
    "surfer_output": bool,
    "bottom_target": bool,
}


def read_amc(path: str | Path, *, lenient: bool = False) -> AmcConfig:
    """Read amc.inp as Fortran does, and refuse what a person would read differently.

    Parameters
    ----------
    path : str or Path
        The file.
    lenient : bool
        Take Fortran's value, with a warning, where a person would read another one. What Fortran
        itself refuses stays an error.

    Returns
    -------
    AmcConfig
        Integers exactly, reals as float64 of the decimal that Fortran reads.

    Raises
    ------
    InputFileError
        Every problem of the file, with line and column.
    """
    lines = split_lines(read_bytes(path))
    report = Report(path=str(path), lenient=lenient)
    values = read_fields(lines, fields_of_layout(has_polar_cap_line(lines)), report)
    report.close()
    return AmcConfig(**{name: _KINDS.get(name, lambda v: v)(value) for name, value in values.items()})
