"""amc.inp and the files beside it become a scene."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.aomc.amc import AmcConfig, FootprintCode
from aomc_sky.formats.sky_toml.keys import moment_text
from aomc_sky.formats.sky_toml.sections import BackgroundSection, PerezSection
from aomc_sky.inputs import Entrance
from aomc_sky.plan.allocation import MAX_PHOTONS, AllocationMethod
from aomc_sky.plan.options import Footprint, Order, Placement, SamplingOptions
from aomc_sky.source.light.diffuse import (
    FIELD,
    DiffuseSky,
    model_diffuse,
    perez_diffuse,
    plugin_diffuse,
    uniform_diffuse,
)
from aomc_sky.source.light.inputs import (
    LightInputs,
    Unsaid,
    Use,
    given_inputs,
    inputs_of_toml,
    refuse_unused,
    replaced_notes,
    unused_notes,
)
from aomc_sky.source.light.light import DIFCOL, Light, light_of
from aomc_sky.source.read.files import ATMOSPHERE, COMPAT_NAME, GIVEN, Reading, SceneFiles, read_scene_files, sun_of
from aomc_sky.source.scene import Scene, require_projected
from aomc_sky.wavebands import listed_bands, only_bands

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

AOMC_TABLE_PRESET = SamplingOptions(allocation=AllocationMethod.AOMC, placement=Placement.CENTRE, order=Order.PATCH)
AOMC_INTERNAL_PRESET = SamplingOptions(
    allocation=AllocationMethod.MULTINOMIAL, placement=Placement.PHILOX, order=Order.SHUFFLED
)

_Whole = Callable[[LightInputs], Light]


@in_default_mode
def read_scene(
    path: str | os.PathLike[str],
    *,
    iterations: int | None = None,
    sky: Any = None,
    bins: str | None = None,
    weighting: str | None = None,
    compat: str | None = None,
    lenient: bool = False,
    azimuth_bins: str = "n+1",
    wavebands: Sequence[int] | None = None,
    perez: Mapping[str, Any] | None = None,
    sun: Mapping[str, Any] | None = None,
    atmosphere: Mapping[str, Any] | None = None,
    weather: Mapping[str, Any] | None = None,
    within: str | None = None,
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
        and all light is diffuse unless irradiances ask for a beam (for the Perez sky they say its shape). "none":
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
        Inputs of the Perez sky, which win over sky.toml: one set of two of "dni", "dhi" and "ghi"
        [W m-2], "epsilon" and "delta", or "a" to "e"; "spectrum" ("flat" or "spectrl2"), by which beam and sky share
        each waveband where there is no difcol.inp, and without irradiances is that of a cloudless sky; and "limits",
        "air_mass" and "extraterrestrial_normal" as for `weather_scene`.
    sun : mapping, optional
        "zenith_deg" [0 to below 90; to 180 under an atmosphere], "azimuth_deg" [-360 to 360] and "disc", which win
        one by one over sky.toml and amc.inp.
    atmosphere : mapping, optional
        Keys of [atmosphere] for the Moon and the glow of the ground, which win over sky.toml: "moon_zenith_deg",
        "moon_distance_km", "ground_luminance_cd_m2" and so on.
    weather : mapping, optional
        When and where, or an hour of a weather file, instead of the angles of `sun`: "time" (ISO 8601 with its zone, or
        a datetime), "latitude_deg" and "longitude_deg" (north and east positive), "altitude_m"; or "epw", "tmy2" or
        "tmy3" (a path) and "row" (from 1), which says the irradiances too. Needs the extra `weather`.
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
    given = given_inputs(
        Entrance.MAPPINGS,
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
    return scene_of_files(path, given, reading)


def scene_of_files(path: str | os.PathLike[str], given: LightInputs, reading: Reading) -> Scene:
    """The scene of amc.inp and the files beside it, and of what a caller says about the light."""
    files, compat = read_scene_files(path, given, reading), reading.compat
    bands, (toml, amc) = files.bands, _inputs_of_files(files)
    inputs = given.over(toml).over(amc)
    sky, options = _sky_of(files, inputs, reading)
    use = _use_of(files, inputs, sky, compat)
    refuse_unused(given, use)
    light = light_of(
        inputs,
        sky,
        bands,
        unsaid=use.unsaid,
        path=str(Path(files.paths["amc"]).parent / DIFCOL),
        backgrounds=files.backgrounds,
        toml_path=files.paths.get("sky_toml", ""),
    )
    paths, options = files.paths, {"sky": light.options["sky"], **options, **light.options}
    if files.backgrounds:
        options["backgrounds"] = _background_options(files.toml.background, files.folder)
    if given.weather is not None:
        options["weather"] = given.weather.source
        paths = paths if given.weather.path is None else {**paths, "weather": given.weather.path}
    n_photons, wavebands = _photons(files, light, compat), reading.wavebands
    scene = Scene(
        wavebands=bands,
        n_photons=only_bands(n_photons, wavebands, bands.wavelength_nm),
        components=light.components,
        row_of_band=light.row_of_band,
        sky_wavelength_nm=light.sky_wavelength_nm,  # type: ignore[arg-type]
        irradiance=light.irradiance,
        preset=SamplingOptions() if not compat else AOMC_INTERNAL_PRESET if files.table is None else AOMC_TABLE_PRESET,
        footprint=_footprint(files.config),
        preset_name=COMPAT_NAME if compat else None,
        notes=(
            *replaced_notes(given, toml, amc, is_true=use.sky == ATMOSPHERE),
            *light.notes,
            *unused_notes(files.toml, use, named_sky=files.sky),
            *(_unused_reading(reading) if files.table is None else ()),
            *_empty_band_notes(n_photons),
        ),
        input_files=paths,
        options={**options, "compat": compat, "lenient": reading.lenient, "wavebands": listed_bands(wavebands)},
    )
    if compat is None:
        scene.refuse_dark_bands()
    return scene


def _use_of(files: SceneFiles, inputs: LightInputs, sky: DiffuseSky | _Whole, compat: str | None) -> Use:
    """What the scene is made of."""
    diffuse = sky if isinstance(sky, DiffuseSky) else None
    name = FIELD if files.sky_field is not None else str(files.sky) if diffuse is None else diffuse.name
    is_sunless = diffuse is not None and diffuse.is_sunless
    has_pattern = inputs.polarisation is not None and not is_sunless
    return Use(
        inputs=inputs,
        sky=name,
        words=str(sky),
        unsaid=Unsaid.ERROR if files.is_internal else Unsaid.WHOLE,
        is_compat=compat is not None,
        takes_sun=name == FIELD or has_pattern or diffuse is None or diffuse.takes_sun,
        is_sunless=is_sunless,
    )


def _inputs_of_files(files: SceneFiles) -> tuple[LightInputs, LightInputs]:
    """What sky.toml says, and amc.inp with difcol.inp; beside a sky file only what asks for a beam.

    The sun of a measured sky of sky.toml comes before that of amc.inp.
    """
    toml, sun = inputs_of_toml(files.toml), sun_of(files.config)
    if files.table is not None:
        toml = dataclasses.replace(toml, amounts=PerezSection())
    if files.sky_field is not None:
        sun = files.sky_field.sun.over(sun)
    return toml, LightInputs(sun=sun, shares=files.difcol)


def _sky_of(files: SceneFiles, inputs: LightInputs, reading: Reading) -> tuple[DiffuseSky | _Whole, dict[str, Any]]:
    """The sky of a scene, or a function for sun and sky together, and how the files were read."""
    compat, weighting = reading.compat, reading.weighting
    if files.table is not None:
        from aomc_sky.source.read.table import table_diffuse

        how = {"bins": reading.bins, "weighting": weighting, "azimuth_bins": reading.azimuth_bins}
        return table_diffuse(files.table, files.bands, compat=compat, **how)
    if files.sky == "none":
        if weighting is not None:
            raise UsageError(f"weighting {weighting!r} is of a sky, but this scene has none")
        return partial(_no_light, files), {}
    if files.atmosphere is not None:
        from aomc_sky.source.read.atmosphere import atmosphere_light

        require_projected(weighting, "the sky of an atmosphere")
        return partial(atmosphere_light, bands=files.bands, atmosphere=files.atmosphere), {"weighting": "projected"}
    if weighting not in (None, "projected", "solid-angle", *(["aomc"] * bool(compat))):
        raise UsageError(f"weighting {weighting!r} is for sky files; a sky model has 'projected' or 'solid-angle'")
    per_solid_angle = bool(compat) or weighting == "solid-angle"
    options = {"weighting": "solid-angle" if per_solid_angle else "projected"}
    if compat or files.sky == "uniform":
        return uniform_diffuse(per_solid_angle=per_solid_angle), options
    if files.sky_field is not None:
        return files.sky_field.diffuse(files.folder, per_solid_angle=per_solid_angle), options
    if files.plugin is not None:
        require_projected(weighting, f"the sky model {files.plugin}")
        return plugin_diffuse(files.plugin), options
    if files.sky == GIVEN:
        require_projected(weighting, "this sky")
        return model_diffuse(reading.sky, inputs), options
    require_projected(weighting, "the Perez sky")
    return perez_diffuse(inputs.perez_choices, replaces_file=not files.is_internal), options


def _no_light(files: SceneFiles, _: LightInputs) -> Light:
    """Neither sun nor sky."""
    if not files.backgrounds:
        raise UsageError("sky 'none' leaves no light: sky.toml beside amc.inp has no [[background]]")
    note = "neither sun nor daylight is modelled: the backgrounds are the only source"
    return Light(row_of_band=np.zeros(files.bands.n_bands, np.int64), notes=(note,), options={"sky": "none"})


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
        raise SceneError(f"difcol.inp gives no photons: {reason}; write larger intensities, or more iterations")
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


def _unused_reading(reading: Reading) -> tuple[str, ...]:
    options = (("--bins", reading.bins, None), ("--azimuth-bins", reading.azimuth_bins, "n+1"))
    return tuple(
        f"{name} {value} is not used: it says how to read skydist.inp, and this scene has none"
        for name, value, default in options
        if value != default
    )


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
