"""amc.inp and the files beside it become a scene."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.errors import SceneError, UsageError, require_one_of
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.aomc.amc import AmcConfig, FootprintCode
from aomc_sky.plan.footprint import Footprint
from aomc_sky.plan.sampling.allocation import MAX_PHOTONS
from aomc_sky.source.read.files import SceneFiles, read_scene_files
from aomc_sky.source.scene import Scene, SceneDraft
from aomc_sky.wavebands import Wavebands, absent_waveband
from aomc_sky.whole_number import as_index, as_number_of

if TYPE_CHECKING:
    from aomc_sky.formats.sky_toml.keys import SkySection
    from aomc_sky.source.light.inputs import GivenInputs
    from aomc_sky.source.read.atmosphere import SceneAtmosphere

COMPAT_NAME = "--compat aomc"


@in_default_mode
def read_scene(
    path: str | os.PathLike[str],
    *,
    iterations: int | None = None,
    sky: str | None = None,
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
    sky : {"perez", "uniform", "none"} or str, optional
        The diffuse sky of a scene with light-source flag 0, by default "perez"; with flag 1 it
        replaces the sky file, and all light is diffuse. "none": neither sun nor sky, the backgrounds of
        sky.toml are the only source. Any other name is that of a model of another package (entry point group
        ``aomc_sky.sky_models``).
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
        each waveband where there is no difcol.inp; and "limits", "air_mass" and "extraterrestrial_normal" as
        for `weather_scene`.
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
    sky_options : mapping, optional
        Options of another package's sky model, which win one by one over the keys of [sky].
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
    _check_choices(sky=sky, bins=bins, weighting=weighting, compat=compat, azimuth_bins=azimuth_bins)
    given = None
    if perez or sun or within is not None or atmosphere or weather:
        from aomc_sky.source.light.inputs import given_inputs

        given = given_inputs(perez, sun, within, atmosphere, weather)
    allowed = [os.fspath(one) for one in allow_paths]
    if sky_options:
        from aomc_sky.source.light.plugin import plain_option

        sky_options = {name: plain_option(name, value) for name, value in sky_options.items()}
    amc_path = Path(path) / "amc.inp" if Path(path).is_dir() else Path(path)
    azimuth = None if given is None else given.sun.azimuth_deg
    files = read_scene_files(amc_path, sky, lenient, compat, allowed, max_memory_bytes, sky_options, azimuth)
    if iterations is not None:
        n = as_number_of(iterations, "iterations", 1, MAX_PHOTONS, error=SceneError)
        files = dataclasses.replace(files, config=dataclasses.replace(files.config, iterations=n))
    bands = files.bands
    if given is not None:
        _refuse_unused(given, files, compat)
    if files.table is not None:
        from aomc_sky.source.read.table import table_draft

        how = {"bins": bins, "weighting": weighting, "azimuth_bins": azimuth_bins}
        draft, units = table_draft(files.config, bands, files.table, compat=compat, **how), None
    else:
        if weighting is not None and files.sky == "none":
            raise UsageError(f"weighting {weighting!r} is of a sky, but this scene has none")
        draft, units = _model_draft(files, bands, given, weighting, compat)
    draft = _in_absolute_units(draft, units, files, bands)
    paths = files.paths
    if given is not None and given.weather is not None:
        draft = dataclasses.replace(draft, options={**draft.options, "weather": given.weather.source})
        paths = paths if given.weather.path is None else {**paths, "weather": given.weather.path}
    draft = dataclasses.replace(
        draft,
        n_photons=only_bands(draft.n_photons, wavebands, bands.wavelength_nm),
        notes=(
            *draft.notes,
            *_unused_notes(files, draft.options),
            *(_unused_reading(bins, azimuth_bins) if files.table is None else ()),
            *_empty_band_notes(draft.n_photons),
        ),
        options={**draft.options, "compat": compat, "lenient": lenient, "wavebands": listed_bands(wavebands)},
    )
    scene = draft.scene(
        bands,
        footprint=_footprint(files.config),
        preset_name=COMPAT_NAME if compat else None,
        input_files=paths,
    )
    if compat is None:
        scene.refuse_dark_bands()
    return scene


def _model_draft(
    files: SceneFiles,
    bands: Wavebands,
    given: GivenInputs | None,
    weighting: str | None,
    compat: str | None,
) -> tuple[SceneDraft, SkySection | None]:
    """A scene without a sky file, and the irradiances of sun and sky where a spectrum tells them."""
    if files.sky == "none":
        if not files.backgrounds:
            raise UsageError("sky 'none' leaves no light: sky.toml beside amc.inp has no [[background]]")
        note = "neither sun nor daylight is modelled: the backgrounds are the only source"
        photons = np.full(bands.n_bands, files.config.iterations, dtype=np.int64)
        rows = np.zeros(bands.n_bands, dtype=np.int64)
        return SceneDraft(
            components=(), n_photons=photons, row_of_band=rows, notes=(note,), options={"sky": "none"}
        ), None
    from aomc_sky.source.light.inputs import GivenInputs, sky_inputs

    given = given or GivenInputs()
    if files.atmosphere is not None:
        return _under_atmosphere(files, files.atmosphere, bands, given, weighting), None
    from aomc_sky.source.read.sun_and_sky import band_split, sun_and_sky_draft

    inputs = sky_inputs(files.config, files.toml_or_empty, given)
    split = band_split(files, inputs, files.sky, bands.wavelength_nm)
    return sun_and_sky_draft(files, split, inputs, bands.wavelength_nm, weighting=weighting, compat=compat)


def _under_atmosphere(
    files: SceneFiles,
    atmosphere: SceneAtmosphere,
    bands: Wavebands,
    given: GivenInputs,
    weighting: str | None,
) -> SceneDraft:
    """A scene with [atmosphere]; the beam has the solar disc unless someone says that it has not."""
    from aomc_sky.source.light.inputs import resolve_sun
    from aomc_sky.source.read.atmosphere import atmosphere_draft, with_lights

    of_file = files.toml_or_empty.sun
    given_sun = given.sun
    if given.weather is not None:  # rays through the description's air are straight
        given_sun = dataclasses.replace(given_sun, zenith_deg=given.weather.true_zenith_deg)
    sun = resolve_sun(files.config, of_file, given_sun, given.origin)
    has_disc = of_file.disc if given.sun.disc is None else given.sun.disc
    return atmosphere_draft(
        files.config,
        bands,
        with_lights(atmosphere, given.lights),
        sun,
        difcol=files.difcol,
        weighting=weighting,
        has_disc=has_disc is not False,
    )


def _in_absolute_units(draft: SceneDraft, units: SkySection | None, files: SceneFiles, bands: Wavebands) -> SceneDraft:
    """The draft with what [sky] says of its irradiances and the lobes of [[background]]."""
    if files.toml is not None:
        units = units or files.toml.sky
    if units is None:
        return draft
    from aomc_sky.source.read.absolute_units import background_options, with_absolute_units

    draft = with_absolute_units(draft, units, files.backgrounds, bands, files.paths.get("sky_toml", ""))
    if not files.backgrounds:
        return draft
    shown = background_options(files.toml_or_empty.background, files.folder)
    return dataclasses.replace(draft, options={**draft.options, "backgrounds": shown})


def _check_choices(**choices: str | None) -> None:
    allowed = {
        "bins": ("equal", "degrees"),
        "weighting": ("listed", "projected", "solid-angle", "aomc"),
        "compat": ("aomc",),
        "azimuth_bins": ("n+1", "n"),
    }
    for name, value in choices.items():
        if value is not None and name in allowed:
            require_one_of(allowed[name], value, name)
    if choices["sky"] is not None:
        from aomc_sky.formats.sky_toml.keys import value_problem

        _, message, advice = value_problem("sky", "model", choices["sky"])
        if message:
            raise UsageError(f"sky: {message}; {advice}")
    if choices["compat"] is not None:
        contradicting = {"bins": ("degrees",), "weighting": ("aomc",), "sky": ("uniform",), "azimuth_bins": ("n+1",)}
        for name, kept in contradicting.items():
            if choices[name] is not None and choices[name] not in kept:
                raise UsageError(f"{COMPAT_NAME} means {name} {kept[0]!r}, which contradicts {choices[name]!r}")


def _refuse_unused(given: GivenInputs, files: SceneFiles, compat: str | None) -> None:
    """Refuse what a caller gives and this scene cannot use; what files say beyond need is only noted."""
    sky = files.sky
    if compat is not None and (given.names or given.model):
        raise UsageError(f"{COMPAT_NAME} does not use {' and '.join(given.names) or 'within'}")
    if given.lights and files.atmosphere is None:
        raise UsageError(f"{' and '.join(given.lights)}: used only with [atmosphere] in sky.toml")
    _refuse_spectrum(given, files)
    if files.table is not None and given.names:
        raise UsageError(
            f"{' and '.join(given.names)}: the light comes from skydist.inp; write --sky perez for a sky model"
        )
    if files.atmosphere is not None and (given.model or not given.perez.is_empty):
        raise UsageError(
            "inputs of the Perez sky are not used with [atmosphere] in sky.toml; write --sky perez to use them"
        )
    if sky == "none" and (given.names or given.model):
        raise UsageError(f'{" and ".join(given.names) or "within"}: not used without sun and sky (model "none")')
    is_uniform = sky == "uniform"
    if files.plugin is None and files.sky_field is None and not is_uniform:
        return
    of_field = "the field of sky.toml (table)" if files.sky_field is not None else f"the sky model {sky!r}"
    used = "a uniform sky" if is_uniform else of_field
    law = given.model_names if is_uniform else given.model
    if law or (files.difcol is not None and not given.perez.is_empty):
        advice = "leave --sky uniform out" if is_uniform else "leave them out"
        raise UsageError(f"{used} does not use inputs of the Perez sky; {advice}")
    if not files.is_internal and given.names and (is_uniform or not given.perez.is_empty):
        raise UsageError(f"{' and '.join(given.names)}: all light comes from {used}")


def _refuse_spectrum(given: GivenInputs, files: SceneFiles) -> None:
    """Refuse a spectrum where something else says how direct the light of each waveband is."""
    if given.perez.spectrum is None or files.table is not None or files.atmosphere is not None:
        return  # none, or refused with the other inputs
    if files.difcol is not None:
        raise UsageError("spectrum: difcol.inp gives the direct fraction of every waveband; leave one of them out")
    if not files.is_internal:
        raise UsageError("spectrum: all light is diffuse where a sky model replaces skydist.inp; leave it out")


def _unused_notes(files: SceneFiles, options: Mapping[str, Any]) -> tuple[str, ...]:
    toml, notes = files.toml, []
    if toml is None:
        return ()
    of_sun_and_sky = not toml.sun.is_empty or not toml.perez.is_empty
    if files.table is not None and of_sun_and_sky:
        what = "sky.toml:" if toml.sky.is_empty and not toml.background else "sky.toml: [perez] and [sun]"
        notes.append(f"{what} not used, all light comes from skydist.inp (--sky perez takes a sky model instead)")
    elif options.get("sky") == "none" and of_sun_and_sky:
        notes.append("sky.toml: [perez] and [sun] are not used, neither sun nor daylight is modelled")
    elif options.get("sky") != "perez" and files.difcol is not None and not toml.perez.is_empty:
        notes.append("sky.toml: [perez] is not used, no Perez sky is modelled")
    if toml.perez.spectrum is not None and files.difcol is not None:
        notes.append("sky.toml: spectrum is not used, difcol.inp gives the direct fraction of every waveband")
    if toml.sky.options and toml.sky.model != files.sky:
        unused = " and ".join(option.name for option in toml.sky.options)
        notes.append(f"sky.toml: {unused} of [sky] is not used, another sky than {toml.sky.model!r} is asked for")
    if toml.sky.table is not None and files.sky_field is None:
        notes.append("sky.toml: table is not used, another sky is asked for")
    if toml.atmosphere is not None and files.atmosphere is None:
        notes.append("sky.toml: [atmosphere] is not used, another sky is asked for")
    return tuple(notes)


def _unused_reading(bins: str | None, azimuth_bins: str) -> tuple[str, ...]:
    options = (("--bins", bins, None), ("--azimuth-bins", azimuth_bins, "n+1"))
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


def listed_bands(wavebands: Sequence[int] | None) -> list[int] | None:
    """The chosen bands, each once, in order."""
    return None if wavebands is None else sorted({as_index(b, "a waveband") for b in wavebands})


def only_bands(n_photons: np.ndarray, wavebands: Sequence[int] | None, wavelength_nm: np.ndarray) -> np.ndarray:
    """Photons of the chosen bands, from 1, and none of the others."""
    if wavebands is None:
        return n_photons
    chosen = listed_bands(wavebands)
    if not chosen:
        raise UsageError(f"no waveband is chosen; there are {n_photons.size}, from 1")
    for number in chosen:
        if not 1 <= number <= n_photons.size:
            raise absent_waveband(number, wavelength_nm)
    kept = np.zeros_like(n_photons)
    index = np.array(chosen) - 1
    kept[index] = n_photons[index]
    return kept
