"""A scene lit by the sun and the clear sky of an atmosphere description, in absolute units."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.formats.sky_toml.keys import GLOW_KEY
from aomc_sky.formats.sky_toml.sections import AtmosphereSection, moon_direction
from aomc_sky.formats.units import AU_M
from aomc_sky.grid import PatchGrid
from aomc_sky.options import AMOUNTS, LIGHTS
from aomc_sky.skies.atmosphere.description.medium import MediumReport, glow_of_luminance, moon_of_direction, read_medium
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.model import AtmosphereSky
from aomc_sky.source.light.brightness import DIFCOL
from aomc_sky.source.light.join import Light
from aomc_sky.source.light.place import place_of
from aomc_sky.source.light.said import Speakers, first, is_diffuse_only, moment_said, sun_said
from aomc_sky.source.light.unused import names_said, note_of_sun, refuse_names
from aomc_sky.wavebands import Wavebands, nearest_wavelength_index

_NEAREST_AU, _FARTHEST_AU = 0.98, 1.02


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneAtmosphere:
    """[atmosphere] of sky.toml with its description evaluated at the wavelengths of the scene."""

    section: AtmosphereSection
    medium: Medium
    report: MediumReport
    earth_sun_distance_au: float  #: for which the description has the sun's irradiance


def read_atmosphere(
    section: AtmosphereSection, lambbot: Wavebands | None, allow_paths: Sequence[str] = ()
) -> SceneAtmosphere:
    """Read a description and evaluate it, at the wavelengths of the wavebands if there is `lambbot`."""
    wavelength = None if lambbot is None else lambbot.wavelength_nm
    description = read_atmo(section.file, allow_paths=allow_paths)
    medium, report = read_medium(description, wavelength)
    distance = description.earth_sun_distance_m / AU_M
    return SceneAtmosphere(section=section, medium=medium, report=report, earth_sun_distance_au=distance)


def _is_earth(atmosphere: SceneAtmosphere) -> bool:
    """Whether the description's sun is as far as the Earth's on some day."""
    return _NEAREST_AU < atmosphere.earth_sun_distance_au < _FARTHEST_AU


def _with_lights(atmosphere: SceneAtmosphere, lights: Mapping[str, float]) -> SceneAtmosphere:
    """The same; Moon and glow of the ground from the caller (`checked_lights`) come first."""
    section = atmosphere.section
    section = dataclasses.replace(
        section,
        moon=section.moon.under(moon_direction(lights)),
        ground_luminance_cd_m2=lights.get(GLOW_KEY, section.ground_luminance_cd_m2),
    )
    return dataclasses.replace(atmosphere, section=section)


_USED = (
    "zenith_deg", "azimuth_deg", "time", "latitude_deg", "longitude_deg", "disc", "disc:False", "diffuse_only",
    "polarisation", *LIGHTS,
)  # fmt: skip
"""Inputs that an atmosphere uses."""


def atmosphere_light(
    speakers: Speakers, given: Sequence[str], *, bands: Wavebands, atmosphere: SceneAtmosphere
) -> Light:
    """Sun and sky of an atmosphere, in absolute units; the beam has the solar disc unless someone says otherwise.

    With a date the sun has its distance of that day. `given` are further inputs of the caller.
    """
    names, what = (*names_said(speakers), *given), "the atmosphere of sky.toml"
    hint = dict.fromkeys(names, "; leave it out") | dict.fromkeys(AMOUNTS, "; write {sky:perez} to use it")
    used = {*_USED, *(["altitude_m"] if "time" in names else [])}
    refuse_names(names, used, light=what, sky=what, hint=hint)
    lights = {name: value for one in speakers for name, value in one.lights.items()}
    atmosphere, moment = _with_lights(atmosphere, lights), moment_said(speakers)
    sun = place_of(speakers, "an atmosphere", may_have_set=True)
    if moment is not None:  # rays through the description's air are straight
        sun = dataclasses.replace(sun, zenith_deg=moment.true_zenith_deg)
    is_alone, has_disc = is_diffuse_only(speakers), sun_said(speakers).disc is not False
    section, medium = atmosphere.section, atmosphere.medium
    if sun.distance_factor is not None and _is_earth(atmosphere):
        factor = sun.distance_factor * atmosphere.earth_sun_distance_au**2
        medium = dataclasses.replace(medium, toa_irradiance=medium.toa_irradiance * factor)
    sky = AtmosphereSky(
        medium=medium,
        sun_zenith_deg=sun.zenith_deg,
        sun_azimuth_deg=sun.azimuth_deg,
        method=section.method,  # type: ignore[arg-type]  # read by its rule
        n_orders=section.orders,
        grid=PatchGrid.regular(section.zenith_bins, section.azimuth_bins),
        disc=has_disc,
        moon=moon_of_direction(section.moon, medium, atmosphere.report, sun.zenith_deg, sun.azimuth_deg),
        ground_radiance=glow_of_luminance(section.ground_luminance_cd_m2, atmosphere.report, section.file),
        n_paths=section.paths,
        seed=section.seed,
        polarisation=sun.polarisation,
    )
    beam = () if is_alone else tuple(sky.beam(medium.wavelength_nm))
    components = (*beam, *sky.lower(medium.wavelength_nm))
    rows = nearest_wavelength_index(bands.wavelength_nm, medium.wavelength_nm)
    shares = first([one.shares for one in speakers])
    return Light(
        components=components,
        row_of_band=rows,
        sky_wavelength_nm=medium.wavelength_nm[rows],
        intensity=None if shares is None else shares.intensity,
        notes=(
            *filter(None, (note_of_sun(speakers, sun.zenith_deg),)),
            *_notes(sky, atmosphere, is_alone=is_alone, has_date=moment is not None, has_shares=shares is not None),
            *sun.notes,
        ),
        options={
            "sky": "atmosphere",
            "sun": {**sun.as_options(), "disc": has_disc},
            "atmosphere": _options(sky, atmosphere),
        },
        irradiance=Irradiance(of_component=np.stack([c.strength[rows] for c in components], axis=1)),
    )


def _options(sky: AtmosphereSky, atmosphere: SceneAtmosphere) -> dict[str, Any]:
    """The solution as JSON values for the manifest."""
    return {
        "file": atmosphere.section.file,
        "method": sky.solved.method,
        "orders": sky.solved.n_orders,
        "paths": sky.solved.n_paths or None,
        **({"seed": sky.seed} if sky.seed else {}),
        "paths_error": sky.solved.resolution_error if sky.solved.n_paths else None,
        "zenith_bins": sky.grid.n_zenith,
        "azimuth_bins": sky.grid.n_azimuth,
        "wavelength_nm": sky.medium.wavelength_nm.tolist(),
        "species": [part.name for part in sky.medium.constituents],
        "dropped": list(atmosphere.report.dropped),
        "truncation": None if sky.solved.later_orders is None else float(sky.solved.truncation.max()),
        "patch_change": sky.patch_change,
        "ground_luminance_cd_m2": atmosphere.section.ground_luminance_cd_m2,
        "eclipse": _eclipse_options(sky),
    }


def _eclipse_options(sky: AtmosphereSky) -> dict[str, float] | None:
    """Position of a Moon that hides part of the sun, and the share of the sun that the observer sees."""
    moon = sky.solved.moon
    if moon is None:
        return None
    return {
        "moon_zenith_deg": math.degrees(moon.zenith_rad),
        "moon_azimuth_deg": math.degrees(moon.azimuth_from_sun_rad) + sky.sun_azimuth_deg,
        "moon_distance_km": moon.distance_m / 1000.0,
        "visible_share": sky.solved.visible_share,
    }


def _notes(
    sky: AtmosphereSky, atmosphere: SceneAtmosphere, *, is_alone: bool, has_date: bool, has_shares: bool
) -> tuple[str, ...]:
    direct, diffuse = sky.direct_irradiance, sky.diffuse_irradiance
    total = direct + diffuse
    share = np.divide(direct, total, out=np.zeros_like(total), where=total > 0)
    low, high = f"{share.min():.4g}", f"{share.max():.4g}"
    solved = sky.solved
    orders = "one order" if solved.n_orders == 1 else f"{solved.n_orders} orders"
    n_nm, errors = sky.medium.wavelength_nm.size, ""
    if solved.n_paths:
        errors = f"; known to {float(f'{100 * solved.resolution_error:.2g}'):g} %, by {solved.n_paths} paths"
    notes = [
        f"atmosphere: {atmosphere.section.file}, method {solved.method}, {orders}, {n_nm} "
        f"wavelength{'s' * (n_nm > 1)}; direct fraction {low if low == high else f'{low} to {high}'}{errors}"
    ]
    if solved.moon is not None:
        notes.append(f"atmosphere: the observer sees {solved.visible_share:.4g} of the sun's disc beside the Moon")
    elif sky.moon is not None:
        notes.append("atmosphere: the Moon hides no part of the sun from anywhere in the air; it is left out")
    if solved.glow is not None:
        luminance = atmosphere.section.ground_luminance_cd_m2
        notes.append(f"atmosphere: the ground glows with {luminance:g} cd/m2; glow known to {solved.glow_error:.1g}")
    notes += sky.notes(sky.medium.wavelength_nm)
    if solved.reason:
        notes.append(f"atmosphere: method {solved.method} because {solved.reason}")
    if solved.later_orders is not None:
        notes.append(f"atmosphere: the orders left out hold about {solved.truncation.max():.2g} of the sky's light")
    if atmosphere.report.dropped:
        notes.append(f"atmosphere: too thin to matter, left out: {', '.join(atmosphere.report.dropped)}")
    if is_alone:
        notes.append("atmosphere: the beam is left out")
    if has_date and not _is_earth(atmosphere):
        distance = atmosphere.earth_sun_distance_au
        notes.append(f"atmosphere: its sun is {distance:g} AU away, so the date does not change its irradiance")
    if has_shares:
        notes.append(f"{DIFCOL}: its direct fractions are not used: the light is that of the atmosphere")
    return tuple(notes)
