"""What is said about the light of a scene, by a caller, sky.toml and amc.inp: which of them wins, and when it is used.

What a caller gives and the scene cannot use is an error; what sky.toml says beyond that is a note.
"""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import (
    MOON_KEYS,
    RULES,
    SKY_TOML,
    SPECTRL2,
    moon_problem,
    plain_number,
    set_problem,
    value_problem,
)
from aomc_sky.formats.sky_toml.sections import PerezSection, SkyToml, SunSection, perez_section
from aomc_sky.inputs import CLEAR_SKY, INPUTS, LIGHTS, MODEL, Entrance
from aomc_sky.skies.model import require_pattern
from aomc_sky.source.light.sun import Sun

if TYPE_CHECKING:
    from aomc_sky.formats.aomc.amc import DifcolTable
    from aomc_sky.formats.sky_toml.sections import SkyToml
    from aomc_sky.skies.polarisation import RayleighPattern
    from aomc_sky.source.light.weather import Weather

#: Choices of `aomc_sky.PerezSky`, the default first.
MODEL_CHOICES = {name: row.words for name, row in MODEL.items() if row.words}
FOR_IRRADIANCES = ("air_mass", "extraterrestrial_normal")  #: Only from irradiances to epsilon and Delta.
OPTIONS = "options"  #: The origin of what a caller says.


class Unsaid(enum.Enum):
    """What it means that nothing says how bright the beam is."""

    ERROR = "error"  #: a person filled in an amc.inp that promises a sun
    WHOLE = "whole"  #: the sky is the whole light
    WARNING = "warning"  #: a sun was named and is missing


