"""The whole light of a place and an hour: the sun's beam and a sky in their shares, without files of AMC."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import scaled
from aomc_sky.directions import given_angle
from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.errors import InputWarning, ModelLimitWarning, SceneError, UsageError, require_one_of
from aomc_sky.formats.sky_models import installed_skies
from aomc_sky.formats.sky_toml.keys import SPECTRL2, PerezSection, SkySection
from aomc_sky.grid import PatchGrid
from aomc_sky.inputs import MODEL, PEREZ
from aomc_sky.skies.function_sky import as_sky_model
from aomc_sky.skies.model import sky_model
from aomc_sky.skies.perez.irradiances import EXTRATERRESTRIAL_NORMAL
from aomc_sky.source.light.inputs import (
    GivenInputs,
    PerezInputs,
    Sun,
    choose_perez,
    direct_fraction,
    given_inputs,
    model_inputs,
    refuse_kilowatts,
)
from aomc_sky.source.light.plugin import choose_plugin, diffuse_of_plugin
from aomc_sky.source.light.shares import Diffuse, beam_of, diffuse_of
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands, as_wavebands

if TYPE_CHECKING:
    import datetime

    from aomc_sky.skies.perez.sky import PerezSky


def weather_scene(
    *,
    wavebands: Wavebands | Sequence[float] | np.ndarray,
    n_photons: ArrayLike = 1_000_000,
    time: str | datetime.datetime | np.datetime64 | None = None,
    latitude_deg: float | None = None,
    longitude_deg: float | None = None,
    altitude_m: float = 0.0,
    epw: str | Path | None = None,
    tmy2: str | Path | None = None,
    tmy3: str | Path | None = None,
    row: int | None = None,
    sun_zenith_deg: float | None = None,
    sun_azimuth_deg: float | None = None,
    sun_zenith_rad: float | None = None,
    sun_azimuth_rad: float | None = None,
    ghi: float | None = None,
    dni: float | None = None,
    dhi: float | None = None,
    epsilon: float | None = None,
    delta: float | None = None,
    coefficients: Sequence[float] | None = None,
    spectrum: str = "flat",
    sun_disc: bool = False,
    diffuse_only: bool = False,
    within: str | None = None,
    limits: str | None = None,
    air_mass: str | None = None,
    extraterrestrial_normal: float | None = None,
    grid: PatchGrid | None = None,
    sky: Any = None,
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
        Its height above the sea. [m, -500 to 9000]
    epw, tmy2, tmy3 : str or Path, optional
        A weather file, which gives place, sun and irradiances of the hour `row`.
    row : int, optional
        The hour of the file. [from 1]
    sun_zenith_deg, sun_azimuth_deg, or sun_zenith_rad, sun_azimuth_rad : float, optional
        The sun, without time and file; the azimuth from +x (east) towards +y (north). [0 to below 90 degrees, -360 to
        360]
    ghi, dni, dhi : float, optional
        Global horizontal, direct normal and diffuse horizontal irradiance, any two of them. [W m-2]
    epsilon, delta : float, optional
        Clearness and brightness of the sky in their place. [1 or more; 0 or more]
    coefficients : sequence of 5 float, optional
        Those of the sky's law in their place. They do not say how bright the beam is: the sky is launched alone.
    spectrum : str
        "flat": every waveband has the broadband shares. "spectrl2": shares and irradiances of each waveband by
        cloudless spectra (Bird and Riordan 1986, by pvlib) that are scaled to dni and dhi.
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
        a function of zenith angle, azimuth and wavelength. Its amount is that of the inputs above. Without them it is
        the sky alone, and an `InputWarning` says so, unless `diffuse_only` says that it is meant.

    Returns
    -------
    Scene
        Components "direct" and "perez", or those of `sky`; `scene.irradiance` in W m-2 nm-1 with
        ``spectrum="spectrl2"``, else None.

    Raises
    ------
    UsageError
        Inputs that contradict each other or do not suffice.
    SceneError
        The sun below the horizon, irradiances that no sky has, or no light at all.

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
    angles: dict[str, Any] = {"zenith_deg": sun_zenith_deg, "azimuth_deg": sun_azimuth_deg, "disc": sun_disc}
    for name, twin in (("zenith_deg", sun_zenith_rad), ("azimuth_deg", sun_azimuth_rad)):
        if twin is not None:
            angles[name] = given_angle(f"sun_{name}", angles[name], twin)
    require_one_of(PEREZ["spectrum"].words, spectrum, "spectrum")
    perez = {"ghi": ghi, "dni": dni, "dhi": dhi, "epsilon": epsilon, "delta": delta, "limits": limits}
    perez |= {"air_mass": air_mass, "extraterrestrial_normal": extraterrestrial_normal}
    if coefficients is not None:
        if len(coefficients) != 5:
            raise UsageError(f"coefficients are five numbers a, b, c, d, e, got {len(coefficients)}")
        perez |= dict(zip("abcde", map(float, coefficients), strict=True))
    weather = {
        "time": time, "latitude_deg": latitude_deg, "longitude_deg": longitude_deg, "altitude_m": altitude_m or None,
        "epw": epw, "tmy2": tmy2, "tmy3": tmy3, "row": row,
    }  # fmt: skip
    with_beam = False if diffuse_only else None
    try:
        given = given_inputs(perez, angles, within, weather=weather)
        if sky is None or sky == "perez":
            return scene_of_weather(given, wavebands, n_photons, spectrum=spectrum, with_beam=with_beam, grid=grid)
        if grid is not None:
            raise UsageError("grid is that of the Perez sky; another sky has its own")
        chosen = named_sky(sky, {}) if isinstance(sky, str) else given_sky(sky)
        return scene_of_sky(
            chosen, given, wavebands, n_photons, spectrum=spectrum, with_beam=with_beam, worded=_in_keywords
        )
    except UsageError as error:
        raise UsageError(_in_keywords(str(error))) from None


_OPTION = re.compile(r"--([a-z][a-z0-9-]*)")
_UNITS = {"sun_zenith": "_deg", "sun_azimuth": "_deg", "latitude": "_deg", "longitude": "_deg", "altitude": "_m"}


def _in_keywords(text: str) -> str:
    return _OPTION.sub(_keyword, text)


def _keyword(option: re.Match[str]) -> str:
    """The keyword of Python in place of an option of the command line: ``sun_zenith_deg=``."""
    name = option[1].replace("-", "_")
    return f"{name}{_UNITS.get(name, '')}="


def scene_of_weather(
    given: GivenInputs,
    wavebands: Wavebands | Sequence[float] | np.ndarray,
    n_photons: ArrayLike,
    *,
    spectrum: str = "flat",
    with_beam: bool | None = None,
    grid: PatchGrid | None = None,
) -> Scene:
    """The scene of checked inputs; `with_beam` None launches the beam where the inputs say how bright it is."""
    bands = as_wavebands(wavebands)
    inputs, sun = perez_and_sun(given)
    fractions, irradiance, notes, options = _shares(inputs, sun, bands, spectrum, with_beam)
    rows, row_of_band = np.unique(fractions, return_inverse=True)
    components = beam_of(sun, rows)
    shown: dict[str, Any] = {}
    if np.any(rows < 1):
        sky, limited = perez_sky(given.model, inputs, sun, grid)
        components += scaled(sky.lower(rows), 1.0 - rows)
        shown = {name: getattr(sky, name) for name in (*MODEL, "dni", "dhi")}
        shown |= {**sky_options(sky), "limited": limited}
    absolute = None
    if irradiance is not None:
        columns = {"direct": irradiance[0], "perez": irradiance[1]}
        absolute = Irradiance(of_component=np.stack([columns[component.name] for component in components], axis=1))
    weather = given.weather
    return Scene(
        wavebands=bands,
        n_photons=np.broadcast_to(np.asarray(n_photons), (bands.n_bands,)).copy(),
        components=tuple(components),
        row_of_band=row_of_band.ravel(),
        notes=notes,
        input_files={} if weather is None or weather.path is None else {"weather": weather.path},
        options={
            "sky": "perez",
            "sun": sun.as_options(),
            "perez": shown,
            "weather": None if weather is None else weather.source,
            **options,
        },
        irradiance=absolute,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class ChosenSky:
    """A sky in the place of the Perez sky."""

    name: str
    takes_sun: bool  #: Whether its law depends on the sun's angles.
    #: The sky under a sun, beside a beam of these fractions at these wavelengths.
    diffuse: Callable[[Sun, np.ndarray, np.ndarray], Diffuse]


def named_sky(name: str, options: Mapping[str, Any]) -> ChosenSky:
    """The sky of this name with its options; a UsageError for what needs files."""
    if name in installed_skies().plugins:
        plugin = choose_plugin(name, SkySection(), options, "")
        takes_sun = plugin.make.takes("sun_zenith_rad")
        return ChosenSky(name=name, takes_sun=takes_sun, diffuse=partial(diffuse_of_plugin, plugin))
    if name != "uniform":
        raise UsageError(f"--sky {name} needs a scene of files: name its amc.inp")
    if options:
        raise UsageError("the sky model 'uniform' has no options")
    return given_sky(sky_model(name)(), name)


def given_sky(given: Any, name: str | None = None) -> ChosenSky:
    """A model or a function as a sky."""
    model = as_sky_model(given)
    name = str(getattr(model, "name", type(model).__name__)) if name is None else name

    def diffuse(_: Sun, fractions: np.ndarray, wavelength_nm: np.ndarray) -> Diffuse:
        found = diffuse_of(tuple(model.lower(wavelength_nm)), f"sky {name!r}", fractions, wavelength_nm)
        notes = model.notes(wavelength_nm) if hasattr(model, "notes") else ()
        return replace(found, notes=tuple(notes))

    return ChosenSky(name=name, takes_sun=False, diffuse=diffuse)


_OF_PEREZ = {"limits": "--limits", "air_mass": "--air-mass", "within": "--within"}


def scene_of_sky(
    sky: ChosenSky,
    given: GivenInputs,
    wavebands: Wavebands | Sequence[float] | np.ndarray,
    n_photons: ArrayLike,
    *,
    spectrum: str | None = None,
    with_beam: bool | None = None,
    worded: Callable[[str], str] = str,
) -> Scene:
    """The scene of this sky and the sun's beam, or of the sky alone where nothing says how bright the beam is."""
    bands, weather = as_wavebands(wavebands), given.weather
    unused = [option for name, option in _OF_PEREZ.items() if name in given.model]
    unused += ["--coefficients"] * (given.perez.coefficients is not None)
    if unused:
        raise UsageError(f"{' and '.join(unused)}: of the Perez sky, not of --sky {sky.name}; leave this out")
    if given.perez.has_set:
        inputs, sun = perez_and_sun(given)
        fractions, irradiance, notes, options = _shares(inputs, sun, bands, spectrum or "flat", with_beam, sky.name)
    else:
        idle = ["--extraterrestrial"] * ("extraterrestrial_normal" in given.model)
        idle += ["--spectrum"] * (spectrum not in (None, "flat")) + ["--disc"] * bool(given.sun.disc)
        if idle:
            raise UsageError(f"{' and '.join(idle)}: used only where {_AMOUNTS} say how bright the beam is")
        sun, notes, options, irradiance = _sun_of_sky(sky, given), (), {}, None
        if sky.takes_sun and with_beam is None:
            text = f"nothing says how bright it is beside --sky {sky.name}; write {_AMOUNTS} or --diffuse-only"
            warnings.warn(
                worded(f"the direct beam of the sun is missing: {text} for the sky alone"), InputWarning, stacklevel=3
            )
        fractions = np.zeros(bands.n_bands)
    components = beam_of(sun, fractions)
    diffuse = sky.diffuse(sun, fractions, bands.wavelength_nm) if np.any(fractions < 1) else Diffuse()
    components += scaled(diffuse.components, 1.0 - fractions)
    absolute = None
    if irradiance is not None:
        columns = [irradiance[0]] * (len(components) - len(diffuse.components))
        columns += [irradiance[1] * component.strength for component in diffuse.components]
        absolute = Irradiance(of_component=np.stack(columns, axis=1))
    is_sun_used = sky.takes_sun or given.perez.has_set
    return Scene(
        wavebands=bands,
        n_photons=np.broadcast_to(np.asarray(n_photons), (bands.n_bands,)).copy(),
        components=tuple(components),
        notes=(*notes, *diffuse.notes),
        input_files={} if weather is None or weather.path is None else {"weather": weather.path},
        options={
            "sky": sky.name,
            "sun": sun.as_options() if is_sun_used else None,
            **diffuse.options,
            "weather": None if weather is None else weather.source,
            **options,
        },
        irradiance=absolute,
    )


