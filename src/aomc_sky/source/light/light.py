"""`light_of`: what is said about the light of a scene becomes components with strengths and irradiances.

Whatever names the sky, the beam is shared out here alone.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aomc_sky.component import Component, scaled
from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.errors import InputWarning, SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import SKY_TOML, SPECTRL2
from aomc_sky.formats.sky_toml.sections import PerezSection
from aomc_sky.formats.text_file import refuse
from aomc_sky.source.light.diffuse import Diffuse, DiffuseSky, Rows
from aomc_sky.source.light.inputs import LightInputs, Unsaid
from aomc_sky.source.light.sun import Sun, amounts_of_fractions, direct_fraction, mean_fraction, refuse_kilowatts
from aomc_sky.wavebands import Wavebands

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.sky import LobeSky
    from aomc_sky.source.light.spectral_split import SpectralSplit

DIFCOL = "difcol.inp"
BEAM = "direct"
_MAX_SHOWN = 12
_THREE_LINES = (
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


class Levels(NamedTuple):
    """Irradiances of beam and sky on a horizontal plane, (n_band,), where they are known. [W m-2 nm-1]"""

    direct: np.ndarray | None = None
    diffuse: np.ndarray | None = None

    @property
    def is_unknown(self) -> bool:
        """Whether nothing is known."""
        return self.direct is None and self.diffuse is None

    @classmethod
    def said_by(cls, inputs: LightInputs) -> Levels:
        """Those of [sky]."""
        both = (inputs.direct_irradiance, inputs.diffuse_irradiance)
        return cls(*(None if one is None else np.array(one, dtype=np.float64) for one in both))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Split:
    """How direct each waveband is, and who says it."""

    direct_fraction: np.ndarray
    origin: str = ""  #: for the note; empty: there is nothing to say
    amounts: PerezSection = field(default_factory=PerezSection)  #: for the Perez sky
    levels: Levels = field(default_factory=Levels)
    options: dict[str, Any] = field(default_factory=dict)


def light_of(
    inputs: LightInputs,
    sky: DiffuseSky | Callable[[LightInputs], Light],
    bands: Wavebands,
    *,
    unsaid: Unsaid,
    path: str = "",
    backgrounds: Sequence[LobeSky] = (),
    toml_path: str = "",
) -> Light:
    """The light of `inputs` and of a sky, or of a function that makes sun and sky itself, and of background lobes.

    `path` is the difcol.inp that an error names, `toml_path` the sky.toml.
    """
    if callable(sky):
        light, levels = sky(inputs), Levels.said_by(inputs)
    else:
        light, levels = _sun_and_sky(inputs, sky, bands, unsaid, path)
    return in_absolute_units(light, levels, backgrounds, bands, toml_path)


def _sun_and_sky(
    inputs: LightInputs, sky: DiffuseSky, bands: Wavebands, unsaid: Unsaid, path: str
) -> tuple[Light, Levels]:
    """Beam and sky in their shares, and the irradiances of both where they are known."""
    sun = _sun(inputs, sky, unsaid)
    split = _split(inputs, sun, sky, bands, unsaid, path)
    fractions, levels = split.direct_fraction, split.levels
    if inputs.diffuse_only:
        fractions = (fractions == 1).astype(np.float64)  # a waveband that has only the beam is dark without it
        levels = Levels(diffuse=levels.diffuse)
    intensity = np.ones(bands.n_bands) if inputs.shares is None else inputs.shares.intensity
    lit = intensity > 0
    is_lit = bool(np.any(fractions[lit if lit.any() else slice(None)] < 1))
    if inputs.diffuse_only and not is_lit:
        say = inputs.say("{diffuse_only:True}")
        raise SceneError(
            f"all light is direct ({_who(split, inputs)}), and {say} leaves the beam out: no light is left"
        )
    rows = _rows(sky, fractions, bands.wavelength_nm, has_table=is_lit)
    rows = dataclasses.replace(rows, is_alone=inputs.diffuse_only)
    components = [] if inputs.diffuse_only else _beam(sun, rows.direct_fraction)
    diffuse, amounts = Diffuse(), split.amounts
    if is_lit:
        if sky.name == "perez" and not amounts.has_set and sun is not None:
            origin = DIFCOL if inputs.shares is not None else SKY_TOML
            amounts = amounts_of_fractions(split.direct_fraction, intensity, sun, origin)
        diffuse = sky.lower(sun, rows, amounts)
    of_table = sky.table_wavelength_nm
    components += scaled(diffuse.components, 1.0 - rows.direct_fraction)
    own = None if diffuse.irradiance is None else diffuse.irradiance[rows.of_band]
    notes = [*_split_notes(split, sky if is_lit else None, inputs, sun), *diffuse.notes]
    if sun is not None and not sky.is_sunless:
        notes += sun.notes if is_lit else ["polarisation is not used, there is no sky"] * (sun.polarisation is not None)
    if inputs.diffuse_only and sky.is_file and not split.direct_fraction.any():
        notes.append(inputs.say(f"{{diffuse_only:True}} leaves nothing out: no beam is asked for beside {sky}"))
    if inputs.shares is not None and inputs.has_both_irradiances:
        notes.append(f"{DIFCOL}: its direct fractions are not used, [sky] of {SKY_TOML} gives them")
    if own is not None and levels.diffuse is None:
        levels = Levels(direct=levels.direct, diffuse=own)
    elif own is not None and inputs.diffuse_irradiance is None:
        notes.append(
            f"{sky}: its own irradiance, {_spread(own, '.4g')} W m-2 nm-1, is not used: {split.origin} say how bright "
            "it is"
        )
    return Light(
        components=tuple(components),
        row_of_band=rows.of_band,
        sky_wavelength_nm=of_table(bands.wavelength_nm) if is_lit and of_table is not None else None,
        intensity=None if inputs.shares is None else intensity,
        notes=tuple(notes),
        options={
            "sky": sky.name if is_lit else None,
            "sun": None if sun is None else sun.as_options(),
            **diffuse.options,
            **split.options,
        },
    ), levels


def _sun(inputs: LightInputs, sky: DiffuseSky, unsaid: Unsaid) -> Sun | None:
    """The sun, if the scene needs one."""
    has_amounts = inputs.amounts.has_set or inputs.spectrum == SPECTRL2 or inputs.direct_irradiance is not None
    has_pattern = inputs.polarisation is not None and not sky.is_sunless
    is_needed = has_amounts or has_pattern or (sky.takes_sun and not sky.is_file) or unsaid is Unsaid.ERROR
    if not is_needed and (sky.is_file or inputs.sun.zenith_deg is None):
        return None
    is_named = sky.name != "perez" and not sky.words
    return inputs.scene_sun(inputs.say(f"{{sky:{sky.name}}}") if is_named else str(sky))


def _rows(sky: DiffuseSky, fractions: np.ndarray, wavelength_nm: np.ndarray, *, has_table: bool) -> Rows:
    """Rows of the scene: one for each waveband, or one for each that differs."""
    n_bands = fractions.size
    if sky.is_spectral:
        every = np.arange(n_bands)
        return Rows(
            direct_fraction=fractions,
            wavelength_nm=wavelength_nm,
            table_row=every,
            of_band=every,
            band_nm=wavelength_nm,
        )
    table = np.zeros(n_bands, np.int64)
    if sky.table_rows is not None and has_table:
        table = sky.table_rows(wavelength_nm)
    pairs, first, rows = np.unique(np.column_stack([fractions, table]), axis=0, return_index=True, return_inverse=True)
    return Rows(
        direct_fraction=pairs[:, 0],
        wavelength_nm=wavelength_nm[first],
        table_row=table[first],
        of_band=rows.ravel(),
        band_nm=wavelength_nm,
    )


def _beam(sun: Sun | None, fractions: np.ndarray) -> list[Component]:
    """The sun's beam with these strengths, if one of them is above 0."""
    if sun is None or not np.any(fractions > 0):
        return []
    from aomc_sky.skies.direct_beam import SOLAR_RADIUS_DEG, DirectBeam

    radius = SOLAR_RADIUS_DEG if sun.disc else 0.0
    beam = DirectBeam(sun_zenith_deg=sun.zenith_deg, sun_azimuth_deg=sun.azimuth_deg, radius_deg=radius)
    return scaled(beam.lower(fractions), fractions)


