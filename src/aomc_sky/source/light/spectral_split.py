"""Beam and sky of each waveband by SPCTRL2: a cloudless sky, or spectra and clouds scaled to dni and dhi."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.sky_toml.keys import plain_number, value_problem
from aomc_sky.formats.sky_toml.sections import PerezSection
from aomc_sky.source.light.sun import Sun, irradiances

SHORTEST_NM, LONGEST_NM = 300.0, 4000.0
"""The wavelengths of SPCTRL2."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ClearSky:
    """The air of a cloudless sky, for ``spectrum="spectrl2"`` without irradiances.

    The light of each waveband is that of SPCTRL2 (Bird and Riordan 1986, as pvlib has it) above a surface of albedo
    0.06, with an aerosol of Angstrom exponent 1.14. With a date the sun has its distance of that day.

    Parameters
    ----------
    aod_500nm : float
        Optical depth of the aerosol at 500 nm. [0 to 5; below 0.05 is clean ocean air, 0.5 dense haze]
    water_cm : float
        Precipitable water. [cm, 0 to 20]
    ozone_cm : float
        Column of ozone. [atm cm, 0 to 2; 0.3 is 300 Dobson units]
    pressure_hPa : float
        Pressure at the surface. [hPa, 100 to 1200]

    Examples
    --------
    >>> scene = sky.weather_scene(
    ...     wavebands=[443.0, 555.0],
    ...     sun_zenith_deg=40.0,
    ...     sky="harrison-coombes",
    ...     spectrum="spectrl2",
    ...     clear_sky=sky.ClearSky(aod_500nm=0.05),
    ... )
    >>> print(scene.irradiance.of_component.sum(axis=1).round(2))
    [1.23 1.29]
    """

    aod_500nm: float = 0.1
    water_cm: float = 1.4
    ozone_cm: float = 0.3
    pressure_hPa: float = 1013.25  # noqa: N815 - the unit is written so

    def __post_init__(self) -> None:
        for field in fields(self):
            value = plain_number(getattr(self, field.name))
            _, message, advice = value_problem("clear_sky", field.name, value)
            if message:
                raise UsageError(f"{field.name}: {message}; {advice}")
            object.__setattr__(self, field.name, value)

    def __str__(self) -> str:
        """The air for a person."""
        return (
            f"aerosol {self.aod_500nm:g} at 500 nm, {self.water_cm:g} cm of water, {self.ozone_cm:g} atm cm of ozone, "
            f"{self.pressure_hPa:g} hPa"
        )


REFERENCE = ClearSky(aod_500nm=0.084, water_cm=1.416, ozone_cm=0.344)
"""The air of the reference spectrum ASTM G173."""
LARGEST_TURBIDITY = 0.5
"""Above this it is rather cloud than aerosol."""
_NOTED_CLOUD = 0.1
_DIFFUSE_AIR_MASS = 1.66
SEA_ALBEDO = 0.06
LOW_SUN_DEG = 85.0
"""Zenith angle of the sun beyond which the light of a cloudless sky is too weak by 10 % and more."""

_ANY_DAY = 80  # the distance of the sun scales all light alike: `_spectra` divides by that of this day
_TURBIDITY_DECIMALS, _FRACTION_DECIMALS, _DIGITS = 6, 9, 9

#: Wavelengths, direct normal and diffuse horizontal irradiance, of a turbidity and, for the beam, an air mass.
Spectra = Callable[..., tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True, kw_only=True, slots=True)
class SpectralSplit:
    """Direct and diffuse light of each waveband, on a horizontal plane."""

    direct_fraction: np.ndarray  #: (n_band,) [0 to 1]
    direct_irradiance: np.ndarray  #: (n_band,) [W m-2 nm-1]
    diffuse_irradiance: np.ndarray  #: (n_band,) [W m-2 nm-1]
    turbidity: float  #: optical depth of the aerosol at 500 nm [0 to 0.5]
    cloud: float = 0.0  #: share of the diffuse light with the spectrum of a cloud [0 to 1]
    air: ClearSky = REFERENCE
    dni: float | None = None  #: of the whole spectrum of a cloudless sky that no irradiances scale [W m-2]
    dhi: float | None = None

    def __str__(self) -> str:
        """The spectra for a person."""
        if self.dni is not None:
            return f"cloudless sky of SPCTRL2, {self.air}"
        text = f"spectra of SPCTRL2 at turbidity {self.turbidity:.3g}"
        if self.cloud > _NOTED_CLOUD:
            text += f", {100 * self.cloud:.3g} % of the diffuse light as white as a cloud's"
        return text

    def as_options(self) -> dict[str, Any]:
        """JSON values for a manifest."""
        return {
            "model": "spectrl2",
            "turbidity_500nm": self.turbidity,
            "cloud_share": self.cloud,
            "precipitable_water_cm": self.air.water_cm,
            "ozone_atm_cm": self.air.ozone_cm,
            "pressure_hPa": self.air.pressure_hPa,
            "ground_albedo": SEA_ALBEDO,
            "direct_fraction": self.direct_fraction.tolist(),
        }