_AMOUNTS = "two of --dni, --dhi and --ghi, or --epsilon and --delta,"


def _sun_of_sky(sky: ChosenSky, given: GivenInputs) -> Sun:
    """The sun of a sky whose amount is not known."""
    if given.weather is not None:
        given.weather.require_sun()
    zenith = given.sun.zenith_deg
    if not sky.takes_sun and not given.sun.is_empty:
        raise UsageError(
            f"--sky {sky.name} does not depend on the sun: leave the sun out, or write how bright the beam is, "
            f"{_AMOUNTS} so that both are launched"
        )
    if sky.takes_sun and zenith is None:
        raise UsageError(f"where is the sun? --sky {sky.name} needs --sun-zenith, and --sun-azimuth unless it is 0")
    if zenith is not None and zenith >= 90.0:
        raise UsageError(
            f"--sun-zenith: {zenith:g} is outside the range 0 to below 90; a sky needs the sun above the horizon"
        )
    return Sun(zenith_deg=zenith or 0.0, azimuth_deg=given.sun.azimuth_deg or 0.0, origin=given.origin)


def perez_and_sun(given: GivenInputs) -> tuple[PerezInputs, Sun]:
    """The set of Perez inputs and the sun that a caller gives; an error says which of them is missing."""
    weather = given.weather
    if weather is not None:
        weather.require_sun()
    origin = given.origin if weather is None or weather.path is not None else "options"
    inputs = choose_perez(PerezSection(), given.perez, origin)
    if given.sun.zenith_deg is None:
        raise UsageError("where is the sun? write --sun-zenith, or --time, --latitude and --longitude")
    if not 0 <= given.sun.zenith_deg < 90:
        raise SceneError(f"a sky needs the sun above the horizon, 0 to below 90 degrees, got {given.sun.zenith_deg:g}")
    if inputs is None:
        raise UsageError(
            "which sky? write two of --dni, --dhi and --ghi, --epsilon and --delta, or --coefficients a b c d e"
        )
    sun = Sun(
        zenith_deg=given.sun.zenith_deg,
        azimuth_deg=(given.sun.azimuth_deg or 0.0) % 360.0,
        disc=bool(given.sun.disc),
        origin=given.origin,
        extraterrestrial_normal=_extraterrestrial(given),
    )
    refuse_kilowatts(inputs, sun)
    return inputs, sun