@dataclass(frozen=True, kw_only=True, slots=True)
class LightInputs:
    """Sun, amounts and spectrum of the light; what is not said is None or empty.

    One record of a caller, one of sky.toml, one of amc.inp: `over` joins them.
    """

    entrance: Entrance = Entrance.OPTIONS
    sun: SunSection = field(default_factory=SunSection)
    amounts: PerezSection = field(default_factory=PerezSection)  #: with the spectrum
    model: Mapping[str, Any] = field(default_factory=dict)  #: further arguments of `PerezSky`
    clear_sky: Mapping[str, float] = field(default_factory=dict)
    lights: Mapping[str, float] = field(default_factory=dict)  #: the Moon and the glow of the ground
    weather: Weather | None = None  #: what `sun` and, of a file, `amounts` were made of
    diffuse_only: bool = False
    polarisation: RayleighPattern | None = None  #: of the sky's light, around the sun
    shares: DifcolTable | None = None  #: of difcol.inp
    #: irradiances of beam and sky on a horizontal plane, (n_band,), of [sky] [W m-2 nm-1]
    direct_irradiance: tuple[float, ...] | None = None
    diffuse_irradiance: tuple[float, ...] | None = None

    @property
    def spectrum(self) -> str | None:
        """How beam and sky share each waveband."""
        return self.amounts.spectrum

    @property
    def has_amounts(self) -> bool:
        """Whether irradiances, or epsilon and delta, say how bright sun and sky are."""
        return self.amounts.has_irradiances or self.amounts.epsilon is not None

    @property
    def is_cloudless(self) -> bool:
        """Whether the light is that of a cloudless sky."""
        if self.spectrum != SPECTRL2:
            return False
        return not (self.has_amounts or self.shares is not None or self.has_both_irradiances)

    @property
    def has_both_irradiances(self) -> bool:
        """Whether the irradiances of beam and sky are known for every waveband."""
        return self.direct_irradiance is not None and self.diffuse_irradiance is not None

    @property
    def has_broadband(self) -> bool:
        """Whether a Perez sky follows from irradiances, which a cloudless sky has too."""
        return self.amounts.has_irradiances or (self.is_cloudless and not self.amounts.has_set)

    @property
    def is_of_file(self) -> bool:
        """Whether the irradiances are those of an hour of a weather file."""
        return self.weather is not None and self.weather.path is not None

    @property
    def names(self) -> list[str]:
        """The inputs that were given."""
        perez = [name for name in ("dni", "dhi", "ghi", "epsilon", "delta") if getattr(self.amounts, name) is not None]
        perez += ["coefficients"] * (self.amounts.coefficients is not None)
        if self.is_of_file:
            perez = []  # the name of the file stands for them, below
        sun = [name for name in ("zenith_deg", "azimuth_deg", "disc") if getattr(self.sun, name) is not None]
        if self.weather is not None:
            sun = [*self.weather.names, *(name for name in sun if name == "disc")]
        spectrum = ["spectrum"] * (self.spectrum is not None)
        alone = ["diffuse_only"] * self.diffuse_only + ["polarisation"] * (self.polarisation is not None)
        return [*perez, *spectrum, *sun, *self.model, *self.clear_sky, *self.lights, *alone]

    def listed(self, names: Iterable[str]) -> str:
        """Names of inputs, joined by "and"; a switch that is turned off in its own word."""
        off = {"disc": "disc:False"} if self.sun.disc is False else {}
        return " and ".join(dict.fromkeys(self.say(f"{{{off.get(name, name)}}}") for name in names))

    def say(self, text: str) -> str:
        """A text with the names of inputs as the caller wrote them."""
        return self.entrance.say(text)

    def over(self, below: LightInputs) -> LightInputs:
        """What this says, and else the other."""
        amounts = self.amounts if self.amounts.has_set else below.amounts
        mine = (self.direct_irradiance, self.diffuse_irradiance)
        with_irradiances = self if any(one is not None for one in mine) else below
        if below.has_both_irradiances and (self.has_amounts or self.is_cloudless):
            with_irradiances = self  # two answers to one question: the first counts
        return dataclasses.replace(
            self,
            sun=self.sun.over(below.sun),
            amounts=dataclasses.replace(amounts, spectrum=self.spectrum or below.spectrum),
            clear_sky={**below.clear_sky, **self.clear_sky},
            polarisation=self.polarisation or below.polarisation,
            shares=self.shares or below.shares,
            direct_irradiance=with_irradiances.direct_irradiance,
            diffuse_irradiance=with_irradiances.diffuse_irradiance,
        )

    @property
    def perez_choices(self) -> dict[str, Any]:
        """Arguments of `PerezSky` beside the amounts, with their defaults."""
        choices = {name: allowed[0] for name, allowed in MODEL_CHOICES.items()} | dict(self.model)
        if not self.has_broadband:
            return {name: value for name, value in choices.items() if name not in FOR_IRRADIANCES}
        if self.weather is not None:
            choices.setdefault("extraterrestrial_normal", self.weather.extraterrestrial_normal)
        return choices

    def refuse_set_sun(self) -> None:
        """Raise for a sun below the horizon where no atmosphere can be asked for."""
        zenith = self.sun.zenith_deg
        if self.weather is None and zenith is not None and not 0 <= zenith < 90:
            raise SceneError(f"a sky needs the sun above the horizon, 0 to below 90 degrees, got {zenith:g}")

    def scene_sun(self, sky: str, *, may_have_set: bool = False) -> Sun:
        """The sun; an error where nothing says where it is, or where it has set, in which case `sky` is dark."""
        weather = self.weather
        if weather is not None and not may_have_set:
            weather.require_sun()
        zenith = self.sun.zenith_deg
        if zenith is None:
            raise UsageError(
                self.say(
                    f"where is the sun? {sky} needs {{zenith_deg}} (and {{azimuth_deg}} unless it is 0), or {{time}}, "
                    "{latitude_deg} and {longitude_deg}"
                )
            )
        if zenith >= 90.0 and not may_have_set and self.sun.origin != "amc.inp":
            raise UsageError(
                f"zenith_deg: {zenith:g} ({self.sun.origin}) is outside the range 0 to below 90; a sun that has set "
                "needs [atmosphere]"
            )
        constant = self.perez_choices.get("extraterrestrial_normal")
        outside = {} if constant is None else {"extraterrestrial_normal": float(constant)}
        return Sun(
            zenith_deg=zenith,
            azimuth_deg=self.sun.azimuth_deg or 0.0,
            disc=bool(self.sun.disc),
            origin=self.sun.origin,
            distance_factor=None if weather is None else weather.distance_factor,
            polarisation=self.polarisation,
            **outside,
        )


