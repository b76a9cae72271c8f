"""What is said about the light of a scene, by a caller, sky.toml and amc.inp, and which of them wins."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Mapping
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
from aomc_sky.formats.sky_toml.sections import PerezSection, SunSection, perez_section
from aomc_sky.inputs import INPUTS, LIGHTS, MODEL, Entrance
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


def replaced_notes(given: LightInputs, below: LightInputs, *, is_true: bool) -> tuple[str, ...]:
    """Notes on inputs of files that a time, a place or a weather file replaces; `is_true`: by the unrefracted sun."""
    weather, before = given.weather, below.sun
    if weather is None:
        return ()
    zenith = weather.true_zenith_deg if is_true else weather.sun_zenith_deg
    text = (
        f"{weather.origin}: the sun at a zenith angle of {zenith:.4f} and an azimuth of "
        f"{weather.sun_azimuth_deg:.4f} degrees, not at {before.zenith_deg:g} and {before.azimuth_deg:g} as in "
        f"{before.origin}"
    )
    if weather.irradiances and below.amounts.has_set:
        return (text, f"{weather.origin}: its irradiances take the place of [perez] in {SKY_TOML}")
    return (text,)