# How direct the light of each waveband is: difcol.inp, irradiances of every waveband, broadband irradiances, a
# cloudless sky, or what it means that nothing says it.


def _split(
    inputs: LightInputs, sun: Sun | None, sky: DiffuseSky, bands: Wavebands, unsaid: Unsaid, path: str
) -> _Split:
    amounts, has_set = inputs.amounts, inputs.amounts.has_set
    said = Levels.said_by(inputs)
    if has_set and sun is not None:
        refuse_kilowatts(amounts, sun)
    if said.direct is not None and said.diffuse is not None:
        return _by_irradiances(said.direct, said.diffuse, amounts)
    if inputs.shares is not None:
        assert sun is not None, "difcol.inp stands beside amc.inp"
        _warn_of_other_light(inputs, sun)
        return _Split(direct_fraction=inputs.shares.direct_fraction, origin=DIFCOL, amounts=amounts, levels=said)
    whole = _Split(direct_fraction=np.zeros(bands.n_bands), amounts=amounts, levels=said)
    if unsaid is Unsaid.WHOLE and not sky.is_file:
        whole = dataclasses.replace(whole, origin="the sky model replaces skydist.inp")
        if sky.name == "perez":
            if not has_set:
                text = "{sky:perez} instead of skydist.inp needs dni and dhi (or epsilon and delta, or a to e)"
                raise UsageError(
                    f"{inputs.say(text)}: give them, or write into sky.toml beside amc.inp\n\n{_THREE_LINES}\n"
                )
            return whole
    if inputs.is_cloudless:
        assert sun is not None, "light_of finds the sun of a cloudless sky"
        return _cloudless(inputs, sun, bands, said)
    fraction = direct_fraction(amounts, sun) if has_set and sun is not None else None
    if fraction is not None:
        assert sun is not None, "amounts need a sun"
        return _by_amounts(inputs, sun, bands, fraction, unsaid, said)
    if unsaid is Unsaid.ERROR and not inputs.diffuse_only:
        reason = f"{amounts.text} do not say" if has_set else "nothing else says"
        raise refuse(
            path,
            f"there is no such file, and {reason} how much of the light is direct",
            advice=f"write {DIFCOL}, or {inputs.say(_AMOUNTS)}, or these lines into sky.toml beside amc.inp, in place "
            f"of an [atmosphere]:\n\n{_THREE_LINES}\n",
        )
    if has_set:
        return dataclasses.replace(
            whole, origin="coefficients do not say how bright the beam is: the sky is launched alone"
        )
    if sky.name == "perez":
        raise UsageError(inputs.say(f"which sky? write {_AMOUNTS}, or {{coefficients:a b c d e}}"))
    if unsaid is Unsaid.WARNING and sun is not None and not inputs.diffuse_only:
        text = (
            f"nothing says how bright it is beside {sky}; write {_AMOUNTS}, or {{diffuse_only:True}} for the sky alone"
        )
        warnings.warn(f"the direct beam of the sun is missing: {inputs.say(text)}", InputWarning, stacklevel=4)
    return whole