def _extraterrestrial(given: GivenInputs) -> float:
    dated = EXTRATERRESTRIAL_NORMAL if given.weather is None else given.weather.extraterrestrial_normal
    return float(given.model.get("extraterrestrial_normal", dated))


_Shares = tuple[np.ndarray, "tuple[np.ndarray, np.ndarray] | None", tuple[str, ...], dict[str, Any]]


def _shares(
    inputs: PerezInputs, sun: Sun, bands: Wavebands, spectrum: str, with_beam: bool | None, sky: str = "perez"
) -> _Shares:
    """Direct fraction of each band, irradiances of beam and sky where a spectrum has them, notes and options."""
    broadband = direct_fraction(inputs, sun)
    if broadband is None:
        if with_beam:
            raise UsageError("coefficients do not say how bright the beam is; write two of --dni, --dhi, --ghi")
        note = "coefficients do not say how bright the beam is: the sky is launched alone"
        return np.zeros(bands.n_bands), None, (note,), {}
    if spectrum == SPECTRL2:
        from aomc_sky.source.light.spectral_split import spectral_split

        found = spectral_split(inputs, sun, bands.wavelength_nm)
        fractions, irradiance = found.direct_fraction, (found.direct_irradiance, found.diffuse_irradiance)
        how, options = str(found), {"spectrum": found.as_options()}
    else:
        fractions, irradiance = np.full(bands.n_bands, broadband), None
        how, options = "the broadband share in every waveband; blue light is more diffuse, red light less", {}
        if bands.n_bands == 1:
            how = "the broadband share"
    low, high = float(fractions.min()), float(fractions.max())
    shown = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    if with_beam is False:
        note = f"the direct beam of the sun, {shown} of the light, is left out ({inputs})"
        zero = np.zeros(bands.n_bands)
        return zero, None if irradiance is None else (zero, irradiance[1]), (note,), options
    return (
        fractions,
        irradiance,
        (f"direct fraction {shown}, the rest from {'an' if sky[0] in 'aeiou' else 'a'} {sky} sky ({inputs}: {how})",),
        options,
    )


def perez_sky(
    model: Mapping[str, Any], inputs: PerezInputs, sun: Sun, grid: PatchGrid | None = None
) -> tuple[PerezSky, list[str]]:
    """The sky of strength 1, and the warnings of its model about limits; each is given once more."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        sky = sky_model("perez")(
            sun_zenith_rad=math.radians(sun.zenith_deg),
            sun_azimuth_rad=math.radians(sun.azimuth_deg),
            grid=grid,
            strength=1.0,
            **{"extraterrestrial_normal": sun.extraterrestrial_normal, **model},
            **model_inputs(inputs, sun),
        )
    texts = list(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning)))
    for text in texts:
        warnings.warn(text, ModelLimitWarning, stacklevel=3)
    return sky, texts


def sky_options(sky: PerezSky) -> dict[str, Any]:
    """Clearness, brightness and coefficients of a Perez sky, for a manifest."""
    return {
        "epsilon": None if sky.clearness is None else float(sky.clearness),
        "delta": None if sky.brightness is None else float(sky.brightness),
        "coefficients": [float(c) for c in sky.model_coefficients],
    }
