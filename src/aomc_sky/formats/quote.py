"""What a file says in words is shown to a person, and changes nothing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from aomc_sky.formats.report import printable

_PLAIN = (
    "zenith angle", "viewing zenith angle", "view zenith angle", "azimuth", "azimuth angle", "viewing azimuth angle",
    "view azimuth angle", "radiance", "sky radiance", "spectral radiance", "wavelength", "zenith_angle",
    "sensor_zenith_angle", "platform_zenith_angle", "sensor_azimuth_angle", "platform_azimuth_angle",
    "radiation_wavelength", "sensor_band_central_radiation_wavelength",
    "downwelling_radiance_per_unit_wavelength_in_air",
)  # fmt: skip
"""Texts that say no more than a name does, and standard names of CF alike."""
_NEVER_QUOTED = (
    "units", "unit", "bounds", "axis", "calendar", "coordinates", "cell_measures", "grid_mapping", "_FillValue",
    "missing_value", "valid_min", "valid_max", "valid_range", "scale_factor", "add_offset", "azimuth_convention",
    "sun_zenith_deg", "sun_azimuth_deg", "Conventions", "history", "institution", "source", "references",
)  # fmt: skip
"""Attributes that state something, or where a file comes from."""
_SPEAK_ALONE = ("long_name", "standard_name", "comment", "title", "description")
MOST_TEXTS, MOST_NEARBY = 5, 3
SAYS, UNUSED, BRIGHTEST = "the file says", "not used:", "brightest sky:"
"""How the three notes begin that are always shown: what a person should read."""


def quote(texts: Iterable[str]) -> list[str]:
    """The note of what a file says in words, a list of one; empty without texts that say more than a name."""
    said = dict.fromkeys(" ".join(text.split()) for text in texts)
    said = {text: None for text in said if text and text.lower().rstrip(".") not in _PLAIN}
    shown = [f'"{printable(text)}"' for text in list(said)[:MOST_TEXTS]]
    more = f"; and {len(said) - MOST_TEXTS} more" if len(said) > MOST_TEXTS else ""
    return [f"{SAYS} {'; '.join(shown)}{more} (texts change nothing)"] if said else []


def with_texts(question: str, texts: Iterable[str]) -> str:
    """A question, with what the file says in words nearby."""
    said = "; ".join(f'"{printable(text)}"' for text in list(texts)[:MOST_NEARBY])
    return f"{question}; its text says {said}" if said else question


def unused_note(what: Mapping[str, Iterable[str]]) -> list[str]:
    """The note of columns, variables and the like that were not used, a list of one; empty without any."""
    named = {kind: list(names) for kind, names in what.items()}
    shown = [
        f"{kind} {', '.join(map(printable, names[:MOST_TEXTS]))}"
        + (f" and {len(names) - MOST_TEXTS} more" if len(names) > MOST_TEXTS else "")
        for kind, names in named.items()
        if names
    ]
    return [f"{UNUSED} {'; '.join(shown)}"] if shown else []


MOST_NOTES = 2


def shown_notes(notes: Sequence[str]) -> tuple[list[str], int]:
    """The notes of a scene that a person reads without asking, and how many others there are.

    What a file says, and names that were not used, are always shown, and two others: first those on inputs that are
    not used, then the light that was found.
    """
    is_quote = [SAYS in note or f": {UNUSED}" in f": {note}" for note in notes]
    others = [note for note, quoted in zip(notes, is_quote, strict=True) if not quoted]
    kept = sorted(others, key=lambda note: (UNUSED not in note, BRIGHTEST not in note))[:MOST_NOTES]
    shown = [note for note, quoted in zip(notes, is_quote, strict=True) if quoted or note in kept]
    return shown, len(notes) - len(shown)


def texts_of(attributes: Mapping[str, Any]) -> list[str]:
    """What attributes say in words or numbers, beside those that state something: 'gain: 0.1'."""
    texts = []
    for name, value in attributes.items():
        if str(name) not in _NEVER_QUOTED:
            texts.append(str(value) if str(name) in _SPEAK_ALONE else f"{name}: {value}")
    return texts
