"""`light_of`: what is said about the light of a scene becomes components with strengths and irradiances.

Whatever names the sky, the beam is shared out here alone.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.component import Component, scaled
from aomc_sky.errors import InputWarning, UsageError
from aomc_sky.formats.sky_toml.keys import SKY_TOML, SPECTRL2
from aomc_sky.formats.sky_toml.sections import PerezSection
from aomc_sky.formats.text_file import refuse
from aomc_sky.skies.direct_beam import SOLAR_RADIUS_DEG, DirectBeam
from aomc_sky.source.light.absolute import Levels, Light, in_absolute_units
from aomc_sky.source.light.diffuse import Diffuse, DiffuseSky, Rows
from aomc_sky.source.light.inputs import LightInputs, Unsaid
from aomc_sky.source.light.sun import Sun, amounts_of_fractions, direct_fraction, mean_fraction, refuse_kilowatts
from aomc_sky.wavebands import Wavebands

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.sky import LobeSky
    from aomc_sky.source.light.spectral_split import SpectralSplit

DIFCOL = "difcol.inp"
_THREE_LINES = (
    "[perez]\ndni = 850.0    # direct normal irradiance, W m-2\ndhi = 95.0     # diffuse horizontal irradiance, W m-2"
)
_AMOUNTS = "two of {dni}, {dhi} and {ghi}, or {epsilon} and {delta}, or {spectrum:spectrl2} for a cloudless sky"


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
        fractions = np.zeros(bands.n_bands)
        levels = Levels(diffuse=levels.diffuse)
    intensity = np.ones(bands.n_bands) if inputs.shares is None else inputs.shares.intensity
    lit = intensity > 0
    is_lit = bool(np.any(fractions[lit if lit.any() else slice(None)] < 1))
    rows, row_of_band = _rows(sky, fractions, bands.wavelength_nm, has_table=is_lit)
    components = _beam(sun, rows.direct_fraction)
    diffuse, amounts = Diffuse(), split.amounts
    if is_lit:
        if sky.name == "perez" and not amounts.has_set and sun is not None:
            origin = DIFCOL if inputs.shares is not None else SKY_TOML
            amounts = amounts_of_fractions(split.direct_fraction, intensity, sun, origin)
        diffuse = sky.lower(sun, rows, amounts)
    components += scaled(diffuse.components, 1.0 - rows.direct_fraction)
    own = None if diffuse.irradiance is None else diffuse.irradiance[row_of_band]
    notes = [*_split_notes(split, sky if is_lit else None, inputs, sun), *diffuse.notes]
    if sun is not None and not sky.is_sunless:
        notes += sun.notes if is_lit else ["polarisation is not used, there is no sky"] * (sun.polarisation is not None)
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
        row_of_band=row_of_band,
        sky_wavelength_nm=sky.wavelength_of(rows.table_row)[row_of_band] if is_lit and sky.wavelength_of else None,
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


def _rows(
    sky: DiffuseSky, fractions: np.ndarray, wavelength_nm: np.ndarray, *, has_table: bool
) -> tuple[Rows, np.ndarray]:
    """Rows of the scene, and the row of each waveband: one for each, or one for each that differs."""
    n_bands = fractions.size
    if sky.is_spectral:
        every = np.arange(n_bands)
        return Rows(direct_fraction=fractions, wavelength_nm=wavelength_nm, table_row=every), every
    table = np.zeros(n_bands, np.int64)
    if sky.table_rows is not None and has_table:
        table = sky.table_rows(wavelength_nm)
    pairs, first, rows = np.unique(np.column_stack([fractions, table]), axis=0, return_index=True, return_inverse=True)
    found = Rows(direct_fraction=pairs[:, 0], wavelength_nm=wavelength_nm[first], table_row=table[first])
    return found, rows.ravel()


def _beam(sun: Sun | None, fractions: np.ndarray) -> list[Component]:
    """The sun's beam with these strengths, if one of them is above 0."""
    if sun is None or not np.any(fractions > 0):
        return []
    radius = SOLAR_RADIUS_DEG if sun.disc else 0.0
    beam = DirectBeam(sun_zenith_deg=sun.zenith_deg, sun_azimuth_deg=sun.azimuth_deg, radius_deg=radius)
    return scaled(beam.lower(fractions), fractions)


