"""The whole light of a place and an hour: the sun's beam and a sky in their shares, without files of AMC."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError, floats, number, require_one_of, shown_value
from aomc_sky.grid import PatchGrid
from aomc_sky.options import PEREZ, say
from aomc_sky.source.light.join import light_of
from aomc_sky.source.light.said import Speakers, moment_said, said_by_caller
from aomc_sky.source.light.skies import Model, Sky, model_of, named_sky, perez_of, require_sky_name, with_sun_of
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands, as_wavebands

if TYPE_CHECKING:
    import datetime

    from aomc_sky.skies.perez.coefficients import AirMassWord, LimitsWord
    from aomc_sky.skies.perez.sky import WithinWord
    from aomc_sky.skies.polarisation import RayleighPattern

SpectrumWord = Literal["flat", "spectrl2"]


def weather_scene(
    *,
    wavebands: Wavebands | Sequence[float] | np.ndarray,
    n_photons: ArrayLike = 1_000_000,
    time: str | datetime.datetime | np.datetime64 | None = None,
    latitude_deg: float | None = None,
    longitude_deg: float | None = None,
    altitude_m: float = 0.0,
    weather: str | Path | None = None,
    epw: str | Path | None = None,
    tmy2: str | Path | None = None,
    tmy3: str | Path | None = None,
    row: int | None = None,
    sun_zenith_deg: float | None = None,
    sun_azimuth_deg: float | None = None,
    ghi: float | None = None,
    dni: float | None = None,
    dhi: float | None = None,
    epsilon: float | None = None,
    delta: float | None = None,
    coefficients: Sequence[float] | None = None,
    spectrum: SpectrumWord | None = None,
    sun_disc: bool = False,
    diffuse_only: bool = False,
    within: WithinWord | None = None,
    limits: LimitsWord | None = None,
    air_mass: AirMassWord | None = None,
    extraterrestrial_normal: float | None = None,
    grid: PatchGrid | None = None,
    sky: Any = None,
    sky_options: Mapping[str, Any] | None = None,
    clear_sky: Any = None,
    polarisation: RayleighPattern | None = None,
) -> Scene:
    """Make the scene of sun and sky at an hour, from what a weather station measures.

    The sun is that of a time and a place, of an hour of a weather file, or of two angles. The sky is the all-weather
    model of Perez, Seals and Michalsky (1993). Beam and sky share the photons of a waveband as they share the light on
    a horizontal plane: dni cos Z : dhi, Z being the zenith angle of the sun.

    Parameters
    ----------
    wavebands : Wavebands, or array_like of float64, shape (n_band,)
        The wavebands, or their wavelengths. [nm]
    n_photons : array_like, int, shape (n_band,) or one for all
        Photons of each waveband. [0 to 2^62]
    time : str, datetime or datetime64, optional
        ISO 8601 with its zone, for example ``2026-06-21T09:30Z``; datetime64 is UTC. Needs the extra ``weather``.
    latitude_deg, longitude_deg : float, optional
        The place, with `time`: north and east positive. [deg, -90 to 90 and -180 to 180]
    altitude_m : float, optional
        Height of the place above the sea. The pressure of a cloudless sky follows from it, unless `clear_sky` gives
        one. [m, -500 to 9000]
    weather : str or Path, optional
        A weather file, EPW, TMY2 or TMY3, which gives place, sun and irradiances of the hour `row`.
    epw, tmy2, tmy3 : str or Path, optional
        The same of one kind; they go with version 0.6.
    row : int, optional
        The hour of the file. [from 1]
    sun_zenith_deg, sun_azimuth_deg : float, optional
        The sun, without time and file; the azimuth from +x (east) towards +y (north). [deg, 0 to below 90 and -360 to
        360]
    ghi, dni, dhi : float, optional
        Global horizontal, direct normal and diffuse horizontal irradiance, any two of them. [W m-2]
    epsilon, delta : float, optional
        Clearness and brightness of the sky in their place. [1 or more; 0 or more]
    coefficients : sequence of 5 float, optional
        Those of the sky's law in their place. They do not say how bright the beam is: the sky is launched alone.
    spectrum : str, optional
        "flat": every waveband has the broadband shares. "spectrl2": shares and irradiances of each waveband by
        cloudless spectra (Bird and Riordan 1986, by pvlib) that are scaled to dni and dhi. Without irradiances the
        light is that of a cloudless sky, `clear_sky`. The default is "flat". Beside a sky in W m-2 nm-1 it is
        "spectrl2": the beam is dni times its spectrum, and the sky keeps its light.
    sun_disc : bool
        The beam comes from the solar disc, 0.2665 degrees in radius, and not from one direction.
    diffuse_only : bool
        Launch the sky without the beam.
    within, limits, air_mass : optional
        As in `PerezSky`.
    extraterrestrial_normal : float, optional
        Irradiance outside the atmosphere at the mean distance of the sun; with a time or a weather file it is
        multiplied by the factor of the distance on that day. [W m-2, by default 1361.1]
    grid : PatchGrid, optional
        Patches of the Perez sky; by default 45 x 180.
    sky : str, sky model or function, optional
        A sky in the place of the Perez sky: a name such as "harrison-coombes", which gets the sun's angles, a model, or
        a function of zenith angle, azimuth and wavelength. A model with a sun says where the sun is. A relative sky has
        the amount of the inputs above. Without them it is the sky alone, and an `InputWarning` says so, unless
        `diffuse_only` says that it is meant.
    sky_options : mapping, optional
        Options of a named sky, such as ``{"type": 12}`` of "cie".
    clear_sky : ClearSky or mapping, optional
        The air of a cloudless sky.
    polarisation : RayleighPattern, optional
        Linear polarisation of the sky's light around the sun, for every sky that has one; a model with a sun of its own
        gets it itself. Without it photons carry none.

    Returns
    -------
    Scene
        Components "direct" and "perez", or those of `sky`; `scene.irradiance` in W m-2 nm-1 with
        ``spectrum="spectrl2"`` or a sky in these units, else None.

    Raises
    ------
    UsageError
        Inputs that contradict each other, do not suffice or are not used.
    SceneError
        The sun below the horizon, irradiances that no sky has, a beam brighter than the sun, or no light at all.

    Examples
    --------
    >>> scene = sky.weather_scene(
    ...     wavebands=[443.0, 555.0], sun_zenith_deg=40.0, ghi=780.0, dhi=140.0
    ... )
    >>> [component.name for component in scene.components]
    ['direct', 'perez']
    >>> [round(float(component.strength[0]), 4) for component in scene.components]
    [0.8205, 0.1795]
    """
    if spectrum is not None:
        require_one_of(PEREZ["spectrum"].words, spectrum, "spectrum")
    perez: dict[str, Any] = {"ghi": ghi, "dni": dni, "dhi": dhi, "epsilon": epsilon, "delta": delta}
    perez |= {
        "spectrum": spectrum,
        "limits": limits,
        "air_mass": air_mass,
        "extraterrestrial_normal": extraterrestrial_normal,
    }
    if coefficients is not None:
        values = floats("coefficients", coefficients)
        if values.shape != (5,):
            raise UsageError(f"coefficients are five numbers a, b, c, d, e, got {values.size}")
        perez |= dict(zip("abcde", values.tolist(), strict=True))
    speakers = said_by_caller(
        perez=perez,
        sun={
            "zenith_deg": sun_zenith_deg, "azimuth_deg": sun_azimuth_deg,
            "disc": None if sun_disc is False else sun_disc,
        },
        within=within,
        weather={
            "time": time, "latitude_deg": latitude_deg, "longitude_deg": longitude_deg,
            "altitude_m": None if altitude_m is None else number("altitude_m", altitude_m) or None,
            "weather": weather, "epw": epw, "tmy2": tmy2, "tmy3": tmy3, "row": row,
        },
        clear_sky=clear_sky,
        diffuse_only=diffuse_only,
        polarisation=polarisation,
    )  # fmt: skip
    return scene_of_weather(speakers, wavebands, n_photons, sky=sky, sky_options=sky_options, grid=grid)


def scene_of_weather(
    speakers: Speakers,
    wavebands: Wavebands | Sequence[float] | np.ndarray,
    n_photons: ArrayLike,
    *,
    sky: Any = None,
    sky_options: Mapping[str, Any] | None = None,
    grid: PatchGrid | None = None,
) -> Scene:
    """The scene of what a caller says about the light, without files of AMC."""
    found = sky_of(sky, sky_options or {}, speakers, grid)
    if isinstance(found, Model):
        speakers = with_sun_of(found, speakers)
    return scene_of_sky(found, speakers, as_wavebands(wavebands), n_photons)


def sky_of(sky: Any, options: Mapping[str, Any], speakers: Speakers, grid: PatchGrid | None = None) -> Sky:
    """The sky that a caller names or gives; by default that of Perez."""
    if not isinstance(options, Mapping):
        raise UsageError(f"sky_options are a mapping such as {{'type': 12}}, got {shown_value(options)}")
    named = " ".join(options)
    if sky is None or (isinstance(sky, str) and sky == "perez"):
        if options:
            raise UsageError(
                say(f"{{sky_options}} {named} is for a sky of another name, such as {{sky:cie}}; the Perez sky has ")
                + "options of its own"
            )
        return perez_of(speakers, grid)
    if grid is not None:
        raise UsageError("grid is that of the Perez sky; another sky has its own")
    if not isinstance(sky, str):
        if options:
            raise UsageError(say(f"{{sky_options}} {named} is for a sky by its name; give a model its own"))
        return model_of(sky, has_pattern=any(one.polarisation is not None for one in speakers))
    require_sky_name(sky)
    found = named_sky(sky, options)
    if found is None:
        raise UsageError(say(f"{{sky:{sky}}} needs a scene of files: name its amc.inp"))
    return found


def scene_of_sky(
    sky: Sky,
    speakers: Speakers,
    bands: Wavebands,
    n_photons: ArrayLike,
    *,
    input_files: Mapping[str, str] | None = None,
    options: Mapping[str, Any] | None = None,
) -> Scene:
    """The scene of a sky and of the sun's beam."""
    photons = np.broadcast_to(np.asarray(n_photons), (bands.n_bands,)).copy()
    light, moment = light_of(speakers, sky, bands, photons != 0), moment_said(speakers)
    files = dict(input_files or {})
    if moment is not None and moment.path is not None:
        files["weather"] = moment.path
    return Scene(
        wavebands=bands,
        n_photons=photons,
        components=light.components,
        row_of_band=light.row_of_band,
        sky_wavelength_nm=light.sky_wavelength_nm,
        irradiance=light.irradiance,
        notes=light.notes,
        input_files=files,
        options={
            **light.options,
            **{name: value for name, value in (options or {}).items() if light.options.get(name) is None},
            "weather": None if moment is None else moment.source,
        },
    )
