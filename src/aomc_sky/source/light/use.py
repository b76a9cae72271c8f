"""When each input of the light is used: what a caller gives beyond that is an error, what sky.toml says a note."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from aomc_sky.errors import UsageError
from aomc_sky.formats.sky_toml.sections import SkyToml
from aomc_sky.inputs import CLEAR_SKY, LIGHTS
from aomc_sky.source.light.inputs import FOR_IRRADIANCES, LightInputs, Unsaid

_AMOUNTS = ("dni", "dhi", "ghi", "epsilon", "delta", "epw", "tmy2", "tmy3")
_PEREZ = ("coefficients", "limits", "within", "air_mass")
_SUN = ("zenith_deg", "azimuth_deg", "disc", "time", "latitude_deg", "longitude_deg", "altitude_m", "row")


@dataclass(frozen=True, kw_only=True, slots=True)
class Use:
    """What a scene is made of, as far as it decides which inputs of the light are used."""

    inputs: LightInputs
    sky: str  #: "perez", "table", "field", "atmosphere", "none", or another name
    words: str  #: the sky for a person
    unsaid: Unsaid  #: what it means that nothing says how bright the beam is
    is_compat: bool = False
    is_file: bool = False  #: whether the sky is the light of a file that was named alone
    takes_sun: bool = True  #: whether the sun matters without a beam
    is_sunless: bool = False  #: whether the sky is the same under any sun

    @property
    def has_difcol(self) -> bool:
        """Whether difcol.inp says how direct each waveband is."""
        return self.inputs.shares is not None

    @property
    def is_dim(self) -> bool:
        """Whether nothing says how bright the beam is."""
        known = (self.inputs.shares, self.inputs.direct_irradiance)
        return not (self.inputs.has_amounts or self.inputs.is_cloudless or any(one is not None for one in known))

    @property
    def is_half_a_sun(self) -> bool:
        """Whether nothing says how high the sun stands, and nothing asks for it."""
        return self.inputs.sun.zenith_deg is None and self.is_dim and not self.is_file and self.sky != "perez"

    @property
    def is_perez_for_file(self) -> bool:
        """Whether the Perez sky takes the place of skydist.inp, where irradiances say its shape alone."""
        return self.sky == "perez" and self.unsaid is Unsaid.WHOLE and not self.inputs.has_both_irradiances


@dataclass(frozen=True, kw_only=True, slots=True)
class _Rule:
    names: tuple[str, ...]
    is_idle: Callable[[Use], bool]
    reason: str  #: with {it} for the sky


_EVERY = (
    *_AMOUNTS, *_PEREZ, "extraterrestrial_normal", "spectrum", "diffuse_only", "polarisation", *_SUN, *CLEAR_SKY
)  # fmt: skip
_BROADBAND = (*_AMOUNTS, *_PEREZ, "extraterrestrial_normal", "spectrum", *CLEAR_SKY)
_RULES = (
    _Rule(names=_EVERY, is_idle=lambda use: use.is_compat, reason="--compat aomc does not use {names}"),
    _Rule(names=tuple(LIGHTS), is_idle=lambda use: use.sky != "atmosphere",
          reason="used only with [atmosphere] in sky.toml"),
    _Rule(names=_EVERY, is_idle=lambda use: use.sky == "none", reason='not used without sun and sky (model "none")'),
    _Rule(names=_BROADBAND, is_idle=lambda use: use.sky == "atmosphere",
          reason="not used with [atmosphere] in sky.toml, which says how bright sun and sky are; write {sky:perez} "
                 "to use it"),
    _Rule(names=("polarisation",), is_idle=lambda use: use.is_sunless, reason="{it} has no sun for Rayleigh's pattern; "
          "leave it out, or take a sky with a sun: {sky:perez}, {sky:cie} or {sky:harrison-coombes}"),
    _Rule(names=("spectrum", *CLEAR_SKY), is_idle=lambda use: use.has_difcol,
          reason="difcol.inp gives the direct fraction of every waveband; leave one of them out"),
    _Rule(names=_PEREZ, is_idle=lambda use: use.sky != "perez",
          reason="of the Perez sky, not of {it}; leave it out"),
    _Rule(names=_AMOUNTS, is_idle=lambda use: use.has_difcol and use.sky != "perez",
          reason="difcol.inp says how direct every waveband is, and {it} needs no more; leave it out"),
    _Rule(names=FOR_IRRADIANCES, is_idle=lambda use: not use.inputs.has_broadband,
          reason="used only with two of {dni}, {dhi} and {ghi}, which are not given"),
    _Rule(names=("extraterrestrial_normal",), is_idle=lambda use: use.sky != "perez",
          reason="of the Perez sky, not of {it}; leave it out"),
    _Rule(names=("limits",), is_idle=lambda use: use.inputs.amounts.coefficients is not None,
          reason="limits of clearness and brightness, of which {coefficients} take the place"),
    _Rule(names=tuple(CLEAR_SKY), is_idle=lambda use: not use.inputs.is_cloudless,
          reason="used only for a cloudless sky: {spectrum:spectrl2} without irradiances"),
    _Rule(names=("spectrum", "disc", *CLEAR_SKY), is_idle=lambda use: use.is_perez_for_file,
          reason="all light is diffuse where the Perez sky replaces skydist.inp; leave it out"),
    _Rule(names=_SUN, is_idle=lambda use: not use.takes_sun and (use.is_dim or use.inputs.diffuse_only),
          reason="all light comes from {it}; write {sky:perez} for another sky, or two of {dni}, {dhi} and {ghi} for a "
                 "beam beside it"),
    _Rule(names=("azimuth_deg",), is_idle=lambda use: use.is_half_a_sun,
          reason="where is the sun? it needs {zenith_deg} too"),
    _Rule(names=("disc",), is_idle=lambda use: use.inputs.diffuse_only, reason="the beam is left out"),
    _Rule(names=("disc", "spectrum"), is_idle=lambda use: use.unsaid is not Unsaid.ERROR and use.is_dim,
          reason="used only where something says how bright the beam is"),
    _Rule(names=("spectrum",), is_idle=lambda use: use.inputs.has_both_irradiances,
          reason="direct_irradiance and diffuse_irradiance of sky.toml say how direct every waveband is; leave it out"),
)  # fmt: skip
"""Rules in order: the first that fits says why an input is not used."""


def refuse_unused(given: LightInputs, use: Use) -> None:
    """Raise for what a caller gives and the scene cannot use, in the caller's words."""
    names_given = given.names
    for rule in _RULES:
        idle = [name for name in names_given if name in rule.names]
        if idle and rule.is_idle(use):
            names, reason = given.entrance.listed(idle), rule.reason.replace("{it}", use.words)
            if "{names}" in reason:
                raise UsageError(reason.replace("{names}", names))
            raise UsageError(f"{names}: {given.say(reason)}")


