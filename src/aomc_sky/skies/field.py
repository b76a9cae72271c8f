"""A field of radiances with coordinates becomes a table: what is read, said, and seen in its light."""

from __future__ import annotations

from typing import Any

from aomc_sky.formats.quote import quote, texts_of, unused_note
from aomc_sky.formats.radiance_words import Stated
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.field_choice import SUN_NAMES, Chosen
from aomc_sky.skies.polarised_field import read_polarised_field
from aomc_sky.skies.quadrature import centres_deg
from aomc_sky.skies.radiance_field import read_radiance_field
from aomc_sky.skies.witnesses import brightest_note, warn_of_light

_OURS = "aomc-sky "  #: How the attribute source of our own files begins.


def read_field(
    chosen: Chosen, stated: Stated, *, grid: PatchGrid | None, sun: tuple[float | None, float | None]
) -> tuple[dict[str, Any], tuple[float | None, float | None]]:
    """Arguments of a `TabulatedSky`, and the sun by caller or file [deg]; what is to be seen is noted and warned of."""
    read_it = read_radiance_field if chosen.stokes is None else read_polarised_field
    made = read_it(chosen, stated, grid=grid, sun=sun)
    read, sun, convention, used = made.arguments, made.sun, made.convention, made.names
    patches = read["grid"]
    zenith, azimuth = (one.ravel() for one in centres_deg(patches))
    values = read["values"].reshape(len(read["values"]), -1)
    light = {"zenith_deg": zenith, "azimuth_deg": azimuth}
    polarised = {key: read[key][0].ravel() for key in ("values_q", "values_u") if key in read}
    warn_of_light(values[0], **light, sun_deg=sun, convention=convention, **polarised)
    irradiance = float(values[0] @ patches.projected_solid_angle_sr)
    nm = float(read["wavelength_nm"][0]) if read["has_wavelength"] else None
    brightest = brightest_note(values[0], zenith, azimuth, irradiance, read["radiance_unit"], nm)
    return {**read, "remarks": (*_said(chosen, used), brightest, *read["remarks"])}, sun


def _said(chosen: Chosen, used: tuple[str, ...]) -> list[str]:
    """The notes of what the file says in words, and of what was not used; our own files say nothing new."""
    if str(chosen.attributes.get("source", "")).startswith(_OURS):
        return quote(texts_of({"comment": chosen.attributes.get("comment", "")}))
    field = chosen.radiance
    parts = [field.attrs, *(field.coords[name].attrs for name in used), chosen.attributes]
    texts = [text for part in parts for text in texts_of(part)]
    unused = [name for name in chosen.others if name not in (*used, *SUN_NAMES)]
    return [*quote(texts), *unused_note({"variables": unused})]
