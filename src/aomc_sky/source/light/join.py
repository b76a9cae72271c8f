"""`light_of`: where the sun is, how bright beam and sky are, and which sky, become components of a scene."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.component import Component, scaled
from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.errors import InputWarning, ModelLimitWarning, SceneError, UsageError
from aomc_sky.formats.aomc.amc import LightSource
from aomc_sky.formats.text_file import refuse
from aomc_sky.options import listed, say
from aomc_sky.skies.direct_beam import SOLAR_BOUND, SOLAR_RADIUS_DEG, DirectBeam, solar_irradiance
from aomc_sky.source.light.brightness import Brightness, InBands, Shares, brightness_of, direct_fraction
from aomc_sky.source.light.place import Sun, place_of
from aomc_sky.source.light.said import Speakers, callers_of, first, is_diffuse_only, sun_said
from aomc_sky.source.light.skies import Lowered, Perez, Sky
from aomc_sky.source.light.unused import OF_SKY, names_said, needs_sun, notes_of_files, refuse_unused
from aomc_sky.wavebands import Wavebands

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.sky import LobeSky

BEAM = "direct"
_MAX_SHOWN = 12
THREE_LINES = (
    "[perez]\ndni = 850.0    # direct normal irradiance, W m-2\ndhi = 95.0     # diffuse horizontal irradiance, W m-2"
)
_AMOUNTS = "two of {dni}, {dhi} and {ghi}, or {epsilon} and {delta}, or {spectrum:spectrl2} for a cloudless sky"


@dataclass(frozen=True, kw_only=True, slots=True)
class Light:
    """The light of a scene: components, and the row of them that serves each waveband."""

    components: tuple[Component, ...] = ()
    row_of_band: np.ndarray
    sky_wavelength_nm: np.ndarray | None = None
    intensity: np.ndarray | None = None  #: (n_band,) photons per iteration; None: 1
    notes: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    irradiance: Irradiance | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Files:
    """The files of a scene, as far as its light depends on them."""

    light_source: LightSource
    difcol_path: str  #: that an error names
    toml_path: str = ""
    backgrounds: Sequence[LobeSky] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class Split:
    """Where the sun is, and how bright beam and sky are, before the sky has components."""

    answer: Brightness
    sun: Sun | None
    light: InBands
    kept: InBands  #: the same without the beam, where that is left out
    has_photons: np.ndarray  #: (n_band,)
    is_lit: bool  #: whether a waveband has light of the sky
    notes: tuple[str, ...]


def split_of(
    speakers: Speakers, sky: Sky, bands: Wavebands, *, files: Files | None = None, given: Iterable[str] = ()
) -> Split:
    """How bright beam and sky are by what speakers say; arguments of `light_of`."""
    nm = bands.wavelength_nm
    is_alone = is_diffuse_only(speakers)
    warns = (files is not None or sky.is_whole) and not is_alone
    answer = brightness_of(speakers, sky.made_of, is_whole=sky.is_whole, warns=warns)
    refuse_unused(speakers, answer, sky, given)
    notes = [] if answer.has_beam else _without_a_beam(speakers, sky, files)
    sun = _sun_of(speakers, answer, sky)
    light = answer.in_bands(sun, nm, sky.irradiance(sun, nm))
    shares, has_photons = first([one.shares for one in speakers]), np.ones(nm.size, bool)
    if shares is not None:
        light = dataclasses.replace(light, intensity=shares.intensity)
        has_photons = shares.intensity > 0 if np.any(shares.intensity > 0) else has_photons
    light = dataclasses.replace(light, who=light.who or str(answer))
    _refuse_too_bright(light, sun, bands)
    kept = light.without_beam() if is_alone else light
    is_lit = _has_sky(light, kept, has_photons, names_said(speakers))
    return Split(
        answer=answer, sun=sun, light=light, kept=kept, has_photons=has_photons, is_lit=is_lit, notes=tuple(notes)
    )


def light_of(
    speakers: Speakers,
    sky: Sky,
    bands: Wavebands,
    wanted: np.ndarray,
    *,
    files: Files | None = None,
    given: Iterable[str] = (),
) -> Light:
    """The light that speakers and a sky make; `wanted` (n_band,) says which wavebands shall have photons.

    `given` are further inputs of the caller, `files` those of AOMC.
    """
    nm = bands.wavelength_nm
    split = split_of(speakers, sky, bands, files=files, given=given)
    answer, sun, light, kept, is_lit = split.answer, split.sun, split.light, split.kept, split.is_lit
    is_alone = is_diffuse_only(speakers)
    lowered = sky.lower(sun, nm, light) if is_lit else Lowered(components=(), row_of_band=np.zeros(nm.size, np.int64))
    fractions, sky_rows, of_band = _rows(kept.direct_fraction, lowered.row_of_band)
    components = [] if is_alone else _beam(sun, fractions)
    components += _diffuse(lowered.components, sky_rows, fractions, nm[_first_of(of_band)], sky.made_of)
    notes = [*_split_notes(light, answer, sky, sun, is_lit=is_lit, is_alone=is_alone), *split.notes, *light.notes]
    if is_lit and not (fractions.any() or is_alone):
        notes += [lowered.missing_beam] * bool(lowered.missing_beam)
    notes += lowered.notes
    if is_lit and sun is not None:
        notes += sun.notes
    found = Light(
        components=tuple(components),
        row_of_band=of_band,
        sky_wavelength_nm=lowered.table_wavelength_nm,
        intensity=light.intensity,
        notes=(*notes, *notes_of_files(speakers, answer, sky, is_lit=is_lit)),
        options={
            "sky": sky.name if is_lit else None,
            "sun": None if sun is None else sun.as_options(),
            **lowered.options,
            **light.options,
        },
    )
    return in_absolute_units(found, bands, files, kept, wanted & split.has_photons)


def _sun_of(speakers: Speakers, answer: Brightness, sky: Sky) -> Sun | None:
    """The sun where it is needed, or where someone says it; with a pattern only where the sky has a sun."""
    if not needs_sun(speakers, answer, sky) and (sky.is_whole or sun_said(speakers).zenith_deg is None):
        return None
    what = sky.made_of if sky.needs_sun else "the beam" if answer.has_beam else f"the polarisation of {sky.made_of}"
    sun = place_of(speakers, what)
    return sun if sky.has_sun else dataclasses.replace(sun, polarisation=None)


def _without_a_beam(speakers: Speakers, sky: Sky, files: Files | None) -> list[str]:
    """What it means that nobody says how bright the beam is: an error, a warning, or a note."""
    is_alone = is_diffuse_only(speakers)
    shape = sky.shape if isinstance(sky, Perez) else None
    if files is not None and files.light_source is LightSource.MODEL and not is_alone:
        reason, place = "nothing else says", "an [atmosphere]"
        if shape is not None:
            reason, place = f"{shape.text} do not say", "coefficients a to e"
        raise refuse(
            files.difcol_path,
            f"there is no such file, and {reason} how much of the light is direct",
            advice=f"write difcol.inp, or {say(_AMOUNTS)}, or these lines into sky.toml beside amc.inp, in place of "
            f"{place}:\n\n{THREE_LINES}\n",
        )
    if isinstance(sky, Perez) and shape is None:
        if files is None:
            raise UsageError(say(f"which sky? write {_AMOUNTS}, or {{coefficients:a b c d e}}"))
        text = "{sky:perez} instead of skydist.inp needs dni and dhi (or epsilon and delta, or a to e)"
        raise UsageError(f"{say(text)}: give them, or write into sky.toml beside amc.inp\n\n{THREE_LINES}\n")
    if sky.is_whole:
        return [
            f"{say('{diffuse_only:True}')} leaves nothing out: no beam is asked for beside {sky.made_of}"
        ] * is_alone
    if shape is not None and not is_alone:
        return ["coefficients do not say how bright the beam is: the sky is launched alone"]
    if not is_alone and sun_said(callers_of(speakers)).zenith_deg is not None:
        text = (
            f"nothing says how bright it is beside {sky.made_of}; write {_AMOUNTS}, or {{diffuse_only:True}} for the "
            "sky alone"
        )
        warnings.warn(f"the direct beam of the sun is missing: {say(text)}", InputWarning, stacklevel=5)
    if files is not None and files.light_source is LightSource.FILE:
        return [f"all light comes from {sky.made_of}, which replaces skydist.inp"]
    return []


_MOST_OF_DRY_AIR = 1.3
"""Times `SOLAR_BOUND`: so much a spectrum of moist air at the sea exceeds the sun where dni is of a dry mountain."""


def _refuse_too_bright(light: InBands, sun: Sun | None, bands: Wavebands) -> None:
    """Raise where the beam is brighter than the sun outside the atmosphere."""
    if light.direct is None or sun is None:
        return
    normal, most = light.direct / sun.cosine, SOLAR_BOUND * solar_irradiance(bands.wavelength_nm)
    excess = normal / most
    band = int(np.argmax(excess))
    if not excess[band] > 1:
        return
    nm = bands.wavelength_nm[band]
    text = (
        f"{light.who}: the beam of waveband {band + 1} at {nm:g} nm has {normal[band]:.3g} W m-2 nm-1 on a surface "
        f"that faces the sun, which has {solar_irradiance(nm):.3g} outside the atmosphere"
    )
    if "spectrum" not in light.options or excess[band] > _MOST_OF_DRY_AIR:
        raise SceneError(f"{text}", "check the irradiances and their unit")
    warnings.warn(f"{text}: the spectrum is that of air at the sea, and this air is clearer", ModelLimitWarning, 4)


def _has_sky(light: InBands, kept: InBands, has_photons: np.ndarray, names: Sequence[str]) -> bool:
    """Whether a waveband with photons has light of the sky."""
    if np.any(kept.direct_fraction[has_photons] < 1):
        return True
    if kept is not light:
        raise SceneError(
            f"all light is direct ({light.who}), and {say('{diffuse_only:True}')} leaves the beam out: no light is left"
        )
    if idle := [name for name in names if name in OF_SKY]:
        are = "is" if len(idle) == 1 else "are"
        raise UsageError(f"{listed(idle)} {are} not used: all light is direct ({light.who}), so there is no sky")
    return False


def _rows(fraction: np.ndarray, sky_row: np.ndarray | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The share of the beam and the sky's row of each row of the scene, and the row of each waveband.

    One row for each distinct pair, or one for each waveband where each has its own sky.
    """
    if sky_row is None:
        every = np.arange(fraction.size)
        return fraction, every, every
    pairs, of_band = np.unique(np.column_stack([fraction, sky_row]), axis=0, return_inverse=True)
    return pairs[:, 0], pairs[:, 1].astype(np.int64), of_band.ravel()


