"""An atmosphere description becomes a medium: code blocks evaluated and checked, cross sections at the wavelengths."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import (
    InputFileError,
    InputWarning,
    Problem,
    SceneError,
    SourceText,
    UsageError,
    number,
    shown_value,
)
from aomc_sky.formats.sky_toml.sections import MoonDirection
from aomc_sky.skies.atmosphere.description.data import (
    AbsorberDescription,
    AtmosphereDescription,
    PhaseFunctionType,
    ScattererDescription,
)
from aomc_sky.skies.atmosphere.language.block import read_block
from aomc_sky.skies.atmosphere.language.values import Type
from aomc_sky.skies.atmosphere.lights import MOON_RADIUS_M, Moon
from aomc_sky.skies.atmosphere.medium import Constituent, Medium, NumberDensity, PhaseBlock, read_phase_block
from aomc_sky.skies.atmosphere.optical_depth import vertical_optical_depth
from aomc_sky.skies.atmosphere.phase_table import PhaseTable, TabulatedPhase, tabulated_phase
from aomc_sky.skies.direct_beam import solar_irradiance
from aomc_sky.wavebands import nearest_wavelength_index

# of the vertical optical depth: what counts for less is left out
NEGLIGIBLE_SHARE = 1e-6
_NORM_LIMIT = 0.01
_SAME_PHASE = 1e-6

T = TypeVar("T")
Species = ScattererDescription | AbsorberDescription
Phase = PhaseBlock | TabulatedPhase

SUN_RADIUS_M = 6.9635e8
# molecules per square metre and Dobson unit, as the tool that defines the format has it
DOBSON_UNIT_M2 = 2.687e20
SET_SIZE = 4

_CROSS_SECTION = "scatteringCrossSection_"


@dataclass(frozen=True, kw_only=True, slots=True)
class MediumReport:
    """The species of a description and their optical depths."""

    optical_depth: Mapping[str, np.ndarray]  #: vertical, (n_wl,) for each species, those that were dropped too
    #: integral over the sphere of each phase function as its block gives it; it was divided by it
    phase_norm: Mapping[str, np.ndarray]
    dropped: tuple[str, ...]  #: optical depth below NEGLIGIBLE_SHARE of the whole at every wavelength
    #: error of that integral by the steps of the angles, as a share, for each phase function from a table
    phase_norm_error: Mapping[str, np.ndarray] = field(default_factory=dict)
    ground_glow: np.ndarray | None = None  #: radiance of a ground that glows with 1 cd/m2 [W m-2 sr-1 nm-1]
    moon_distance_m: float | None = None  #: between the centres of earth and Moon, where the description says it


def read_medium(
    description: AtmosphereDescription, wavelength_nm: ArrayLike | None = None
) -> tuple[Medium, MediumReport]:
    """Evaluate a description at some of its wavelengths, by default all. [nm]

    Others are interpolated (`at_wavelengths`, and its errors). Each stands once, rising. Warnings are for a phase
    function whose integral was more than 1 % off, and for an achromatic one that is not. The InputFileError has the
    problems of all code blocks.
    """
    index = np.arange(description.wavelength_nm.size)
    if wavelength_nm is not None:
        description, index = at_wavelengths(description, wavelength_nm)
    reader = _BlockReader(description, index)
    parts = [reader.part(one) for one in description.species]
    if reader.problems:
        raise InputFileError(reader.problems)
    found = [part for part in parts if part is not None]
    medium = Medium(
        earth_radius_m=description.earth_radius_m,
        top_m=description.atmosphere_height_m,
        wavelength_nm=description.wavelength_nm[index],
        constituents=tuple(constituent for constituent, _ in found),
        ground_albedo=description.ground_albedo[index],
        toa_irradiance=description.solar_irradiance[index],
        sun_angular_radius_rad=sun_angular_radius(description),
        n_orders=description.scattering_orders,
        least_line_points=description.sizes.get("radial integration points", 0),
        least_angles=description.sizes.get("angular integration points", 0),
        texts=description.texts,
    )
    _warn_of_too_bright_a_sun(medium, description.path)
    depth = vertical_optical_depth(medium)
    is_dropped = (depth <= NEGLIGIBLE_SHARE * depth.sum(axis=1, keepdims=True)).all(axis=0)
    report = MediumReport(
        optical_depth={one.name: row for (one, _), row in zip(found, depth.T, strict=True)},
        phase_norm={one.name: phase.norm for one, phase in found if phase is not None},
        phase_norm_error={one.name: phase.norm_error for one, phase in found if isinstance(phase, TabulatedPhase)},
        dropped=tuple(one.name for (one, _), out in zip(found, is_dropped, strict=True) if out),
        ground_glow=None if description.ground_glow is None else description.ground_glow[index],
        moon_distance_m=description.earth_moon_distance_m,
    )
    kept = tuple(one for (one, _), out in zip(found, is_dropped, strict=True) if not out)
    return replace(medium, constituents=kept), report


def _warn_of_too_bright_a_sun(medium: Medium, path: str) -> None:
    ratio = medium.toa_irradiance / solar_irradiance(medium.wavelength_nm)
    row = int(ratio.argmax())
    if ratio[row] > 2.0:
        nm, irradiance = medium.wavelength_nm[row], medium.toa_irradiance[row]
        found = f"the solar irradiance at {nm:g} nm is {irradiance:.3g} W m-2 nm-1"
        message = f"{path}: {found}, {ratio[row]:.2g} times that of the sun: a unit may be wrong"
        warnings.warn(message, InputWarning, stacklevel=3)


NEAR_NM = 1.0
"""A wavelength of the description as near as this is the one that was asked for."""


def at_wavelengths(
    description: AtmosphereDescription, wavelength_nm: ArrayLike
) -> tuple[AtmosphereDescription, np.ndarray]:
    """A description that has these wavelengths, and where it has them, each once and rising. [nm]

    It is the given one if all are within 1 nm of those that it has. Otherwise spectra are interpolated, their
    logarithms where all values are positive. Of `inputs/atmosphere`, thinned from steps of 20 to 40 nm, transmitted and
    diffuse light change by up to 0.7 % (1.8 % in `continental.atmo`), the sun's by up to 7 %.

    SceneError: what is no wavelength; one more than 1 nm beyond the first or the last; one between two where a phase
    function asks for the number of its set.
    """
    requested = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
    if requested.ndim != 1 or not requested.size or not ((requested > 0.0) & (requested < np.inf)).all():
        raise SceneError("the wavelengths of an atmosphere are one or more positive numbers in nm")
    known = description.wavelength_nm
    nearest = known[nearest_wavelength_index(requested, known)]
    is_near = np.abs(nearest - requested) <= NEAR_NM
    beyond = requested[~is_near & ((requested < known[0]) | (requested > known[-1]))]
    if beyond.size:
        raise SceneError(
            f"{description.path}: {beyond[0]:g} nm lies beyond its wavelengths, {known[0]:g} to {known[-1]:g} nm",
            "take a description that reaches so far",
        )
    if is_near.all():
        return description, np.searchsorted(known, np.unique(nearest))
    for one in description.scatterers:
        law = one.phase_function
        if isinstance(law, SourceText) and "wlSetIndex" in law.text:  # a number for each set, not for a wavelength
            raise SceneError(
                f'{law.path}:{law.line}: the phase function of "{one.name}" reads wlSetIndex, so it is known at the '
                f"wavelengths of the description alone, and not at {requested[~is_near][0]:g} nm"
            )
    asked_nm = np.unique(np.where(is_near, nearest, requested))

    def at(values: np.ndarray) -> np.ndarray:
        is_positive = bool(np.all(values > 0))
        found = np.interp(asked_nm, known, np.log(values) if is_positive else values)
        found = np.exp(found) if is_positive else found
        place = np.minimum(np.searchsorted(known, asked_nm), known.size - 1)
        return np.where(known[place] == asked_nm, values[place], found)

    species: list[Species] = []
    for each in description.species:
        if isinstance(each, AbsorberDescription):
            species.append(replace(each, cross_section_m2=at(each.cross_section_m2)))
        else:
            species.append(replace(each, single_scattering_albedo=at(each.single_scattering_albedo)))
    glow = description.ground_glow
    made = replace(
        description,
        wavelength_nm=asked_nm,
        solar_irradiance=at(description.solar_irradiance),
        ground_albedo=at(description.ground_albedo),
        ground_glow=None if glow is None else at(glow),
        species=tuple(species),
    )
    return made, np.arange(asked_nm.size)


class _BlockReader:
    """Reads the blocks of one description; the problems of one do not hide those of the next."""

    def __init__(self, description: AtmosphereDescription, index: np.ndarray) -> None:
        self._description = description
        self._index = index
        self._common = common_values(description)
        self.problems: list[Problem] = []

    def part(self, one: Species) -> tuple[Constituent, Phase | None] | None:
        """Return a species and its phase function, which counts where it scatters; None where a block was refused."""
        profile = self._tried(lambda: self._profile(one))
        phase = None
        if isinstance(one, AbsorberDescription):
            absorption = one.cross_section_m2[self._index]
            scattering = np.zeros_like(absorption)
        else:
            extinction = extinction_cross_section(one, self._description.wavelength_nm[self._index])
            albedo = one.single_scattering_albedo[self._index]
            scattering, absorption = extinction * albedo, extinction * (1.0 - albedo)
            phase = self._tried(lambda: self._phase(one))
        if profile is None or (phase is None and isinstance(one, ScattererDescription)):
            return None
        density, kinks = profile
        constituent = Constituent(
            name=one.name,
            number_density=density,
            kink_altitude_m=kinks,
            scattering_m2=scattering,
            absorption_m2=absorption,
            phase_function=phase if scattering.any() else None,
        )
        return constituent, phase

    def _tried(self, read: Callable[[], T]) -> T | None:
        try:
            return read()
        except InputFileError as error:
            self.problems += error.problems
            return None

    def _profile(self, one: Species) -> tuple[NumberDensity, np.ndarray]:
        """The number density, and the altitudes of its kinks. [m]"""
        # a number of particles has no wavelength
        hints = dict.fromkeys(
            spectral_values(self._description, 0), "a number of particles does not depend on the wavelength"
        )
        block = read_block(
            one.number_density,
            subject=f'number density of "{one.name}"',
            gives=Type.FLOAT,
            argument="altitude",
            unit="m",
            given=_types_of(self._common),
            hints=hints | {"dotViewSun": "a number density depends on altitude alone"},
        )
        density = NumberDensity(block=block, given=self._common, top_m=self._description.atmosphere_height_m)
        return density, density.kinks()

    def _phase(self, one: ScattererDescription) -> Phase:
        if isinstance(one.phase_function, PhaseTable):
            wavelength = self._description.wavelength_nm[self._index]
            phase: Phase = tabulated_phase(one.phase_function, wavelength)
        else:
            phase = self._phase_block(one, one.phase_function)
        law = one.phase_function
        where = law.path if isinstance(law, PhaseTable) else f"{law.path}:{law.line}"
        what, messages = f'the phase function of "{one.name}"', []
        if isinstance(phase, TabulatedPhase) and (error := float(phase.norm_error.max())) > _NORM_LIMIT:
            messages.append(f"the angles of {what} are too far apart: they leave {error:.2g} of its integral open")
        worst = float(phase.norm[np.argmax(np.abs(phase.norm - 1.0))])
        if abs(worst - 1.0) > _NORM_LIMIT:
            messages.append(f"{what} has the integral {worst:.6g} over the sphere, not 1; it was divided by it")
        if one.phase_function_type is PhaseFunctionType.ACHROMATIC:
            values = [phase(np.linspace(-1.0, 1.0, 181), row) for row in range(phase.norm.size)]
            if any(np.abs(value - values[0]).max() > _SAME_PHASE * values[0].max() for value in values):
                messages.append(f"{what} is called achromatic and depends on the wavelength; it is used as it is")
        for message in messages:
            warnings.warn(f"{where}: {message}", InputWarning, stacklevel=2)
        return phase

    def _phase_block(self, one: ScattererDescription, text: SourceText) -> PhaseBlock:
        sets, set_of_row = np.unique(self._index // SET_SIZE, return_inverse=True)
        given = [self._common | spectral_values(self._description, int(one)) for one in sets]
        block = read_block(
            text,
            subject=f'phase function of "{one.name}"',
            gives=Type.VEC4,
            argument="dotViewSun",
            given=_types_of(given[0]),
            hints={"altitude": "a phase function depends on dotViewSun and the wavelengths alone"},
        )
        rows = list(zip(set_of_row.tolist(), (self._index % SET_SIZE).tolist(), strict=True))
        return read_phase_block(block, given, rows)


def _types_of(values: Mapping[str, np.ndarray | float]) -> dict[str, Type]:
    """Types of names in code, of their values; one name is a whole number."""
    vectors = {name: Type(f"vec{one.size}") for name, one in values.items() if isinstance(one, np.ndarray)}
    return dict.fromkeys(values, Type.FLOAT) | vectors | {name: Type.INT for name in values if name == "wlSetIndex"}


def sun_angular_radius(description: AtmosphereDescription) -> float:
    """Return the radius of the sun over its distance. [rad]"""
    return SUN_RADIUS_M / description.earth_sun_distance_m


def common_values(description: AtmosphereDescription) -> dict[str, np.ndarray | float]:
    """Return the values of the names that all blocks read, in SI."""
    return {
        "PI": np.pi,
        "km": 1000.0,
        "dobsonUnit": DOBSON_UNIT_M2,
        "earthRadius": description.earth_radius_m,
        "atmosphereHeight": description.atmosphere_height_m,
        "earthCenter": np.array([0.0, 0.0, -description.earth_radius_m]),
        "moonRadius": MOON_RADIUS_M,
        "sunAngularRadius": sun_angular_radius(description),
    }


def spectral_values(description: AtmosphereDescription, set_index: int) -> dict[str, np.ndarray | float]:
    """Return the values of the names with four wavelengths for one set of four of the file.

    A last set that is not full repeats its last wavelength.
    """
    n = description.wavelength_nm.size
    rows = np.minimum(np.arange(SET_SIZE) + SET_SIZE * set_index, n - 1)
    glow = np.zeros(n) if description.ground_glow is None else description.ground_glow
    values: dict[str, np.ndarray | float] = {
        "wavelengths": description.wavelength_nm[rows],
        "wlSetIndex": set_index,
        "groundAlbedo": description.ground_albedo[rows],
        "solarIrradianceAtTOA": description.solar_irradiance[rows],
        "lightPollutionRelativeRadiance": glow[rows],
    }
    for one in description.scatterers:
        extinction = extinction_cross_section(one, description.wavelength_nm[rows])
        values[_CROSS_SECTION + one.name] = extinction * one.single_scattering_albedo[rows]
    return values


def extinction_cross_section(one: ScattererDescription, wavelength_nm: np.ndarray) -> np.ndarray:
    """Return ``sigma (wavelength / 1000 nm)^-angstrom``, shape (n_wl,). [m2]"""
    return one.cross_section_1um_m2 * (wavelength_nm / 1000.0) ** -one.angstrom_exponent


def moon_of_direction(
    direction: MoonDirection | None, medium: Medium, report: MediumReport, sun_zenith_deg: float, sun_azimuth_deg: float
) -> Moon | None:
    """The Moon in a direction of the sky; none where it is empty. Direction of the sun in degrees."""
    if direction is None or direction.is_empty:
        return None
    if not direction.has_angle:
        raise SceneError("moon_distance_km without a place of the Moon", "give moon_zenith_offset_deg, such as 0")
    zenith, azimuth = (math.radians(angle) for angle in direction.angles(sun_zenith_deg, sun_azimuth_deg))
    if direction.distance_km is not None:
        distance = 1000.0 * direction.distance_km
    elif report.moon_distance_m is not None:
        # from the ground where the centres have a known distance, by the law of cosines
        centres, radius = report.moon_distance_m, medium.earth_radius_m
        across = radius * math.sin(zenith)
        if not abs(across) < centres or not radius < centres:
            raise SceneError(f"a Moon {centres / 1000:g} km from the earth's centre is inside the earth")
        distance = math.sqrt((centres - across) * (centres + across)) - radius * math.cos(zenith)
    else:
        raise SceneError(
            "the distance of the Moon is missing", "write moon_distance_km, or Earth-Moon distance in the description"
        )
    return Moon(zenith_rad=zenith, azimuth_from_sun_rad=azimuth, distance_m=distance)


def glow_of_luminance(luminance_cd_m2: float, report: MediumReport, path: str) -> np.ndarray | None:
    """Radiance of a ground of some luminance, None where that is 0; `path` is for messages. [W m-2 sr-1 nm-1]"""
    luminance = -1.0
    with contextlib.suppress(UsageError):  # what is no number gets the same sentence
        luminance = number("ground_luminance_cd_m2", luminance_cd_m2)
    if not 0.0 <= luminance < math.inf:
        raise SceneError(f"the luminance of the ground must be 0 cd/m2 or more, got {shown_value(luminance_cd_m2)}")
    if luminance == 0.0:
        return None
    if report.ground_glow is None:
        raise SceneError(f"{path} has no 'light pollution relative radiance', the colour of the ground's light")
    return np.asarray(luminance * report.ground_glow)