def _by_irradiances(direct: np.ndarray, diffuse: np.ndarray, amounts: PerezSection) -> _Split:
    """The shares of irradiances of beam and sky that are known for every waveband."""
    both = direct + diffuse
    fraction = np.divide(direct, both, out=np.zeros_like(both), where=both > 0)
    return _Split(
        direct_fraction=fraction,
        origin=f"direct_irradiance and diffuse_irradiance ({SKY_TOML})" if fraction.any() else "",
        amounts=amounts,
        levels=Levels(direct, diffuse),
    )


def _cloudless(inputs: LightInputs, sun: Sun, bands: Wavebands, said: Levels) -> _Split:
    """The light of a cloudless sky."""
    from aomc_sky.source.light.spectral_split import ClearSky, cloudless_split

    found = cloudless_split(ClearSky(**inputs.clear_sky), sun, bands.wavelength_nm)
    distance = "at the sun's mean distance" if sun.distance_factor is None else "on that day"
    amounts = inputs.amounts
    if not amounts.has_set:
        words = f"dni {found.dni:.4g} and dhi {found.dhi:.4g} W m-2"
        amounts = PerezSection(dni=found.dni, dhi=found.dhi, origin="a cloudless sky", words=words)
    return _by_spectrum(found, f"{found}, {distance}", amounts, said)


def _by_spectrum(found: SpectralSplit, origin: str, amounts: PerezSection, said: Levels) -> _Split:
    """The share of each waveband by a spectrum; irradiances that are said come before those of the spectrum."""
    return _Split(
        direct_fraction=found.direct_fraction,
        origin=origin,
        amounts=amounts,
        options={"spectrum": found.as_options()},
        levels=Levels(found.direct_irradiance, found.diffuse_irradiance) if said.is_unknown else said,
    )


