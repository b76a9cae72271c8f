"""Every key of a description file, and what it accepts."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from aomc_sky.formats.units import AU_M, Dimension

FORMAT_VERSION = 6
MAX_INTEGER = 2**31 - 1
"""Largest size of a texture and largest number of points that the tool accepts."""
MAX_ORDERS = 2**31


@dataclass(frozen=True, kw_only=True, slots=True)
class Quantity:
    """A number with a unit, low <= value <= high in m or m2; `document_low` is the narrower limit of the document."""

    dimension: Dimension
    low: Fraction
    high: Fraction
    shown: str
    document_low: Fraction | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Real:
    """A number without unit."""

    low: float
    high: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Integer:
    """A whole number from 1 on."""

    is_even: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Spectral:
    """A spectrum; every value of it on the wavelengths lies in 0 to high; `is_glow` where its luminance counts."""

    high: float
    unit: str
    is_glow: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Code:
    """A code block."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Word:
    """One of some words."""

    words: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Version:
    """The version of the format."""


@dataclass(frozen=True, kw_only=True, slots=True)
class WavelengthRange:
    """``min=...,max=...,count=...``."""


Rule = Quantity | Real | Integer | Spectral | Code | Word | Version | WavelengthRange


def _length(low: Fraction | int, high: int, shown: str, document_low: int | None = None) -> Quantity:
    return Quantity(
        dimension=Dimension.LENGTH,
        low=Fraction(low),
        high=Fraction(high),
        shown=shown,
        document_low=None if document_low is None else Fraction(document_low),
    )


SIZES = (
    "transmittance texture size for vza",
    "transmittance texture size for altitude",
    "irradiance texture size for sza",
    "irradiance texture size for altitude",
    "scattering texture size for vza",
    "scattering texture size for dot(view,sun)",
    "scattering texture size for sza",
    "scattering texture size for altitude",
    "eclipsed scattering texture size for relative azimuth",
    "eclipsed scattering texture size for vza",
    "eclipsed double scattering texture size for relative azimuth",
    "eclipsed double scattering texture size for vza",
    "eclipsed double scattering texture size for sza",
    "eclipsed double scattering number of azimuth pairs to sample",
    "eclipsed double scattering number of elevation pairs to sample",
    "light pollution texture size for vza",
    "light pollution texture size for altitude",
    "light pollution angular integration points",
    "transmittance integration points",
    "radial integration points",
    "angular integration points",
    "angular integration points for eclipse",
)
"""Keys of whole numbers, in lower case as all keys here."""

WAVELENGTHS = "wavelengths"
SOLAR = "solar irradiance at toa"
ALBEDO = "ground albedo"
GLOW = "light pollution relative radiance"

TOP_KEYS: dict[str, Rule] = {
    "version": Version(),
    **{key: Integer(is_even=key == "scattering texture size for vza") for key in SIZES},
    "scattering orders": Real(low=1, high=MAX_ORDERS),
    "atmosphere height": _length(1, 10**6, "1 m to 1 Mm"),
    "earth radius": _length(Fraction(1, 1000), 10**10, "1 mm to 10 Gm", 100_000),
    "earth-sun distance": _length(Fraction(AU_M, 2), 10**20 * AU_M, "0.5 AU to 1e20 AU"),
    "earth-moon distance": _length(Fraction(AU_M, 10**4), 10**20 * AU_M, "1e-4 AU to 1e20 AU"),
    WAVELENGTHS: WavelengthRange(),
    SOLAR: Spectral(high=1000.0, unit="W m-2 nm-1"),
    ALBEDO: Spectral(high=1.0, unit=""),
    GLOW: Spectral(high=1000.0, unit="W m-2 sr-1 nm-1 per cd m-2", is_glow=True),
}

SCATTERER_KEYS: dict[str, Rule] = {
    "number density": Code(),
    "phase function": Code(),
    "phase function type": Word(words=("general", "achromatic", "smooth")),
    "cross section at 1 um": Quantity(
        dimension=Dimension.AREA, low=Fraction(1, 10**35), high=Fraction(1), shown="1e-35 m^2 to 1 m^2"
    ),
    "angstrom exponent": Real(low=-10, high=10),
    "single scattering albedo": Spectral(high=1.0, unit=""),
}

ABSORBER_KEYS: dict[str, Rule] = {
    "number density": Code(),
    "cross section": Spectral(high=10.0, unit="m2"),
}

SECTION_KEYS = {"scatterer": SCATTERER_KEYS, "absorber": ABSORBER_KEYS}

REQUIRED = {
    "": (WAVELENGTHS, SOLAR, "atmosphere height", "earth radius", "scattering orders"),
    "scatterer": ("number density", "phase function", "cross section at 1 um", "angstrom exponent"),
    "absorber": ("number density", "cross section"),
}
"""Keys without which a description, or a section of it, says too little."""

EXAMPLES = {
    WAVELENGTHS: "wavelengths: min=400nm,max=700nm,count=16",
    SOLAR: "solar irradiance at TOA: file solar.csv",
    "atmosphere height": "atmosphere height: 120 km",
    "earth radius": "Earth radius: 6371 km",
    "scattering orders": "scattering orders: 4",
    "number density": "number density: and a code block below",
    "phase function": "phase function: and a code block below",
    "cross section at 1 um": "cross section at 1 um: 0.03914 fm^2",
    "angstrom exponent": "angstrom exponent: 4.095",
    "cross section": "cross section: file ozone.csv",
}
"""What to write for a required key that is missing."""

DIRECTIVES = ("all textures are radiances", "no eclipsed double scattering textures")
SCATTERER_DIRECTIVE = "needs interpolation guides"
