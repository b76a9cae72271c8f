"""amc.inp and the files beside it become a scene."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.errors import InputFileError, SceneError, UsageError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.aomc.amc import AmcConfig, FootprintCode
from aomc_sky.formats.sky_toml.file import problem_of_key
from aomc_sky.formats.sky_toml.keys import SKY_TOML, moment_text
from aomc_sky.formats.sky_toml.sections import BackgroundSection
from aomc_sky.options import listed
from aomc_sky.plan.allocation import MAX_PHOTONS, AllocationMethod
from aomc_sky.plan.options import Footprint, Order, Placement, SamplingOptions
from aomc_sky.source.light.join import BEAM, Files, Light, in_absolute_units, light_of
from aomc_sky.source.light.said import Said, Speakers, moment_said, said_by_caller, said_by_toml
from aomc_sky.source.light.skies import Model, Named, Sky, Uniform, model_of, perez_of, with_sun_of
from aomc_sky.source.light.unused import names_said, refuse_names
from aomc_sky.source.read.files import COMPAT_NAME, GIVEN, Reading, SceneFiles, read_scene_files, sun_of
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import listed_bands, only_bands

if TYPE_CHECKING:
    from aomc_sky.formats.aomc.skydist import BinsWord
    from aomc_sky.skies.perez.sky import WithinWord
    from aomc_sky.skies.polarisation import RayleighPattern
    from aomc_sky.skies.tabulated import WeightingWord
    from aomc_sky.source.read.files import AzimuthBinsWord, CompatWord

AOMC_TABLE_PRESET = SamplingOptions(allocation=AllocationMethod.AOMC, placement=Placement.CENTRE, order=Order.PATCH)
AOMC_INTERNAL_PRESET = SamplingOptions(
    allocation=AllocationMethod.MULTINOMIAL, placement=Placement.PHILOX, order=Order.SHUFFLED
)


@in_default_mode
def read_scene(
    path: str | os.PathLike[str],
    *,
    iterations: int | None = None,
    sky: Any = None,
    bins: BinsWord | None = None,
    weighting: WeightingWord | None = None,
    compat: CompatWord | None = None,
    lenient: bool = False,
    azimuth_bins: AzimuthBinsWord = "n+1",
    wavebands: Sequence[int] | None = None,
    perez: Mapping[str, Any] | None = None,
    sun: Mapping[str, Any] | None = None,
    atmosphere: Mapping[str, Any] | None = None,
    weather: Mapping[str, Any] | None = None,
    within: WithinWord | None = None,
    clear_sky: Any = None,
    diffuse_only: bool = False,
    polarisation: RayleighPattern | None = None,
    sky_options: Mapping[str, Any] | None = None,
    allow_paths: Sequence[str | os.PathLike[str]] = (),
    max_memory_bytes: int | None = None,
) -> Scene:
    """Read amc.inp and the files beside it.

    Parameters
    ----------
    path : str or path
        amc.inp, or the folder that holds it. lambbot.inp and, by the light-source flag, skydist.inp
        or difcol.inp are read from the same folder, and sky.toml where there is one.
    iterations : int, optional
        Instead of line 1 of amc.inp. [1 to 2^62]
    sky : {"perez", "uniform", "none"}, str, sky model or function, optional
        The diffuse sky of a scene with light-source flag 0, by default "perez"; with flag 1 it replaces the sky file,
        and all light is diffuse unless something says how bright the beam is. "none":
        neither sun nor sky, the backgrounds of sky.toml are the only source. Any other name is that of a named sky such
        as "harrison-coombes", or of a model of another package (entry point group ``aomc_sky.sky_models``). A function
        is of zenith angle, azimuth and wavelength.
    bins : {"equal", "degrees"}, optional
        What the indices of skydist.inp are; default: what the file declares, else equal bins. No other sky uses it.
    weighting : {"listed", "projected", "solid-angle", "aomc"}, optional
        What its values are; default: what the file declares, else listed masses. For a sky model:
        "projected" (default) or "solid-angle".
    compat : {"aomc"}, optional
        Everything as the AOMC 1.2.2 program does it: bins, weighting, wavelength rule, rounding,
        directions, order.
    lenient : bool
        Take Fortran's value, with a warning, where a person would read another one.
    azimuth_bins : {"n+1", "n"}
        "n": azimuth indices 1 to n are n equal bins.
    wavebands : sequence of int, optional
        Only these bands get photons; their photons do not depend on the others. [1-based]
    perez : mapping, optional
        How bright sun and sky are, and the shape of a Perez sky, before all files: one set of two of "dni", "dhi" and
        "ghi" [W m-2], "epsilon" and "delta", or "a" to "e"; "spectrum" ("flat" or "spectrl2"), by which beam and sky
        share each waveband, and without amounts is that of a cloudless sky; and "limits", "air_mass" and
        "extraterrestrial_normal" as for `weather_scene`.
    sun : mapping, optional
        "zenith_deg" [0 to below 90; to 180 under an atmosphere], "azimuth_deg" [-360 to 360] and "disc", which win
        one by one over sky.toml and amc.inp.
    atmosphere : mapping, optional
        Keys of [atmosphere] for the Moon and the glow of the ground, which win over sky.toml: "moon_zenith_deg",
        "moon_distance_km", "ground_luminance_cd_m2" and so on.
    weather : mapping, optional
        When and where, or an hour of a weather file, instead of the angles of `sun`: "time" (ISO 8601 with its zone, or
        a datetime), "latitude_deg" and "longitude_deg" (north and east positive), "altitude_m"; or "weather" (the path
        of an EPW, TMY2 or TMY3 file) and "row" (from 1), which says the irradiances too. Needs the extra `weather`.
    within : {"exact", "uniform"}, optional
        Law of the Perez sky inside a patch: the model's own (default), or constant.
    clear_sky : ClearSky or mapping, optional
        The air of a cloudless sky, whose keys win one by one over [clear_sky] of sky.toml.
    diffuse_only : bool
        Launch the sky without the sun's beam.
    polarisation : RayleighPattern, optional
        Linear polarisation of the sky's light around the sun, which wins over `polarisation` of [sky]. Without both
        photons carry none, but for a field of Q and U.
    sky_options : mapping, optional
        Options of a named sky, which win one by one over the keys of [sky].
    allow_paths : sequence of str or path
        Folders below which the files that sky.toml names may lie, besides that of amc.inp.
    max_memory_bytes : int, optional
        Refuse a sky file that takes more before it takes any; 2 GiB by default. [bytes]

    Returns
    -------
    Scene

    Raises
    ------
    InputFileError
        Every problem of every file.
    SceneError
        The files describe a scene that cannot be sampled.
    UsageError
        Options that contradict each other or the files.

    Examples
    --------
    >>> scene = sky.read_scene("inputs/clear_day", iterations=1000)
    >>> print(scene.wavebands.wavelength_nm)
    [440. 550. 670.]
    """
    speakers = said_by_caller(
        perez=perez,
        sun=sun,
        within=within,
        atmosphere=atmosphere,
        weather=weather,
        clear_sky=clear_sky,
        diffuse_only=diffuse_only,
        polarisation=polarisation,
    )
    reading = Reading(
        iterations=iterations,
        sky=sky,
        bins=bins,
        weighting=weighting,
        compat=compat,
        lenient=lenient,
        azimuth_bins=azimuth_bins,
        wavebands=wavebands,
        sky_options=sky_options or {},
        allow_paths=allow_paths,
        max_memory_bytes=max_memory_bytes,
    )
    return scene_of_files(path, speakers, reading)


def scene_of_files(path: str | os.PathLike[str], callers: Speakers, reading: Reading) -> Scene:
    """The scene of amc.inp and the files beside it, and of what a caller says about the light."""
    files, compat = read_scene_files(path, callers, reading), reading.compat
    bands, moment = files.bands, moment_said(callers)
    if compat is not None and (names := names_said(callers)):
        raise UsageError(f"{COMPAT_NAME} does not use {listed(names)}")
    speakers = (*callers, *_said_by_files(files))
    light, how = _light(files, speakers, reading)
    paths, options = files.paths, {"sky": light.options["sky"], **how, **light.options}
    if files.backgrounds:
        options["backgrounds"] = _background_options(files.toml.background, files.folder)
    if moment is not None:
        options["weather"] = moment.source
        paths = paths if moment.path is None else {**paths, "weather": moment.path}
    n_photons, wavebands = _photons(files, light, compat), reading.wavebands
    bias: Mapping[str, float] = files.toml.photons.get("bias", {})
    unused = _unused_bias(files, bias, [component.name for component in light.components])
    scene = Scene(
        wavebands=bands,
        n_photons=only_bands(n_photons, wavebands, bands.wavelength_nm),
        components=light.components,
        row_of_band=light.row_of_band,
        sky_wavelength_nm=light.sky_wavelength_nm,
        irradiance=light.irradiance,
        preset=SamplingOptions() if not compat else AOMC_INTERNAL_PRESET if files.table is None else AOMC_TABLE_PRESET,
        footprint=_footprint(files.config),
        preset_name=COMPAT_NAME if compat else None,
        notes=(*light.notes, *_notes_of_other_skies(files), *_empty_band_notes(n_photons), *unused.values()),
        input_files=paths,
        options={**options, "compat": compat, "lenient": reading.lenient, "wavebands": listed_bands(wavebands)},
        bias={name: share for name, share in bias.items() if name not in unused},
    )
    if compat is None:
        scene.refuse_dark_bands()
    return scene


def _unused_bias(files: SceneFiles, bias: Mapping[str, float], names: list[str]) -> dict[str, str]:
    """Notes on shares of sky.toml for a beam that the scene has not; a name that no scene has is an error there."""
    others = [name for name in bias if name not in names and name != BEAM]
    if others:
        message = f"there is no component {' and '.join(map(repr, others))}"
        advice = f"the components are {', '.join(names)}"
        path = os.path.join(files.folder, SKY_TOML)
        raise InputFileError([problem_of_key(path, ("photons", "bias"), "E704", message, advice)])
    no_beam = f"sky.toml: the bias of {BEAM} is not used: the scene has no beam"
    return dict.fromkeys((name for name in bias if name not in names), no_beam)


def _said_by_files(files: SceneFiles) -> Speakers:
    """What sky.toml says, a field that it names, and the files of AOMC."""
    of_field = () if files.sky_field is None else (Said(sun=files.sky_field.sun, is_file=True),)
    return said_by_toml(files.toml), *of_field, Said(sun=sun_of(files.config), shares=files.difcol, is_file=True)


def _light(files: SceneFiles, speakers: Speakers, reading: Reading) -> tuple[Light, dict[str, Any]]:
    """The light of a scene, and how its sky was read."""
    about = Files(
        light_source=files.config.light_source,
        difcol_path=str(Path(files.paths["amc"]).parent / "difcol.inp"),
        toml_path=files.paths.get("sky_toml", ""),
        backgrounds=files.backgrounds,
    )
    given = reading.names if reading.compat is None else ()
    if files.sky == "none":
        alone = "the backgrounds of sky.toml"
        refuse_names((*names_said(speakers), *given), set(), light=alone, sky=alone, hint={})
        return in_absolute_units(_no_light(files), files.bands, about), {}
    if files.atmosphere is not None:
        from aomc_sky.source.read.atmosphere import atmosphere_light

        light = atmosphere_light(speakers, given, bands=files.bands, atmosphere=files.atmosphere)
        return in_absolute_units(light, files.bands, about), {"weighting": "projected"}
    sky, how = _sky_of(files, speakers, reading)
    if isinstance(sky, Model) and files.sky == GIVEN:
        speakers = with_sun_of(sky, speakers)
    nm = files.bands.wavelength_nm
    wanted = only_bands(np.ones(nm.size, np.int64), reading.wavebands, nm) > 0
    return light_of(speakers, sky, files.bands, wanted, files=about, given=given), how


def _sky_of(files: SceneFiles, speakers: Speakers, reading: Reading) -> tuple[Sky, dict[str, Any]]:
    """The sky of a scene, and how its file was read."""
    compat, weighting = reading.compat, reading.weighting
    if files.table is not None:
        from aomc_sky.source.read.table import table_of

        weighting = weighting or files.toml.sky.weighting  # type: ignore[assignment]  # read by its rule
        how = {"bins": reading.bins, "weighting": weighting, "azimuth_bins": reading.azimuth_bins}
        table = table_of(files.table, compat=compat, **how)
        return table, dict(table.reading)
    per_solid_angle = bool(compat) or weighting == "solid-angle"
    options = {"weighting": "solid-angle" if per_solid_angle else "projected"}
    sky: Sky
    if compat or files.sky == "uniform":
        sky = Uniform(per_solid_angle=per_solid_angle)
    elif files.sky_field is not None:
        sky = files.sky_field.as_sky(files.folder, per_solid_angle=per_solid_angle)
    elif files.plugin is not None:
        sky = Named(plugin=files.plugin)
    elif files.sky == GIVEN:
        sky = model_of(reading.sky, has_pattern=any(one.polarisation is not None for one in speakers))
    else:
        sky = perez_of(speakers)
    if "weighting" in sky.names and weighting not in (None, "projected", "solid-angle", *(["aomc"] * bool(compat))):
        raise UsageError(f"weighting {weighting!r} is for sky files; {sky.made_of} has 'projected' or 'solid-angle'")
    return sky, options


def _no_light(files: SceneFiles) -> Light:
    """Neither sun nor sky."""
    if not files.backgrounds:
        raise UsageError("sky 'none' leaves no light: sky.toml beside amc.inp has no [[background]]")
    toml = files.toml
    said = {"[perez]": not toml.perez.is_empty, "[sun]": not toml.sun.is_empty, "[clear_sky]": bool(toml.clear_sky)}
    idle = [name for name, is_said in said.items() if is_said] + ["polarisation"] * (toml.sky.polarisation is not None)
    notes = ["neither sun nor daylight is modelled: the backgrounds are the only source"]
    if idle:
        are = "is" if len(idle) == 1 else "are"
        notes.append(f"{SKY_TOML}: {' and '.join(idle)} {are} not used: the light is that of the backgrounds")
    return Light(row_of_band=np.zeros(files.bands.n_bands, np.int64), notes=tuple(notes), options={"sky": "none"})


def _notes_of_other_skies(files: SceneFiles) -> tuple[str, ...]:
    """Notes on skies of sky.toml in whose place another one is asked for."""
    toml = files.toml
    other = {
        f"{' and '.join(option.name for option in toml.sky.options)} of [sky]": toml.sky.options
        and toml.sky.model != files.sky,
        "table": toml.sky.table is not None and files.sky_field is None,
        "[atmosphere]": toml.atmosphere is not None and files.atmosphere is None,
        "weighting of [sky]": toml.sky.weighting is not None and files.table is None,
    }
    return tuple(
        f"{SKY_TOML}: {what} is not used: another sky is asked for" for what, is_idle in other.items() if is_idle
    )


def _photons(files: SceneFiles, light: Light, compat: str | None) -> np.ndarray:
    """Photons of each band: the iterations times the intensity of difcol.inp, as the program rounds under `compat`."""
    intensity, iterations = light.intensity, files.config.iterations
    if intensity is None:
        return np.full(files.bands.n_bands, iterations, dtype=np.int64)
    if compat:  # NINT of a product of 32-bit floats
        with np.errstate(over="ignore"):  # is infinite, which is refused below
            product = intensity.astype(np.float32) * np.float32(iterations)
        exact = np.floor(product.astype(np.float64) + 0.5).tolist()
    else:  # round half up, exact in the decimals of the file
        exact = [math.floor(Fraction(repr(float(x))) * iterations + Fraction(1, 2)) for x in intensity]
    if max(exact) > MAX_PHOTONS:
        found = f"{max(intensity):g} x {iterations}"
        raise SceneError(f"intensity x iterations must not exceed 2^62 photons in a band, got {found}")
    if not any(exact) and not compat:
        reason = "intensity x iterations is below 1/2 in every waveband"
        raise SceneError(f"difcol.inp gives no photons: {reason}", "write larger intensities, or more iterations")
    return np.array(exact, dtype=np.int64)


def _background_options(sections: Sequence[BackgroundSection], folder: str) -> list[dict[str, Any]]:
    """Keys of [[background]] as JSON values for a manifest; paths do not depend on the folder of the scene."""
    return [
        {
            **dataclasses.asdict(one),
            "file": os.path.relpath(one.file, folder or os.curdir),
            "time": moment_text(one.time),
            "animation": None if one.animation is None else list(one.animation),
        }
        for one in sections
    ]


def _empty_band_notes(n_photons: np.ndarray) -> tuple[str, ...]:
    empty = (np.flatnonzero(n_photons == 0) + 1).tolist()
    if not empty:
        return ()
    shown = f"{'s' * (len(empty) > 1)} {', '.join(map(str, empty[:10]))}{', ...' * (len(empty) > 10)}"
    return (f"difcol.inp: no photons in waveband{shown}, where intensity x iterations is below 1/2",)


def _footprint(config: AmcConfig) -> Footprint:
    if config.footprint is FootprintCode.CIRCLE:
        return Footprint.circle(config.circle_diameter_m)
    if config.footprint is FootprintCode.RECTANGLE:
        return Footprint.rectangle(config.rectangle_x_m, config.rectangle_y_m)
    return Footprint()