def _first_of(of_band: np.ndarray) -> np.ndarray:
    """The first waveband of each row."""
    return np.unique(of_band, return_index=True)[1]


def _beam(sun: Sun | None, fractions: np.ndarray) -> list[Component]:
    """The sun's beam with these strengths, if one of them is above 0."""
    if sun is None or not np.any(fractions > 0):
        return []
    radius = SOLAR_RADIUS_DEG if sun.disc else 0.0
    beam = DirectBeam(sun_zenith_deg=sun.zenith_deg, sun_azimuth_deg=sun.azimuth_deg, radius_deg=radius)
    return scaled(beam.lower(fractions), fractions)


def _diffuse(
    components: Sequence[Component], sky_rows: np.ndarray, fractions: np.ndarray, nm: np.ndarray, sky: str
) -> list[Component]:
    """The sky's components in the rows of the scene, with strengths that are shares of all light."""
    if not components:
        return []
    strength = np.stack([c.strength for c in components])[:, sky_rows]
    total = strength.sum(axis=0)
    dark = np.flatnonzero(~(total > 0) & (fractions > 0) & (fractions < 1))
    if dark.size:
        raise SceneError(
            f"{sky} is dark at {nm[dark[0]]:g} nm, but {1 - fractions[dark[0]]:g} of the light there is diffuse"
        )
    shares = np.divide(strength, total, out=np.zeros_like(strength), where=total > 0)
    return [
        dataclasses.replace(_of_rows(c, sky_rows), strength=share * (1.0 - fractions), irradiance_W_m2_nm=None)
        for c, share in zip(components, shares, strict=True)
    ]