def cloudless_split(air: ClearSky, sun: Sun, wavelength_nm: np.ndarray) -> SpectralSplit:
    """The light of each waveband under a cloudless sky; without a date at the sun's mean distance."""
    _refuse_outside(wavelength_nm)
    if sun.zenith_deg > LOW_SUN_DEG:
        warnings.warn(
            f"spectrum 'spectrl2' with the sun {90.0 - sun.zenith_deg:.3g} degrees above the horizon: the light of its "
            "cloudless sky goes to 0 at the horizon; it is too weak by 5 % at 5 degrees, 25 % at 2, 50 % at 1 and 93 % "
            "at 0.1; a low sun needs an atmosphere",
            ModelLimitWarning,
            stacklevel=2,
        )
    grid_nm, normal, diffuse = _spectra(sun.zenith_deg, air)(air.aod_500nm)
    normal, diffuse = (one * (sun.distance_factor or 1.0) for one in (normal, diffuse))
    direct = np.interp(wavelength_nm, grid_nm, normal) * sun.cosine
    dni, dhi = (float(f"{_integral(grid_nm, one):.{_DIGITS}g}") for one in (normal, diffuse))
    more = {"turbidity": air.aod_500nm, "air": air, "dni": dni, "dhi": dhi}
    return _rounded(direct, np.interp(wavelength_nm, grid_nm, diffuse), **more)


def spectral_split(amounts: PerezSection, sun: Sun, wavelength_nm: np.ndarray) -> SpectralSplit:
    """Split the light of each waveband by spectra whose integrals are the irradiances that are given.

    More diffuse light than turbidity 0.5 has is that of cloud. With r the ratio of dni and dhi, and r_05 that of
    turbidity 0.5, its share of the diffuse light is 1 - r / r_05.

    Warns if a sky of turbidity 0 has more diffuse light than the inputs.
    """
    _refuse_outside(wavelength_nm)
    dni, dhi = irradiances(amounts, sun)
    if dni + dhi == 0:
        raise SceneError(f"spectrum 'spectrl2' scales spectra to dni and dhi, but {amounts} leave no light at all")
    spectra = _spectra(sun.zenith_deg, REFERENCE)
    turbidity, cloud = _turbidity_and_cloud(spectra, dni, dhi)
    grid_nm, normal, diffuse = spectra(turbidity)
    direct = np.interp(wavelength_nm, grid_nm, normal) * (sun.cosine * dni / _integral(grid_nm, normal))
    diffuse = diffuse / _integral(grid_nm, diffuse)
    if cloud > 0:
        under_cloud = _cloud_spectrum(spectra)
        diffuse = (1.0 - cloud) * diffuse + cloud * (under_cloud / _integral(grid_nm, under_cloud))
    return _rounded(direct, np.interp(wavelength_nm, grid_nm, diffuse) * dhi, turbidity=turbidity, cloud=cloud)


def _rounded(direct: np.ndarray, diffuse: np.ndarray, **more: Any) -> SpectralSplit:
    """The split, rounded so that the last bit of a library's exponential does not change the run."""
    fraction = np.round(direct / (direct + diffuse), _FRACTION_DECIMALS)
    both = np.array([float(f"{total:.{_DIGITS}g}") for total in (direct + diffuse).tolist()])
    return SpectralSplit(
        direct_fraction=fraction,
        direct_irradiance=both * fraction,
        diffuse_irradiance=both * (1.0 - fraction),
        **more,
    )


