"""A field of radiances with coordinates becomes a table: what is read, said, and seen in its light."""

from __future__ import annotations

from typing import Any

from aomc_sky.formats.quote import quote, texts_of, unused_note
from aomc_sky.formats.radiance_words import RADIANCE, Stated, SunAngles
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.field_choice import SUN_NAMES, Chosen
from aomc_sky.skies.polarised_field import read_polarised_field
from aomc_sky.skies.quadrature import centres_deg
from aomc_sky.skies.radiance_field import read_radiance_field
from aomc_sky.skies.witnesses import brightest_note, warn_of_light

_OURS = "aomc-sky "  #: How the attribute source of our own files begins.
_OUR_ATTRIBUTES = (
    "title", "long_name", "directions", "component", "law", "zenith_deg", "azimuth_deg", "plan_sha256", "stream",
    "seed", "allocation", "placement", "order", "replicates", "footprint", "description_file", "scattering_orders",
    "sun_angular_radius_deg", "standard_name",
)  # fmt: skip
"""What our own files have, tests/source/read/test_one_field.py."""


def read_field(
    chosen: Chosen, stated: Stated, *, grid: PatchGrid | None, sun: SunAngles, other_sun: SunAngles = (None, None)
) -> tuple[dict[str, Any], SunAngles]:
    """Arguments of a `TabulatedSky`, and the angles of the sun of the file; what is to be seen is noted and warned of.

    An angle of the sun is that of the caller, else of the file, else of `other_sun`. [deg]
    """
    read_it = read_radiance_field if chosen.stokes is None else read_polarised_field
    made = read_it(chosen, stated, grid=grid, sun=sun, other_sun=other_sun)
    read, patches = made.arguments, made.arguments["grid"]
    zenith, azimuth = (one.ravel() for one in centres_deg(patches))
    values = read["values"].reshape(len(read["values"]), -1)
    light = {"zenith_deg": zenith, "azimuth_deg": azimuth}
    polarised = {key: read[key][0].ravel() for key in ("values_q", "values_u") if key in read}
    signs = stated.stokes_signs or (1, 1)
    warn_of_light(values[0], **light, sun_deg=made.sun, convention=made.convention, stokes_signs=signs, **polarised)
    irradiance = float(values[0] @ patches.projected_solid_angle_sr)
    nm = float(read["wavelength_nm"][0]) if read["has_wavelength"] else None
    around = None if made.convention is None else azimuth
    brightest = brightest_note(values[0], zenith, around, irradiance, read["radiance_unit"], nm)
    remarks = (*_said(chosen, stated, made.names), brightest, *read["remarks"])
    return {**read, "remarks": remarks}, made.sun_of_file


def _said(chosen: Chosen, stated: Stated, used: tuple[str, ...]) -> list[str]:
    """The notes of what the file says in words, and of what was not used; what our own files say is no news."""
    field, stokes = chosen.radiance, chosen.stokes or ()
    is_ours = str(chosen.attributes.get("source", "")).startswith(_OURS)
    texts = [f"variable: {field.name}"] if field.name not in (RADIANCE, stated.variable) else []
    parts = [
        field.attrs,
        *(one.attrs for one in stokes),
        *(field.coords[name].attrs for name in used),
        chosen.attributes,
    ]
    for part in parts:
        texts += texts_of({key: value for key, value in part.items() if not (is_ours and key in _OUR_ATTRIBUTES)})
    unused = [name for name in chosen.others if name not in (*used, *SUN_NAMES)]
    unused = [name for name in unused if not is_ours or name.startswith("mass_")]
    return [*quote(texts), *unused_note({"variables": unused})]
