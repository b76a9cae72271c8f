"""How bright are beam and sky in each waveband? One answer of a small set, by the first who says it."""

from __future__ import annotations

import dataclasses
import math
import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from aomc_sky.errors import InputWarning, SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import SKY_TOML, SPECTRL2
from aomc_sky.formats.sky_toml.sections import PerezSection
from aomc_sky.options import AMOUNTS, CLEAR_SKY, WEATHER_FILES, say
from aomc_sky.source.light.place import Sun
from aomc_sky.source.light.said import Speakers, air_said, callers_of, first, spectrum_said

if TYPE_CHECKING:
    from aomc_sky.formats.aomc.amc import DifcolTable
    from aomc_sky.source.light.spectral_split import SpectralSplit

DIFCOL = "difcol.inp"
BOTH_IRRADIANCES = f"direct_irradiance and diffuse_irradiance ({SKY_TOML})"


@dataclass(frozen=True, kw_only=True, slots=True)
class InBands:
    """Beam and sky in each waveband, on a horizontal plane."""

    direct_fraction: np.ndarray  #: (n_band,) share of the beam [0 to 1]
    direct: np.ndarray | None = None  #: (n_band,) irradiances, where they are known [W m-2 nm-1]
    diffuse: np.ndarray | None = None
    who: str = ""  #: who says so, for notes
    notes: tuple[str, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)
    broadband: PerezSection | None = None  #: irradiances of the whole spectrum of a cloudless sky
    intensity: np.ndarray | None = None  #: (n_band,) photons per iteration; None: 1

    def without_beam(self) -> InBands:
        """The sky alone, which keeps what it had; a waveband that has only the beam is dark."""
        alone = (self.direct_fraction == 1).astype(np.float64)
        return dataclasses.replace(self, direct_fraction=alone, direct=None)