def _refuse_outside(wavelength_nm: np.ndarray) -> None:
    outside = np.flatnonzero((wavelength_nm < SHORTEST_NM) | (wavelength_nm > LONGEST_NM))
    if outside.size:
        band = int(outside[0])
        raise SceneError(
            f"waveband {band + 1} at {wavelength_nm[band]:.12g} nm is outside the spectra of spectrum 'spectrl2', "
            f"{SHORTEST_NM:g} to {LONGEST_NM:g} nm; leave it out, or take spectrum 'flat' with two irradiances, or "
            "write difcol.inp beside amc.inp"
        )


def _spectra(sun_zenith_deg: float, air: ClearSky) -> Spectra:
    """Wavelengths, direct normal and diffuse horizontal irradiance of a cloudless sky, as functions of turbidity.

    At the sun's mean distance.
    """
    from aomc_sky.skies.perez.functions import relative_air_mass

    pvlib = optional_module("pvlib", extra="weather")
    day_factor = float(pvlib.irradiance.get_extra_radiation(_ANY_DAY, solar_constant=1.0, method="spencer"))
    zenith = np.array([sun_zenith_deg])
    fixed = {
        "apparent_zenith": zenith,
        "aoi": zenith,
        "surface_tilt": 0.0,
        "ground_albedo": SEA_ALBEDO,
        "surface_pressure": 100.0 * air.pressure_hPa,
        "precipitable_water": air.water_cm,
        "ozone": air.ozone_cm,
        "dayofyear": _ANY_DAY,
    }

    air_mass_of_sun = float(relative_air_mass(math.radians(sun_zenith_deg)))

    def spectra_with(turbidity: float, air_mass: float = air_mass_of_sun) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        spectra = pvlib.spectrum.spectrl2(aerosol_turbidity_500nm=turbidity, relative_airmass=air_mass, **fixed)
        return (np.ravel(spectra["wavelength"]), spectra["dni"][:, 0] / day_factor, spectra["dhi"][:, 0] / day_factor)

    return spectra_with


def _cloud_spectrum(spectra: Spectra) -> np.ndarray:
    """Light below a cloud, whose droplets are nearly grey: the sun's less what ozone, water and mixed gases absorb.

    They do so along the air mass of diffuse light, 1.66. This is the beam of SPCTRL2 without aerosol, over what its
    molecules transmit (Bird and Riordan 1986, eq. (2-4)).
    """
    grid_nm, normal, _ = spectra(0.0, _DIFFUSE_AIR_MASS)
    um = grid_nm / 1000.0
    return normal * np.exp(_DIFFUSE_AIR_MASS / (um**4 * (115.6406 - 1.335 / um**2)))


def _turbidity_and_cloud(spectra: Spectra, dni: float, dhi: float) -> tuple[float, float]:
    """The turbidity whose spectra have the ratio of dhi and dni, which rises with it, and the share of cloud beyond."""
    if dhi == 0:
        return REFERENCE.aod_500nm, 0.0

    def excess(turbidity: float) -> float:
        """Diffuse light of the model less that of the inputs, for the direct light of both."""
        grid_nm, normal, diffuse = spectra(turbidity)
        return _integral(grid_nm, diffuse) * dni - _integral(grid_nm, normal) * dhi

    low, high = 0.0, LARGEST_TURBIDITY
    if excess(high) < 0:
        grid_nm, normal, diffuse = spectra(high)
        ratio = (dni / dhi) / (_integral(grid_nm, normal) / _integral(grid_nm, diffuse))
        return high, round(1.0 - ratio, _TURBIDITY_DECIMALS)
    if excess(low) > 0:
        warnings.warn(
            f"spectrum 'spectrl2': dhi {dhi:g} with dni {dni:g} W m-2 is less than a cloudless sky has; "
            "turbidity 0 is used, and its diffuse light is scaled",
            ModelLimitWarning,
            stacklevel=2,
        )
        return low, 0.0
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if excess(middle) > 0 else (middle, high)
    return round(0.5 * (low + high), _TURBIDITY_DECIMALS), 0.0


def _integral(wavelength_nm: np.ndarray, values: np.ndarray) -> float:
    """Integral over the spectrum, linear between its wavelengths."""
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(wavelength_nm)))
