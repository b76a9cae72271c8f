"""Beam and sky of each waveband by SPCTRL2: a cloudless sky, or spectra and clouds scaled to dni and dhi."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal

import numpy as np

from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.extras import optional_module
from aomc_sky.formats.report import BadValueError
from aomc_sky.formats.sky_toml.keys import RULES, Rule, number, plain_number
from aomc_sky.options import MOMENT
from aomc_sky.source.light.place import Sun

SHORTEST_NM, LONGEST_NM = 300.0, 4000.0
"""The wavelengths of SPCTRL2."""

_OF_AEROSOL: dict[str, Rule] = {
    "angstrom_exponent": number(-0.5, 3.0),
    "albedo_400nm": number(0.0, 1.0),
    "albedo_variation": number(0.0, 1.0),
    "asymmetry": number(0.0, 0.95),  # SPCTRL2 takes the logarithm of 1 less this
}


def _good(name: str, rule: Rule, value: object) -> Any:
    """The value of a field in the form of its rule."""
    try:
        return rule(plain_number(value))
    except BadValueError as problem:
        raise UsageError(f"{name}: {problem.message}; {problem.advice}") from None


@dataclass(frozen=True, kw_only=True, slots=True)
class Aerosol:
    """What an aerosol does to light, for `ClearSky`.

    Its optical depth follows the law of Angstrom, that at 500 nm times (wavelength / 500 nm) to the power
    ``-angstrom_exponent``. Of the light that it takes away it scatters the share ``albedo_400nm * exp(-albedo_variation
    * ln(wavelength / 400 nm)**2)``.

    Parameters
    ----------
    angstrom_exponent : float
        Exponent of Angstrom. [-0.5 to 3; near 0 for large particles]
    albedo_400nm : float
        Single scattering albedo at 400 nm. [0 to 1]
    albedo_variation : float
        How fast the albedo falls on both sides of 400 nm. [0 to 1; 0 is the same albedo at all wavelengths]
    asymmetry : float
        Mean cosine of the scattering angle, at all wavelengths. [0 to 0.95]

    Notes
    -----
    The two words of `ClearSky` stand for

    ========  =================  ============  ================  =========
    word      angstrom_exponent  albedo_400nm  albedo_variation  asymmetry
    ========  =================  ============  ================  =========
    rural                  1.14         0.945             0.095       0.65
    maritime                0.3          0.98                 0       0.75
    ========  =================  ============  ================  =========

    Examples
    --------
    >>> dust = sky.Aerosol(angstrom_exponent=0.1, albedo_400nm=0.92, asymmetry=0.75)
    >>> print(sky.ClearSky(aod_500nm=0.4, aerosol=dust, pressure_hPa=1005))
    aerosol (exponent 0.1, albedo 0.92, asymmetry 0.75) 0.4 at 500 nm, 1.4 cm of water, 0.3 atm cm of ozone, 1005 hPa
    """

    angstrom_exponent: float
    albedo_400nm: float
    albedo_variation: float = 0.0
    asymmetry: float

    def __post_init__(self) -> None:
        for name, rule in _OF_AEROSOL.items():
            object.__setattr__(self, name, _good(name, rule, getattr(self, name)))

    def __str__(self) -> str:
        """The aerosol for a person."""
        variation = f" at 400 nm, its variation {self.albedo_variation:g}" if self.albedo_variation else ""
        return (
            f"exponent {self.angstrom_exponent:g}, albedo {self.albedo_400nm:g}{variation}, "
            f"asymmetry {self.asymmetry:g}"
        )


AerosolWord = Literal["rural", "maritime"]
RURAL: AerosolWord = "rural"
AEROSOLS = {
    RURAL: Aerosol(angstrom_exponent=1.14, albedo_400nm=0.945, albedo_variation=0.095, asymmetry=0.65),
    "maritime": Aerosol(angstrom_exponent=0.3, albedo_400nm=0.98, asymmetry=0.75),
}
"""The aerosol of each word: that of SPCTRL2 (Bird and Riordan 1986), and sea salt: large, and it hardly absorbs."""

SEA_LEVEL_HPA = 1013.25


@dataclass(frozen=True, kw_only=True, slots=True)
class ClearSky:
    """The air of a cloudless sky, for ``spectrum="spectrl2"`` without irradiances.

    The light of each waveband is that of SPCTRL2 (Bird and Riordan 1986, as pvlib has it) above a surface of albedo
    0.06. With a date the sun has its distance of that day.

    Parameters
    ----------
    aod_500nm : float
        Optical depth of the aerosol at 500 nm. [0 to 5; below 0.05 is clean ocean air, 0.5 dense haze]
    water_cm : float
        Precipitable water. [cm, 0 to 20]
    ozone_cm : float
        Column of ozone. [atm cm, 0 to 2; 0.3 is 300 Dobson units]
    pressure_hPa : float, optional
        Pressure at the surface. [hPa, 100 to 1200] By default that of the altitude: 1013.25 at the sea.
    aerosol : str or Aerosol
        "rural", the default: the aerosol of SPCTRL2, with the Angstrom exponent 1.14. "maritime": that of the sea,
        with the exponent 0.3. Or the numbers of another one.

    Notes
    -----
    Accuracy, against multiple scattering by PythonicDISORT through the same air, 412 to 670 nm, depths of the aerosol
    to 0.3: for suns to 70 degrees from the zenith direct light is within 0.5 %. Diffuse light is 15 % too low to 1 %
    too high (rural), or 16 to 0 % too low (maritime), most at 412 nm; all light is 12 % too low at most. At 80 degrees
    direct light is up to 11 % too high, diffuse light 13 % too low to 1 % too high. In the air of the sea "rural" gives
    diffuse light that is 20 to 26 % too low at 670 nm.

    Examples
    --------
    >>> scene = sky.weather_scene(
    ...     wavebands=[443.0, 555.0],
    ...     sun_zenith_deg=40.0,
    ...     sky="harrison-coombes",
    ...     spectrum="spectrl2",
    ...     clear_sky=sky.ClearSky(aod_500nm=0.05, aerosol="maritime"),
    ... )
    >>> print(scene.irradiance.of_component.sum(axis=1).round(2))
    [1.24 1.3 ]
    """

    aod_500nm: float = 0.1
    water_cm: float = 1.4
    ozone_cm: float = 0.3
    pressure_hPa: float | None = None  # noqa: N815 - the unit is written so
    aerosol: Aerosol | AerosolWord = RURAL

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None or field.name != "pressure_hPa":
                object.__setattr__(self, field.name, _good(field.name, RULES["clear_sky"][field.name], value))
        if isinstance(self.aerosol, Mapping):  # a record that became a mapping on its way
            object.__setattr__(self, "aerosol", _aerosol_of(self.aerosol))
        elif not isinstance(self.aerosol, (str, Aerosol)):
            raise UsageError(f"aerosol must be a word or an Aerosol(...), got {self.aerosol!r}")

    def __str__(self) -> str:
        """The air for a person."""
        aerosol = f"{self.aerosol} aerosol" if isinstance(self.aerosol, str) else f"aerosol ({self.aerosol})"
        pressure = "the pressure of the altitude" if self.pressure_hPa is None else f"{self.pressure_hPa:g} hPa"
        return (
            f"{'aerosol' if self.aerosol == RURAL else aerosol} {self.aod_500nm:g} at 500 nm, "
            f"{self.water_cm:g} cm of water, {self.ozone_cm:g} atm cm of ozone, {pressure}"
        )

    def at(self, altitude_m: float) -> ClearSky:
        """Fill in the pressure of an altitude, that of the standard atmosphere, unless a pressure is given.

        Parameters
        ----------
        altitude_m : float
            Height of the surface above the sea. [m, -500 to 9000]

        Returns
        -------
        ClearSky
            The same air with a pressure, to 0.01 hPa. [1013.25 at 0 m, 701.09 at 3000 m]
        """
        row = MOMENT["altitude_m"]
        altitude_m = _good(row.name, number(row.low, row.high), altitude_m)
        if self.pressure_hPa is not None:
            return self
        if altitude_m == 0:
            return replace(self, pressure_hPa=SEA_LEVEL_HPA)
        pascal = float(optional_module("pvlib", extra="weather").atmosphere.alt2pres(altitude_m))
        return replace(self, pressure_hPa=round(pascal / 100.0, 2))


def _aerosol_of(numbers: Mapping[str, Any]) -> Aerosol:
    if unknown := [str(name) for name in numbers if name not in _OF_AEROSOL]:
        raise UsageError(f"aerosol has no input {unknown[0]!r}; the inputs are {', '.join(_OF_AEROSOL)}")
    try:
        return Aerosol(**numbers)
    except TypeError:
        raise UsageError("aerosol: angstrom_exponent, albedo_400nm and asymmetry are needed") from None


REFERENCE = ClearSky(aod_500nm=0.084, water_cm=1.416, ozone_cm=0.344, pressure_hPa=SEA_LEVEL_HPA)
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
        aerosol = self.air.aerosol
        named = {} if aerosol == RURAL else {"aerosol": aerosol if isinstance(aerosol, str) else asdict(aerosol)}
        return {
            "model": "spectrl2",
            "turbidity_500nm": self.turbidity,
            **named,
            "cloud_share": self.cloud,
            "precipitable_water_cm": self.air.water_cm,
            "ozone_atm_cm": self.air.ozone_cm,
            "pressure_hPa": self.air.pressure_hPa,
            "ground_albedo": SEA_ALBEDO,
            "direct_fraction": self.direct_fraction.tolist(),
        }


def cloudless_split(air: ClearSky, sun: Sun, wavelength_nm: np.ndarray) -> SpectralSplit:
    """The light of each waveband under a cloudless sky; without a date at the sun's mean distance.

    An air without a pressure is at the sea.
    """
    air = air.at(0.0)
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


def spectral_split(dni: float, dhi: float, sun: Sun, wavelength_nm: np.ndarray) -> SpectralSplit:
    """Split the light of each waveband by spectra whose integrals are these irradiances, of which one is positive.

    More diffuse light than turbidity 0.5 has is that of cloud. With r the ratio of dni and dhi, and r_05 that of
    turbidity 0.5, its share of the diffuse light is 1 - r / r_05.

    Warns if a sky of turbidity 0 has more diffuse light than the inputs.
    """
    _refuse_outside(wavelength_nm)
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
            f"{SHORTEST_NM:g} to {LONGEST_NM:g} nm",
            "leave it out. Beside a sky in relative units spectrum 'flat' takes two irradiances at any wavelength",
        )


def _spectra(sun_zenith_deg: float, air: ClearSky) -> Spectra:
    """Wavelengths, direct normal and diffuse horizontal irradiance of a cloudless sky, as functions of turbidity.

    At the sun's mean distance.
    """
    from aomc_sky.skies.perez.functions import relative_air_mass

    pvlib = optional_module("pvlib", extra="weather")
    day_factor = float(pvlib.irradiance.get_extra_radiation(_ANY_DAY, solar_constant=1.0, method="spencer"))
    zenith = np.array([sun_zenith_deg])
    aerosol = AEROSOLS[air.aerosol] if isinstance(air.aerosol, str) else air.aerosol
    assert air.pressure_hPa is not None, "filled in by `ClearSky.at`"
    fixed = {
        "apparent_zenith": zenith,
        "aoi": zenith,
        "surface_tilt": 0.0,
        "ground_albedo": SEA_ALBEDO,
        "surface_pressure": 100.0 * air.pressure_hPa,
        "precipitable_water": air.water_cm,
        "ozone": air.ozone_cm,
        "dayofyear": _ANY_DAY,
        "alpha": aerosol.angstrom_exponent,
        "scattering_albedo_400nm": aerosol.albedo_400nm,
        "wavelength_variation_factor": aerosol.albedo_variation,
        "aerosol_asymmetry_factor": aerosol.asymmetry,
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