class Brightness(Protocol):
    """An answer."""

    @property
    def names(self) -> tuple[str, ...]:
        """The inputs of a caller that it uses."""

    @property
    def has_beam(self) -> bool:
        """Whether it says how bright the beam is."""

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """Beam and sky of each waveband; `own` is the irradiance of a sky in absolute units."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OfTheSky:
    """Nobody says it: the sky alone."""

    sky: str  #: for people
    names, has_beam = (), False

    def __str__(self) -> str:
        return self.sky

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """The sky alone."""
        return InBands(direct_fraction=np.zeros(wavelength_nm.size), diffuse=own)


@dataclass(frozen=True, kw_only=True, slots=True)
class PerBand:
    """Irradiances of beam and sky for each waveband, of [sky]."""

    direct: np.ndarray
    diffuse: np.ndarray
    names, has_beam = (), True

    def __str__(self) -> str:
        return BOTH_IRRADIANCES

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """The irradiances of the file."""
        return _shares(self.direct, self.diffuse, str(self))


@dataclass(frozen=True, kw_only=True, slots=True)
class Shares:
    """The direct fraction of each waveband, of difcol.inp."""

    table: DifcolTable
    names, has_beam = (), True

    def __str__(self) -> str:
        return DIFCOL

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """The shares; beside a sky in absolute units the beam is in proportion to it."""
        fraction = self.table.direct_fraction
        if own is None:
            return InBands(direct_fraction=fraction, who=DIFCOL)
        if np.any(fraction == 1):
            note = "the sky's own irradiance is not used, for a waveband has direct light alone"
            return InBands(direct_fraction=fraction, who=DIFCOL, notes=(note,))
        return InBands(direct_fraction=fraction, direct=own * fraction / (1.0 - fraction), diffuse=own, who=DIFCOL)


@dataclass(frozen=True, kw_only=True, slots=True)
class Broadband:
    """Irradiances of the whole spectrum, or clearness and brightness."""

    amounts: PerezSection
    spectrum: str | None  #: None: nobody says it
    warns: bool = False  #: whether one share for all wavebands gets a warning, unless it was asked for
    names, has_beam = (*AMOUNTS, *WEATHER_FILES, "row", "spectrum"), True

    def __str__(self) -> str:
        return str(self.amounts)

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """One share for all wavebands, or spectra scaled to the irradiances."""
        assert sun is not None, "a beam has a sun"
        refuse_kilowatts(self.amounts, sun)
        if own is not None and self.spectrum not in (None, SPECTRL2):
            raise UsageError(
                say(
                    f"{{spectrum:{self.spectrum}}} gives beam and sky one share in all wavebands, but the sky is in W "
                    "m-2 nm-1 and needs the beam of each wavelength; write {spectrum:spectrl2}, or leave it out"
                )
            )
        if own is None and self.spectrum != SPECTRL2:
            return self._flat(sun, wavelength_nm.size)
        from aomc_sky.source.light.spectral_split import spectral_split

        dni, dhi = irradiances(self.amounts, sun)
        if dni + dhi == 0:
            raise SceneError(f"{self.amounts} leave no light at all")
        found = spectral_split(dni, dhi, sun, wavelength_nm)
        if own is None:
            return _of_spectra(found, f"{self.amounts}, {found}")
        _warn_of_level(own, found, self.amounts)
        return _shares(found.direct_irradiance, own, f"{self.amounts}, {found}", found)

    def _flat(self, sun: Sun, n_bands: int) -> InBands:
        fraction = direct_fraction(self.amounts, sun)
        if self.warns and self.spectrum is None and 0.0 < fraction < 1.0:
            warnings.warn(
                say(
                    f"every waveband has the broadband direct fraction {fraction:.3g} of {self.amounts}, but blue "
                    "light is more diffuse and red light less; write {spectrum:spectrl2}; {spectrum:flat} keeps this "
                    "fraction without a warning"
                ),
                InputWarning,
                stacklevel=2,
            )
        how = " in every waveband (blue light is more diffuse, red light less)" if n_bands > 1 else ""
        who = f"{self.amounts}, the broadband share{how}"
        return InBands(direct_fraction=np.full(n_bands, fraction), who=who)


@dataclass(frozen=True, kw_only=True, slots=True)
class Cloudless:
    """The cloudless sky of SPCTRL2."""

    air: dict[str, Any]  #: what is said of it
    altitude_m: float  #: for the pressure, unless that is said
    names, has_beam = ("spectrum", *CLEAR_SKY, "altitude_m"), True

    def __str__(self) -> str:
        return "a cloudless sky"

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """Beam and sky of the model, or its beam beside a sky in absolute units."""
        from aomc_sky.source.light.spectral_split import ClearSky, cloudless_split

        assert sun is not None, "a beam has a sun"
        found = cloudless_split(ClearSky(**self.air).at(self.altitude_m), sun, wavelength_nm)
        when = "at the sun's mean distance" if sun.distance_factor is None else "on that day"
        who = f"{found}, {when}"
        if own is not None:
            return _shares(found.direct_irradiance, own, who, found)
        words = f"dni {found.dni:.4g} and dhi {found.dhi:.4g} W m-2"
        broadband = PerezSection(dni=found.dni, dhi=found.dhi, origin="a cloudless sky", words=words)
        return dataclasses.replace(_of_spectra(found, who), broadband=broadband)


@dataclass(frozen=True, kw_only=True, slots=True)
class Levelled:
    """Another answer at the irradiance of the sky, or beside that of the beam, that [sky] says."""

    of: Brightness
    direct: np.ndarray | None = None
    diffuse: np.ndarray | None = None

    def __str__(self) -> str:
        return f"direct_irradiance ({SKY_TOML})" if self.diffuse is None else str(self.of)

    @property
    def names(self) -> tuple[str, ...]:
        """Those of the other answer, unless the beam is known."""
        return self.of.names if self.direct is None else ()

    @property
    def has_beam(self) -> bool:
        """Whether one of both has a beam."""
        return self.direct is not None or self.of.has_beam

    def in_bands(self, sun: Sun | None, wavelength_nm: np.ndarray, own: np.ndarray | None) -> InBands:
        """The irradiance of the file; beside it that of the other answer, or one in proportion to its shares.

        The level of a sky in absolute units takes the place of its own. A beam in proportion is unknown where a
        waveband has only the beam.
        """
        if self.direct is not None and own is not None:
            return _shares(self.direct, own, str(self))
        other = self.of.in_bands(sun, wavelength_nm, None if own is None else self.diffuse)
        if self.direct is not None and other.diffuse is not None:
            return _shares(self.direct, other.diffuse, str(self))
        if own is not None:
            return other
        fraction, direct = other.direct_fraction, self.direct
        if self.diffuse is not None and np.all(fraction < 1):
            direct = self.diffuse * fraction / (1.0 - fraction)
        return dataclasses.replace(other, direct=direct, diffuse=self.diffuse)


def brightness_of(speakers: Speakers, sky: str, *, is_whole: bool, warns: bool) -> Brightness:
    """Who says how bright beam and sky are; `sky` is what is bright where nobody does.

    The caller comes first, then a weather file, and of the files the finest: [sky], difcol.inp, [perez]. Beside a sky
    that is the whole light [perez] is not heard. `warns`: of one share for all wavebands that nobody asked for.
    """
    spectrum, callers = spectrum_said(speakers), callers_of(speakers)
    direct = first([one.direct_irradiance for one in speakers])
    diffuse = first([one.diffuse_irradiance for one in speakers])
    shares = first([one.shares for one in speakers])
    heard = callers if is_whole else speakers
    amounts = first([one.perez if one.perez.has_amounts else None for one in callers])
    if amounts is not None and direct is not None:
        direct = diffuse = None  # the caller comes first
    if direct is not None and diffuse is not None:
        return PerBand(direct=np.array(direct), diffuse=np.array(diffuse))
    if amounts is None and shares is None:
        amounts = first([one.perez if one.perez.has_amounts else None for one in heard])
    found: Brightness
    if amounts is not None:
        found = Broadband(amounts=amounts, spectrum=spectrum, warns=warns)
    elif shares is not None:
        found = Shares(table=shares)
    elif first([one.perez.spectrum for one in heard]) == SPECTRL2:
        altitude = first([one.altitude_m for one in speakers])
        found = Cloudless(air=air_said(speakers), altitude_m=altitude or 0.0)
    else:
        found = OfTheSky(sky=sky)
    if direct is None and diffuse is None:
        return found
    direct, diffuse = (None if one is None else np.array(one) for one in (direct, diffuse))
    return Levelled(of=found, direct=direct, diffuse=diffuse)


def _shares(direct: np.ndarray, diffuse: np.ndarray, who: str, found: SpectralSplit | None = None) -> InBands:
    """Shares of irradiances that are known."""
    both = direct + diffuse
    fraction = np.divide(direct, both, out=np.zeros_like(both), where=both > 0)
    return InBands(
        direct_fraction=fraction,
        direct=direct,
        diffuse=diffuse,
        who=who,
        options={} if found is None else {"spectrum": found.as_options() | {"direct_fraction": fraction.tolist()}},
    )


def _of_spectra(found: SpectralSplit, who: str) -> InBands:
    """The split of a spectrum."""
    return InBands(
        direct_fraction=found.direct_fraction,
        direct=found.direct_irradiance,
        diffuse=found.diffuse_irradiance,
        who=who,
        options={"spectrum": found.as_options()},
    )


_OTHER_LEVEL = 0.2
"""Largest difference of a measured sky from dhi that gets no warning, mean over the wavebands."""


def _warn_of_level(own: np.ndarray, found: SpectralSplit, amounts: PerezSection) -> None:
    """Warn where the sky's own irradiance is not about that of the spectra."""
    lit = found.diffuse_irradiance > 0
    ratio = float(np.mean(own[lit] / found.diffuse_irradiance[lit])) if lit.any() else math.inf * np.any(own > 0)
    if abs(ratio - 1.0) > _OTHER_LEVEL:
        times = f"{ratio:.3g} times that" if ratio < math.inf else "not 0, as is that"
        warnings.warn(
            f"the diffuse irradiance of the sky is {times} of {amounts}, mean over the wavebands; the sky keeps its "
            "own: check the unit of its radiances, and whether both are of one hour",
            InputWarning,
            stacklevel=2,
        )