def unused_notes(toml: SkyToml | None, use: Use, *, named_sky: str | None) -> tuple[str, ...]:
    """Notes on what sky.toml says and the scene does not use; `named_sky` is the sky that is modelled."""
    if toml is None:
        return ()
    notes = []
    has_sun_or_sky = not toml.sun.is_empty or not toml.perez.is_empty
    if use.sky == "table" and not use.is_dim:
        if not toml.perez.is_empty:
            notes.append("sky.toml: [perez] is not used beside skydist.inp")
    elif use.sky == "table" and has_sun_or_sky:
        what = "sky.toml:" if toml.sky.is_empty and not toml.background else "sky.toml: [perez] and [sun]"
        notes.append(f"{what} not used, all light comes from skydist.inp (--sky perez takes a sky model instead)")
    elif use.sky == "none" and has_sun_or_sky:
        notes.append("sky.toml: [perez] and [sun] are not used, neither sun nor daylight is modelled")
    elif use.sky != "perez" and use.has_difcol and not toml.perez.is_empty:
        notes.append("sky.toml: [perez] is not used, no Perez sky is modelled")
    elif use.sky != "perez" and use.inputs.has_both_irradiances and not toml.perez.is_empty:
        notes.append("sky.toml: [perez] is not used, [sky] says how direct every waveband is")
    both = (toml.sky.direct_irradiance, toml.sky.diffuse_irradiance)
    if use.sky not in ("atmosphere", "none") and None not in both and not use.inputs.has_both_irradiances:
        notes.append("sky.toml: direct_irradiance and diffuse_irradiance are not used, options say how bright both are")
    if toml.perez.spectrum is not None and use.has_difcol:
        notes.append("sky.toml: spectrum is not used, difcol.inp gives the direct fraction of every waveband")
    elif toml.perez.spectrum is not None and use.inputs.has_both_irradiances and use.sky == "perez":
        notes.append("sky.toml: spectrum is not used, [sky] says how direct every waveband is")
    if toml.clear_sky and not use.inputs.is_cloudless:
        notes.append("sky.toml: [clear_sky] is not used, the light is not that of a cloudless sky (spectrum spectrl2)")
    if toml.sky.options and toml.sky.model != named_sky:
        unused = " and ".join(option.name for option in toml.sky.options)
        notes.append(f"sky.toml: {unused} of [sky] is not used, another sky than {toml.sky.model!r} is asked for")
    if toml.sky.polarisation is not None and (use.is_sunless or use.sky == "none"):
        notes.append(f"sky.toml: polarisation is not used, {use.words} has no sun")
    if toml.sky.table is not None and use.sky != "field":
        notes.append("sky.toml: table is not used, another sky is asked for")
    if toml.atmosphere is not None and use.sky != "atmosphere":
        notes.append("sky.toml: [atmosphere] is not used, another sky is asked for")
    return tuple(notes)