def inputs_of_toml(toml: SkyToml) -> LightInputs:
    """What sky.toml says."""
    return LightInputs(
        sun=toml.sun,
        amounts=toml.perez,
        clear_sky=toml.clear_sky,
        polarisation=None if toml.sky.polarisation is None else rayleigh_pattern(toml.sky.polarisation),
        direct_irradiance=toml.sky.direct_irradiance,
        diffuse_irradiance=toml.sky.diffuse_irradiance,
    )


def rayleigh_pattern(max_degree: float) -> RayleighPattern:
    """The pattern of a largest degree; its module is loaded where polarisation is asked for."""
    from aomc_sky.skies.polarisation import RayleighPattern

    return RayleighPattern(max_degree=max_degree)


def given_inputs(
    entrance: Entrance,
    *,
    perez: Mapping[str, Any] | None = None,
    sun: Mapping[str, Any] | None = None,
    within: str | None = None,
    atmosphere: Mapping[str, Any] | None = None,
    weather: Mapping[str, Any] | None = None,
    clear_sky: Any = None,
    diffuse_only: bool = False,
    polarisation: Any = None,
) -> LightInputs:
    """Check the inputs of a caller; a value None is left out.

    `perez` has keys of [perez] and `MODEL`, `sun` those of [sun], `weather` those of `MOMENT`; `clear_sky` is a mapping
    or a `ClearSky`. A time or a weather file replaces the sun's angles, and a file also the amounts.
    """
    moment, origin = None, OPTIONS
    if any(value is not None for value in (weather or {}).values()):
        from aomc_sky.source.light.weather import weather_of

        moment = weather_of(weather, entrance, perez, sun)
    if moment is not None:
        angles = {"zenith_deg": moment.sun_zenith_deg, "azimuth_deg": moment.sun_azimuth_deg}
        perez, sun = {**(perez or {}), **moment.irradiances}, {**(sun or {}), **angles}
        origin = moment.origin
    values = {name: value for name, value in {**(perez or {}), "within": within}.items() if value is not None}
    model = _checked("model", {name: values.pop(name) for name in MODEL if name in values}, entrance)
    if moment is not None and "extraterrestrial_normal" in model:
        model["extraterrestrial_normal"] *= moment.distance_factor
    perez_keys, position = _checked("perez", values, entrance), _checked("sun", sun or {}, entrance)
    message, advice = set_problem(list(perez_keys))
    if message:
        raise UsageError(f"how bright are sun and sky? {message}; {advice}")
    amounts = dataclasses.replace(
        perez_section(perez_keys), origin=origin if moment is not None and moment.path is not None else OPTIONS
    )
    if dataclasses.is_dataclass(clear_sky) and not isinstance(clear_sky, type):
        clear_sky = dataclasses.asdict(clear_sky)
    if clear_sky is not None and not isinstance(clear_sky, Mapping):
        raise UsageError(f"clear_sky must be a ClearSky(...) or a mapping, got {clear_sky!r}")
    if not isinstance(diffuse_only, (bool, np.bool_)):
        raise UsageError(f"diffuse_only must be True or False, got {diffuse_only!r}")
    require_pattern(polarisation)
    return LightInputs(
        entrance=entrance,
        sun=SunSection(**position, origin=origin),
        amounts=amounts,
        model=model,
        lights=given_lights(atmosphere, entrance),
        clear_sky=_checked("clear_sky", clear_sky or {}, entrance),
        weather=moment,
        diffuse_only=bool(diffuse_only),
        polarisation=polarisation,
    )