def _of_rows(component: Component, rows: np.ndarray) -> Component:
    """The component with these rows of everything; a single row is for all."""
    arrays = {name: getattr(component, name) for name in ("mass", "weight", "slope", "stokes")}
    taken = {name: values[rows] for name, values in arrays.items() if values is not None and len(values) > 1}
    return dataclasses.replace(component, strength=component.strength[rows], **taken)


def _split_notes(
    light: InBands, answer: Brightness, sky: Sky, sun: Sun | None, *, is_lit: bool, is_alone: bool
) -> list[str]:
    """How the light of each waveband is divided, and who says it."""
    fractions = light.direct_fraction
    if not answer.has_beam:
        return []
    if not is_lit:
        return [f"{light.who}: all light is direct, so no sky is modelled"]
    if is_alone and fractions.any():
        return [f"the direct beam of the sun, {_spread(fractions)} of the light, is left out ({answer})"]
    hint = ""
    if isinstance(answer, Shares) and isinstance(sky, Perez) and sky.shape is not None and sky.shape.has_amounts:
        assert sun is not None, "a beam has a sun"
        hint = f" ({sky.shape.text} alone: {direct_fraction(sky.shape, sun):.3g})"
    return [f"{light.who}: the beam has {_spread(fractions)} of the light{hint}, {sky.made_of} the rest"]


