"""Names that the code blocks of an atmosphere description can read, and their values."""

from __future__ import annotations

import numpy as np

from aomc_sky.atmosphere.language.nodes import Type
from aomc_sky.formats.atmo.data import AtmosphereDescription, ScattererDescription

SUN_RADIUS_M = 6.9635e8
MOON_RADIUS_M = 1.7371e6
# molecules per square metre and Dobson unit, as the tool that defines the format has it
DOBSON_UNIT_M2 = 2.687e20
SET_SIZE = 4

_CROSS_SECTION = "scatteringCrossSection_"
_COMMON_TYPES = {
    "PI": Type.FLOAT,
    "km": Type.FLOAT,
    "dobsonUnit": Type.FLOAT,
    "earthRadius": Type.FLOAT,
    "atmosphereHeight": Type.FLOAT,
    "earthCenter": Type.VEC3,
    "moonRadius": Type.FLOAT,
    "sunAngularRadius": Type.FLOAT,
}
_SPECTRAL_TYPES = {
    "wavelengths": Type.VEC4,
    "wlSetIndex": Type.INT,
    "groundAlbedo": Type.VEC4,
    "solarIrradianceAtTOA": Type.VEC4,
    "lightPollutionRelativeRadiance": Type.VEC4,
}
_TABLE_NAMES = (
    "transmittanceTextureSize",
    "irradianceTextureSize",
    "scatteringTextureSize",
    "eclipsedSingleScatteringTextureSize",
    "lightPollutionTextureSize",
    "radialIntegrationPoints",
    "angularIntegrationPoints",
    "lightPollutionAngularIntegrationPoints",
    "eclipseAngularIntegrationPoints",
    "numTransmittanceIntegrationPoints",
)
_TABLE_HINTS = dict.fromkeys(_TABLE_NAMES, "sizes of tables are no physics: write the number")


def sun_angular_radius(description: AtmosphereDescription) -> float:
    """Return the radius of the sun over its distance. [rad]"""
    return SUN_RADIUS_M / description.earth_sun_distance_m


def density_names(description: AtmosphereDescription) -> tuple[dict[str, Type], dict[str, str]]:
    """Return the names that a number density reads, with types, and hints for those that it does not.

    A number of particles has no wavelength: names with four wavelengths are not among them.
    """
    spectral = [*_SPECTRAL_TYPES, *(_CROSS_SECTION + one.name for one in description.scatterers)]
    hints = dict.fromkeys(spectral, "a number of particles does not depend on the wavelength")
    hints |= _TABLE_HINTS | {"dotViewSun": "a number density depends on altitude alone"}
    return dict(_COMMON_TYPES), hints


def phase_names(description: AtmosphereDescription) -> tuple[dict[str, Type], dict[str, str]]:
    """Return the names that a phase function reads, with types, and hints for those that it does not."""
    types = _COMMON_TYPES | _SPECTRAL_TYPES
    types |= {_CROSS_SECTION + one.name: Type.VEC4 for one in description.scatterers}
    return types, _TABLE_HINTS | {"altitude": "a phase function depends on dotViewSun and the wavelengths alone"}


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
    """Return the values of the names with four wavelengths for one set of four.

    The sets are those of the file, so that a block may tell them apart; a last set that is not full repeats its last
    wavelength.
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