def given_lights(given: Mapping[str, Any] | None, entrance: Entrance = Entrance.OPTIONS) -> dict[str, float]:
    """Checked keys of [atmosphere] for the Moon and the glow of the ground; a value None is left out."""
    values = {name: value for name, value in (given or {}).items() if value is not None}
    for name in values:
        if name not in LIGHTS:
            raise UsageError(f"atmosphere has no input {name!r}; the inputs are {', '.join(LIGHTS)}")
    message, advice = moon_problem([name for name in values if name in MOON_KEYS and name != "moon_distance_km"])
    if message:
        raise UsageError(f"the Moon: {message}; {advice}")
    return _checked("atmosphere", values, entrance)


def _checked(section: str, values: Mapping[str, Any], entrance: Entrance) -> dict[str, Any]:
    good: dict[str, Any] = {}
    for name, value in values.items():
        if name not in RULES[section]:
            raise UsageError(f"{section} has no input {name!r}; the inputs are {', '.join(RULES[section])}")
        if isinstance(value, np.bool_):
            value = bool(value)
        value = plain_number(value)
        if value is not None:
            _, message, advice = value_problem(section, name, value)
            if message:
                is_renamed = section == "sun" and entrance is Entrance.KEYWORDS
                keyword = INPUTS[name].keyword if is_renamed else ""
                raise UsageError(f"{keyword or name}: {message}; {advice}")
            good[name] = value
    return good


def replaced_notes(given: LightInputs, toml: LightInputs, amc: LightInputs, *, is_true: bool) -> tuple[str, ...]:
    """Notes on inputs of files that a time, a place or a weather file replaces; `is_true`: by the unrefracted sun."""
    weather = given.weather
    if weather is None:
        return ()
    before = toml.sun.over(amc.sun)
    zenith = weather.true_zenith_deg if is_true else weather.sun_zenith_deg
    text = (
        f"{weather.origin}: the sun at a zenith angle of {zenith:.4f} and an azimuth of "
        f"{weather.sun_azimuth_deg:.4f} degrees, not at {before.zenith_deg:g} and {before.azimuth_deg:g} as in "
        f"{before.origin}"
    )
    if weather.irradiances and toml.amounts.has_set:
        return (text, f"{weather.origin}: its irradiances take the place of [perez] in {SKY_TOML}")
    return (text,)


# When each input is used.

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
    _Rule(names=("spectrum", "disc", *CLEAR_SKY),
          is_idle=lambda use: use.sky == "perez" and use.unsaid is Unsaid.WHOLE and not use.inputs.has_both_irradiances,
          reason="all light is diffuse where the Perez sky replaces skydist.inp; leave it out"),
    _Rule(names=_SUN, is_idle=lambda use: not (use.takes_sun or use.is_dim) and use.inputs.diffuse_only,
          reason="the beam is left out, and {it} needs no sun; leave it out"),
    _Rule(names=_SUN, is_idle=lambda use: not use.takes_sun and use.is_dim,
          reason="all light comes from {it}; write {sky:perez} for another sky, or two of {dni}, {dhi} and {ghi} for a "
                 "beam beside it"),
    _Rule(names=("azimuth_deg",),
          is_idle=lambda use: (
              use.inputs.sun.zenith_deg is None and use.is_dim and not use.is_file and use.sky != "perez"
          ),
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
            names, reason = given.listed(idle), rule.reason.replace("{it}", use.words)
            if "{names}" in reason:
                raise UsageError(reason.replace("{names}", names))
            raise UsageError(f"{names}: {given.say(reason)}")


def unused_notes(toml: SkyToml, use: Use, *, named_sky: str | None) -> tuple[str, ...]:
    """Notes on what sky.toml says and the scene does not use; `named_sky` is the sky that is modelled."""
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