def _by_amounts(
    inputs: LightInputs, sun: Sun, bands: Wavebands, fraction: float, unsaid: Unsaid, said: Levels
) -> _Split:
    """One broadband share, or that of each waveband by a spectrum."""
    amounts = inputs.amounts
    if inputs.spectrum == SPECTRL2:
        from aomc_sky.source.light.spectral_split import spectral_split

        found = spectral_split(amounts, sun, bands.wavelength_nm)
        return _by_spectrum(found, f"{amounts}, {found}", amounts, said)
    is_from_files = unsaid is Unsaid.ERROR
    how = " without difcol.inp" if is_from_files else ", the broadband share"
    if not is_from_files and bands.n_bands > 1:
        how += " in every waveband (blue light is more diffuse, red light less)"
    is_shared = 0.0 < fraction < 1.0 and not inputs.diffuse_only
    if unsaid is not Unsaid.WARNING and inputs.spectrum is None and is_shared:
        say, without, other = inputs.say, "without difcol.inp ", " (in sky.toml: [perez] spectrum) or difcol.inp"
        if not is_from_files:
            without = other = ""
        warnings.warn(
            f"{without}every waveband has the broadband direct fraction {fraction:.3g}, but blue light is "
            f"more diffuse and red light less; write {say('{spectrum:spectrl2}')}{other}; {say('{spectrum:flat}')} "
            "keeps this fraction without a warning",
            InputWarning,
            stacklevel=2,
        )
    return _Split(
        direct_fraction=np.full(bands.n_bands, fraction), origin=f"{amounts}{how}", amounts=amounts, levels=said
    )


_MORE_DIRECT = 0.1
"""Allowed excess of the direct fraction of visible bands over that of the whole spectrum."""


def _warn_of_other_light(inputs: LightInputs, sun: Sun) -> None:
    """Warn where the bands of difcol.inp have far more beam than an hour of a weather file."""
    shares = inputs.shares
    if shares is None or not inputs.is_of_file or not shares.intensity.max() > 0:
        return
    other = direct_fraction(inputs.amounts, sun)
    assert other is not None, "a file has irradiances"
    lit = shares.intensity > 0
    mean = mean_fraction(shares.direct_fraction, shares.intensity)
    if np.any(shares.direct_fraction[lit] < 1) and mean > other + _MORE_DIRECT:
        warnings.warn(
            f"difcol.inp shares the photons, {mean:.3g} of them direct, but {inputs.amounts} say {other:.3g}: it is of "
            f"clearer weather; remove difcol.inp and write {inputs.say('{spectrum:spectrl2}')} to share them by these "
            "irradiances",
            InputWarning,
            stacklevel=2,
        )


def _split_notes(split: _Split, sky: DiffuseSky | None, inputs: LightInputs, sun: Sun | None) -> list[str]:
    fractions = split.direct_fraction
    if not split.origin or (sky is not None and sky.is_file and not fractions.any()):
        return []
    if split.amounts.coefficients is not None and not fractions.any():
        return [split.origin]
    if sky is None:
        return [f"{split.origin}: all light is direct, so no sky is modelled"]
    if inputs.diffuse_only and fractions.any():
        beam = _spread(fractions, ".4g")
        return [f"the direct beam of the sun, {beam} of the light, is left out ({_who(split, inputs)})"]
    hint = ""
    if split.origin == DIFCOL and sky.name == "perez" and inputs.amounts.has_set and sun is not None:
        other = direct_fraction(inputs.amounts, sun)
        hint = "" if other is None else f" ({inputs.amounts.text} alone: {other:.3g})"
    return [f"{split.origin}: direct fraction {_spread(fractions)}{hint}, the rest from {sky}"]


def _who(split: _Split, inputs: LightInputs) -> str:
    """Who says how direct each waveband is."""
    return str(inputs.amounts) if inputs.has_amounts and inputs.shares is None else split.origin


def _spread(values: np.ndarray, form: str = "g") -> str:
    low, high = (format(float(extreme(values)), form) for extreme in (np.min, np.max))
    return low if low == high else f"{low} to {high}"


# How bright sun and sky are, where that is known, and the lobes of backgrounds.


