"""An atmosphere as a description file has it: numbers in SI, spectra on its wavelengths, code as text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from aomc_sky.errors import SourceText
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.atmosphere.phase_table import PhaseTable


class PhaseFunctionType(Enum):
    """Type of a phase function; a promise that lets a solver save work."""

    GENERAL = "general"
    ACHROMATIC = "achromatic"
    SMOOTH = "smooth"


@dataclass(frozen=True, kw_only=True, slots=True)
class ScattererDescription:
    """One species that scatters, and absorbs where its albedo is below 1."""

    name: str  #: Lower-case letters, digits and underscores
    line: int  #: First line of its section. [1-based]
    number_density: SourceText  #: Body of a function of the altitude. [m to m-3]
    #: Body of a function of the cosine of the scattering angle, for four wavelengths at once [sr-1], or a table
    phase_function: SourceText | PhaseTable
    cross_section_1um_m2: float  #: Extinction cross section at 1000 nm. [m2, 1e-35 to 1]
    angstrom_exponent: float  #: The extinction cross section falls as the wavelength to this power. [-10 to 10]
    single_scattering_albedo: np.ndarray  #: float64 (n_wl,), share of the extinction that is scattering. [0 to 1]
    phase_function_type: PhaseFunctionType = PhaseFunctionType.GENERAL  #: As the file has it, GENERAL by default
    needs_interpolation_guides: bool = False  #: Advice for tables; no physics


@dataclass(frozen=True, kw_only=True, slots=True)
class AbsorberDescription:
    """One species that only absorbs."""

    #: As `ScattererDescription` has them
    name: str
    line: int
    number_density: SourceText
    cross_section_m2: np.ndarray  #: float64 (n_wl,), absorption cross section. [m2, 0 to 10]


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class AtmosphereDescription:
    """The content of a description file."""

    path: str  #: The file as the user named it
    #: Altitude above which there is nothing [m, 1 to 1e6]; radius of the ground [m, 1e-3 to 1e10]
    atmosphere_height_m: float
    earth_radius_m: float
    earth_sun_distance_m: float  #: It sets the size of the solar disc alone, not the irradiance. [m, 0.5 to 1e20 AU]
    earth_moon_distance_m: float | None  #: Needed by eclipses alone. [m, 1e-4 to 1e20 AU]
    scattering_orders: int  #: Most interactions of light with air and ground. [1 to 2^31]
    wavelength_nm: np.ndarray  #: float64 (n_wl,), evenly spaced, rising. [nm, 100 to 100 000]
    #: float64 (n_wl,), above the atmosphere, on a plane normal to the beam. [W m-2 nm-1, 0 to 1000]
    solar_irradiance: np.ndarray
    ground_albedo: np.ndarray  #: float64 (n_wl,), of the Lambertian ground. [0 to 1]
    #: float64 (n_wl,), spectral radiance of a ground that glows with 1 cd/m2. [W m-2 sr-1 nm-1]
    ground_glow: np.ndarray | None
    #: Luminance of that spectrum as the file has it, before it was divided by it. [cd m-2]
    glow_luminance_cd_m2: float | None
    species: tuple[ScattererDescription | AbsorberDescription, ...]  #: In the order of the file; names are unique
    #: Texture sizes and numbers of integration points that the file gives, by their keys in lower case. [1 or more]
    sizes: Mapping[str, int]
    #: Directives of the tool that this format comes from
    textures_are_radiances: bool
    has_eclipsed_double_scattering_textures: bool
    texts: tuple[str, ...] = field(default=(), compare=False)  #: A note that quotes the comments of its tables, if any

    __eq__ = same_content
    __repr__ = short_repr

    @property
    def scatterers(self) -> tuple[ScattererDescription, ...]:
        """Species that scatter, in the order of the file."""
        return tuple(s for s in self.species if isinstance(s, ScattererDescription))

    @property
    def absorbers(self) -> tuple[AbsorberDescription, ...]:
        """Species that only absorb, in the order of the file."""
        return tuple(s for s in self.species if isinstance(s, AbsorberDescription))