# How direct the light of each waveband is: difcol.inp, irradiances of every waveband, broadband irradiances, a
# cloudless sky, or what it means that nothing says it.


def _split(
    inputs: LightInputs, sun: Sun | None, sky: DiffuseSky, bands: Wavebands, unsaid: Unsaid, path: str
) -> _Split:
    amounts, n_bands = inputs.amounts, bands.n_bands
    said = Levels.said_by(inputs)
    if amounts.has_set and sun is not None:
        refuse_kilowatts(amounts, sun)
    if said.direct is not None and said.diffuse is not None:
        return _by_irradiances(said.direct, said.diffuse, amounts)
    if inputs.shares is not None:
        assert sun is not None, "difcol.inp stands beside amc.inp"
        _warn_of_other_light(inputs, sun)
        return _Split(direct_fraction=inputs.shares.direct_fraction, origin=DIFCOL, amounts=amounts, levels=said)
    whole = _Split(direct_fraction=np.zeros(n_bands), amounts=amounts, levels=said)
    if unsaid is Unsaid.WHOLE and not sky.is_file:
        whole = dataclasses.replace(whole, origin="the sky model replaces skydist.inp")
        if sky.name == "perez":
            if not amounts.has_set:
                raise _missing_amounts(inputs)
            return whole
    if inputs.is_cloudless:
        assert sun is not None, "light_of finds the sun of a cloudless sky"
        return _cloudless(inputs, sun, bands, said)
    fraction = direct_fraction(amounts, sun) if amounts.has_set and sun is not None else None
    if fraction is not None:
        assert sun is not None, "amounts need a sun"
        return _by_amounts(inputs, sun, bands, fraction, unsaid, said)
    if unsaid is Unsaid.ERROR and not inputs.diffuse_only:
        reason = f"{amounts.text} do not say" if amounts.has_set else "nothing else says"
        raise refuse(
            path,
            f"there is no such file, and {reason} how much of the light is direct",
            advice=f"write {DIFCOL}, or these lines into sky.toml beside amc.inp:\n\n{_THREE_LINES}\n",
        )
    if amounts.has_set:
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


def _missing_amounts(inputs: LightInputs) -> UsageError:
    text = (
        "{sky:perez} instead of skydist.inp needs dni and dhi (or epsilon and delta, or a to e): give them, or write "
    )
    return UsageError(f"{inputs.say(text)}into sky.toml beside amc.inp\n\n{_THREE_LINES}\n")


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
        _warn_of_one_fraction(inputs, fraction, is_from_files=is_from_files)
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


def _warn_of_one_fraction(inputs: LightInputs, fraction: float, *, is_from_files: bool) -> None:
    """Warn where beam and sky both shine, so that the fraction differs between wavebands."""
    say, without, other = inputs.say, "without difcol.inp ", " (in sky.toml: [perez] spectrum) or difcol.inp"
    if not is_from_files:
        without = other = ""
    warnings.warn(
        f"{without}every waveband has the broadband direct fraction {fraction:.3g}, but blue light is "
        f"more diffuse and red light less; write {say('{spectrum:spectrl2}')}{other}; {say('{spectrum:flat}')} keeps "
        "this fraction without a warning",
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
        who = str(inputs.amounts) if inputs.has_amounts and inputs.shares is None else split.origin
        return [f"the direct beam of the sun, {_spread(fractions, '.4g')} of the light, is left out ({who})"]
    hint = ""
    if split.origin == DIFCOL and sky.name == "perez" and inputs.amounts.has_set and sun is not None:
        other = direct_fraction(inputs.amounts, sun)
        hint = "" if other is None else f" ({inputs.amounts.text} alone: {other:.3g})"
    return [f"{split.origin}: direct fraction {_spread(fractions)}{hint}, the rest from {sky}"]


def _spread(values: np.ndarray, form: str = "g") -> str:
    low, high = (format(float(extreme(values)), form) for extreme in (np.min, np.max))
    return low if low == high else f"{low} to {high}"