def in_absolute_units(
    light: Light, levels: Levels, skies: Sequence[LobeSky], bands: Wavebands, toml_path: str
) -> Light:
    """State the irradiance of every component, and add the lobes of the backgrounds.

    Light in relative units stays as it is. With backgrounds the strengths are irradiances in the same unit, with a row
    for each distinct set of base row, wavelength and irradiances. E708: backgrounds beside relative light.
    """
    if light.irradiance is not None:
        base = light.irradiance.of_component
    elif skies or not levels.is_unknown:
        base = _base_irradiance(light, levels, bands, toml_path, has_background=bool(skies))
    else:
        return light
    if not skies:
        dark = np.flatnonzero(base.sum(axis=1) == 0)
        if dark.size and not levels.is_unknown:
            raise SceneError(
                f"waveband {dark[0] + 1} at {bands.wavelength_nm[dark[0]]:g} nm has no light: direct_irradiance and "
                "diffuse_irradiance are 0 there; write a positive value, or choose others by --waveband"
            )
        return dataclasses.replace(light, irradiance=Irradiance(of_component=base))
    return _joined(light, base, skies, bands)


def _joined(light: Light, base: np.ndarray, skies: Sequence[LobeSky], bands: Wavebands) -> Light:
    """Sun, sky and lobes with strengths in one unit."""
    from aomc_sky.skies.lobes.light import background_light

    components = light.components
    keys = np.column_stack([light.row_of_band, bands.wavelength_nm, base])
    _, first, rows = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    added = background_light(skies, bands.wavelength_nm[first], taken=[c.name for c in components])
    if not components and not added.components:
        reason = "all their lobes lie below the horizon" if added.hidden else "their lobes have no light at that time"
        raise SceneError(f"the backgrounds are the only source of light, but {reason}")
    old_rows = light.row_of_band[first]
    own = [
        dataclasses.replace(
            component,
            strength=base[first, k],
            **{name: _rows_of(getattr(component, name), old_rows) for name in ("mass", "weight", "slope", "stokes")},
        )
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


def _rows_of(values: np.ndarray | None, rows: np.ndarray) -> Any:
    """The needed rows of masses, weights or slopes, if there are any; a single row is for all."""
    return values if values is None or values.shape[0] == 1 else values[rows]


def _base_irradiance(
    light: Light, levels: Levels, bands: Wavebands, toml_path: str, *, has_background: bool
) -> np.ndarray:
    """Irradiance of sun and sky, shape (n_band, n_component). [W m-2 nm-1]"""
    components, rows = light.components, light.row_of_band
    if not components:
        return np.zeros((bands.n_bands, 0))
    share = np.stack([c.strength[rows] * (c.mass.max(axis=1) > 0)[rows if len(c.mass) > 1 else 0] for c in components])
    is_beam = np.array([c.name == BEAM for c in components])
    beam, sky = share[is_beam].sum(axis=0), share[~is_beam].sum(axis=0)
    _refuse_unknown(levels, beam, sky, bands, toml_path, has_background=has_background)
    diffuse = np.zeros(bands.n_bands) if levels.diffuse is None else levels.diffuse
    direct = levels.direct
    if direct is None:
        direct = np.divide(diffuse * beam, sky, out=np.zeros_like(diffuse), where=sky > 0)
    for name, expected, modelled in (("diffuse", diffuse, sky), ("direct", direct, beam)):
        idle = np.flatnonzero((expected > 0) & ~(modelled > 0))
        if idle.size:
            band = int(idle[0])
            raise SceneError(
                f"sky.toml: {name}_irradiance is {expected[band]:g} W m-2 nm-1 in waveband {band + 1} at "
                f"{bands.wavelength_nm[band]:g} nm, but the scene has no {name} light there; write 0.0 for it"
            )
    total = np.where(is_beam[:, None], beam, sky)
    level = np.where(is_beam[:, None], direct, diffuse)
    irradiance: np.ndarray = (np.divide(share, total, out=np.zeros_like(share), where=total > 0) * level).T
    return irradiance


def _refuse_unknown(
    levels: Levels, beam: np.ndarray, sky: np.ndarray, bands: Wavebands, toml_path: str, *, has_background: bool
) -> None:
    """Raise, with the lines to write, where no file says how bright sun or sky is."""
    missing = []
    if levels.diffuse is None and np.any(sky > 0):
        missing.append("diffuse")
    if levels.direct is None and np.any((beam > 0) & ~(sky > 0)):
        missing.append("direct")
    if not missing:
        return
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