def _spread(values: np.ndarray) -> str:
    low, high = (f"{float(extreme(values)):.4g}" for extreme in (np.min, np.max))
    return low if low == high else f"{low} to {high}"


# How bright sun and sky are, where that is known, and the lobes of backgrounds.


def in_absolute_units(
    light: Light,
    bands: Wavebands,
    files: Files | None,
    level: InBands | None = None,
    wanted: np.ndarray | None = None,
) -> Light:
    """State the irradiance of every component, and add the lobes of the backgrounds.

    A waveband that is `wanted` has light. Light in relative units stays as it is. With backgrounds the strengths are
    irradiances in the same unit, with a row for each distinct set of base row, wavelength and irradiances. E708:
    backgrounds beside relative light.
    """
    skies = () if files is None else files.backgrounds
    is_known = level is not None and (level.direct is not None or level.diffuse is not None)
    if light.irradiance is not None:
        base = light.irradiance.of_component
    elif skies or is_known:
        base = _base_irradiance(light, level, bands, "" if files is None else files.toml_path, bool(skies))
    else:
        return light
    if not skies:
        dark = np.flatnonzero((base.sum(axis=1) == 0) & (wanted if wanted is not None else False))
        if dark.size and is_known:
            raise SceneError(
                f"waveband {dark[0] + 1} at {bands.wavelength_nm[dark[0]]:g} nm has no light, 0 W m-2 nm-1",
                "write a positive value, or choose others by --waveband",
            )
        return dataclasses.replace(light, irradiance=Irradiance(of_component=base))
    return _with_backgrounds(light, base, skies, bands)


