"""From where azimuths count and which way: the words that options, keys and attributes may hold."""

from __future__ import annotations

from typing import Literal

from aomc_sky.directions import AzimuthConvention, ConventionWord
from aomc_sky.errors import UsageError
from aomc_sky.formats.report import quoted

_STARTS = {
    "east": (0.0,),
    "north": (90.0,),
    "south": (-90.0,),
    "west": (180.0,),
    "the sun": (0.0, "sun"),
    "the antisun": (180.0, "sun"),
}
_SENSES = {"clockwise": -1.0, "counterclockwise": 1.0}
WORDS = {
    f"{sense} from {start}": AzimuthConvention((offset, turn, *sun))
    for sense, turn in _SENSES.items()
    for start, (offset, *sun) in _STARTS.items()
}
"""The twelve conventions in words."""
_KNOWN = {**WORDS, **{one.name.lower(): one for one in AzimuthConvention}}
AzimuthWord = (
    ConventionWord
    | Literal[
        "clockwise from east",
        "clockwise from north",
        "clockwise from south",
        "clockwise from west",
        "clockwise from the sun",
        "clockwise from the antisun",
        "counterclockwise from east",
        "counterclockwise from north",
        "counterclockwise from south",
        "counterclockwise from west",
        "counterclockwise from the sun",
        "counterclockwise from the antisun",
    ]
)
OURS = "0 is +x, growing towards +y"
"""The sentence of our own netCDF files since release 0.2."""

AZIMUTH_FORMS = (
    "'clockwise from north' or the like: clockwise or counterclockwise, from north, east, south, west, the sun or the "
    "antisun"
)
SAY_AZIMUTH = f"write --azimuth-convention (azimuth_convention=) {AZIMUTH_FORMS}"


def convention_of(text: str) -> AzimuthConvention | None:
    """The convention that a text is the name of; None for any other text."""
    return _KNOWN.get(" ".join(text.lower().split()))


def words_of(convention: AzimuthConvention) -> str:
    """The convention in words."""
    return next(words for words, one in WORDS.items() if one is convention)


def given_convention(value: AzimuthConvention | str) -> AzimuthConvention:
    """The convention that a caller gives, a member or its words; UsageError."""
    found = value if isinstance(value, AzimuthConvention) else convention_of(str(value))
    if found is None:
        raise UsageError(f"azimuth_convention: {quoted(str(value))} is no convention; {SAY_AZIMUTH}")
    return found
