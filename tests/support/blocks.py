"""Code blocks for tests: text in, function of arrays out."""

import numpy as np

from aomc_sky.errors import SourceText
from aomc_sky.skies.atmosphere.language.block import read_block
from aomc_sky.skies.atmosphere.language.values import Type

FIRST_LINE = 10
TYPES = {
    "PI": Type.FLOAT,
    "km": Type.FLOAT,
    "dobsonUnit": Type.FLOAT,
    "wavelengths": Type.VEC4,
    "wlSetIndex": Type.INT,
    "earthCenter": Type.VEC3,
}
WAVELENGTHS = np.array([400.0, 500.0, 600.0, 700.0])
GIVEN = {
    "PI": np.pi,
    "km": 1000.0,
    "dobsonUnit": 2.687e20,
    "wavelengths": WAVELENGTHS,
    "wlSetIndex": 1,
    "earthCenter": np.array([0.0, 0.0, -6.371e6]),
}


def source_of(text):
    """The text as line FIRST_LINE and following of a file."""
    return SourceText(text=text, path="a.atmo", line=FIRST_LINE)


def density_block(text):
    return read_block(
        source_of(text), subject="number density", gives=Type.FLOAT, argument="altitude", unit="m", given=TYPES
    )


def phase_block(text):
    return read_block(source_of(text), subject="phase function", gives=Type.VEC4, argument="dotViewSun", given=TYPES)


def at(text, *altitudes):
    return density_block(text)(np.array(altitudes), GIVEN).tolist()


def value_of(expression):
    """Value of an expression of type float, int or bool, at altitude 1000."""
    return at(f"return float({expression});", 1000.0)[0]