def refuse_kilowatts(amounts: PerezSection, sun: Sun) -> None:
    """Raise if irradiances are probably in kW m-2."""
    from aomc_sky.skies.perez.irradiances import kilowatts

    if text := kilowatts((amounts.ghi, amounts.dni, amounts.dhi), sun.zenith_deg):
        raise SceneError(f"{amounts}: {text}")


def direct_fraction(amounts: PerezSection, sun: Sun) -> float:
    """Share of the beam, dni cos Z / (dni cos Z + dhi). [0 to 1]"""
    normal, diffuse = irradiances(amounts, sun) if amounts.epsilon is None else (_ratio(amounts, sun), 1.0)
    beam = normal * sun.cosine
    if beam + diffuse == 0:
        raise SceneError(f"{amounts} leave no light at all")
    return 1.0 if beam + diffuse == math.inf else beam / (beam + diffuse)


def _ratio(amounts: PerezSection, sun: Sun) -> float:
    """The ratio of dni and dhi of a clearness."""
    from aomc_sky.skies.perez.coefficients import beam_ratio

    assert amounts.epsilon is not None
    return beam_ratio(amounts.epsilon, math.radians(sun.zenith_deg))


def irradiances(amounts: PerezSection, sun: Sun) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance; of epsilon and Delta at the sun's mean distance. [W m-2]"""
    if amounts.epsilon is None:
        from aomc_sky.skies.perez.irradiances import closed_irradiances

        return closed_irradiances(
            ghi=amounts.ghi,
            dni=amounts.dni,
            dhi=amounts.dhi,
            sun_zenith_deg=sun.zenith_deg,
            extraterrestrial_normal=sun.extraterrestrial_normal,
        )
    from aomc_sky.skies.perez.coefficients import sky_brightness

    diffuse = (amounts.delta or 0.0) / float(sky_brightness(1.0, math.radians(sun.zenith_deg)))
    return _ratio(amounts, sun) * diffuse, diffuse
