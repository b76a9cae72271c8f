"""What a table of an atmosphere is to hold."""

from __future__ import annotations

from dataclasses import dataclass, field

from aomc_sky.formats.sky_toml.moon import MoonPlace
from aomc_sky.outputs.tables.atmosphere_saves import Saves


@dataclass(frozen=True, kw_only=True, slots=True)
class TableRequest:
    """What a table of an atmosphere is to hold.

    Parameters
    ----------
    path : str
        The description.
    sun_zenith_deg : tuple of float or None
        Zenith angles of the sun, rising; None is as many from 0 to 90 as the description says. [deg, 0 to 108]
    sun_azimuth_deg : float
        Azimuth of the sun, from +x towards +y. [deg]
    wavelength_nm : tuple of float or None
        Wavelengths, each the nearest of the description; None is all. [nm]
    method : str
        As `aomc_sky.atmosphere.sky.method.chosen_method` has it.
    n_orders : int or None
        Most interactions that count; None is what the description says.
    n_paths : int or None
        Backward paths of each direction and wavelength; None is as many as `solve_sky` finds right.
    bins : (int, int) or None
        Equal bins of zenith and azimuth; None is those of the description, or 45 and 180.
    allow_paths : tuple of str
        Folders below which tables of the description may lie, besides its own.
    saves : Saves
        What the netCDF file holds besides radiances and irradiances.
    significand_bits : int or None
        Of the numbers in the netCDF file, then in float32; None is float64. [1 to 24]
    moon : MoonPlace
        Where the Moon hides part of the sun; empty: no Moon.
    ground_luminance_cd_m2 : float
        Of the ground's own light. [0 or more]
    """

    path: str
    sun_zenith_deg: tuple[float, ...] | None
    sun_azimuth_deg: float = 0.0
    wavelength_nm: tuple[float, ...] | None = None
    method: str = "auto"
    n_orders: int | None = None
    n_paths: int | None = None
    bins: tuple[int, int] | None = None
    allow_paths: tuple[str, ...] = ()
    saves: Saves = field(default_factory=Saves)
    significand_bits: int | None = None
    moon: MoonPlace = field(default_factory=MoonPlace)
    ground_luminance_cd_m2: float = 0.0