def _with_backgrounds(light: Light, base: np.ndarray, skies: Sequence[LobeSky], bands: Wavebands) -> Light:
    """Sun, sky and lobes with strengths in one unit."""
    from aomc_sky.skies.lobes.light import background_light

    components = light.components
    keys = np.column_stack([light.row_of_band, bands.wavelength_nm, base])
    _, first_band, rows = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    added = background_light(skies, bands.wavelength_nm[first_band], taken=[c.name for c in components])
    if not components and not added.components:
        reason = "all their lobes lie below the horizon" if added.hidden else "their lobes have no light at that time"
        raise SceneError(f"the backgrounds are the only source of light, but {reason}")
    old_rows = light.row_of_band[first_band]
    own = [
        dataclasses.replace(_of_rows(component, old_rows), strength=base[first_band, k])
        for k, component in enumerate(components)
    ]
    rows = rows.ravel()
    lobes = np.stack([c.strength[rows] for c in added.components], axis=1) if added.components else base[:, :0]
    notes = list(dict.fromkeys(text for sky in skies for text in sky.texts))
    notes += [f"below the horizon, so without photons: {', '.join(added.hidden)}"] if added.hidden else []
    return dataclasses.replace(
        light,
        components=(*own, *added.components),
        row_of_band=rows,
        notes=(*light.notes, *notes),
        irradiance=Irradiance(of_component=np.hstack([base, lobes]), horizon_loss=added.horizon_loss[rows]),
    )


def _base_irradiance(
    light: Light, level: InBands | None, bands: Wavebands, toml_path: str, has_background: bool
) -> np.ndarray:
    """Irradiance of sun and sky, shape (n_band, n_component). [W m-2 nm-1]"""
    components, rows = light.components, light.row_of_band
    if not components:
        return np.zeros((bands.n_bands, 0))
    assert level is not None, "components without a level have irradiances"
    share = np.stack([c.strength[rows] * (c.mass.max(axis=1) > 0)[rows if len(c.mass) > 1 else 0] for c in components])
    is_beam = np.array([c.name == BEAM for c in components])
    beam, sky = share[is_beam].sum(axis=0), share[~is_beam].sum(axis=0)
    missing = ["diffuse"] * (level.diffuse is None and bool(np.any(sky > 0)))
    missing += ["direct"] * (level.direct is None and bool(np.any((beam > 0) & ~(sky > 0))))
    if missing:
        _refuse_unknown(missing, bands, toml_path, has_background=has_background)
    zero = np.zeros(bands.n_bands)
    direct, diffuse = (zero if one is None else one for one in (level.direct, level.diffuse))
    for name, expected, modelled in (("diffuse", diffuse, sky), ("direct", direct, beam)):
        idle = np.flatnonzero((expected > 0) & ~(modelled > 0))
        if idle.size:
            band = int(idle[0])
            raise SceneError(
                f"sky.toml: {name}_irradiance is {expected[band]:g} W m-2 nm-1 in waveband {band + 1} at "
                f"{bands.wavelength_nm[band]:g} nm, but the scene has no {name} light there",
                "write 0.0 for it",
            )
    total = np.where(is_beam[:, None], beam, sky)
    irradiance = np.where(is_beam[:, None], direct, diffuse)
    found: np.ndarray = (np.divide(share, total, out=np.zeros_like(share), where=total > 0) * irradiance).T
    return found


def _refuse_unknown(missing: Sequence[str], bands: Wavebands, toml_path: str, *, has_background: bool) -> None:
    """Raise, with the lines to write, where no file says how bright sun or sky is."""
    at = ", ".join(f"{w:g}" for w in bands.wavelength_nm[:_MAX_SHOWN]) + (", ..." if bands.n_bands > _MAX_SHOWN else "")
    values = ", ".join(["0.1"] * bands.n_bands)
    lines = "".join(f"{name}_irradiance = [{values}]\n" for name in missing)
    what = "the light of a background is in W m-2 nm-1, but no file says how bright sun and sky are"
    if not has_background:
        what = f"[sky] says how bright one of sun and sky is, and nothing says it of the {missing[0]} light"
    raise refuse(
        toml_path,
        what,
        code="E708",
        advice="write their irradiances on a horizontal plane below [sky] of sky.toml, one value for each waveband "
        f"({at} nm):\n\n[sky]\n{lines}",
    )
