"""Inputs of the Perez sky and of the sun in order of precedence, and their shares of beam and sky.

Options win over sky.toml, sky.toml over difcol.inp and amc.inp.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import InputWarning, ModelLimitWarning, SceneError, UsageError
from aomc_sky.formats.aomc.amc import AmcConfig, DifcolTable
from aomc_sky.formats.sky_toml.file import SkyToml
from aomc_sky.formats.sky_toml.keys import (
    MOON_KEYS,
    RULES,
    PerezSection,
    SunSection,
    moon_problem,
    perez_section,
    set_problem,
    value_problem,
)
from aomc_sky.formats.text_file import refuse
from aomc_sky.inputs import LIGHTS, MODEL

if TYPE_CHECKING:
    from aomc_sky.source.light.weather import Weather

#: Choices of `aomc_sky.PerezSky`, the default first.
MODEL_CHOICES = {name: row.words for name, row in MODEL.items() if row.words}
DIFCOL = "difcol.inp"  #: The name under which difcol.inp is the origin of something.
FOR_IRRADIANCES = ("air_mass", "extraterrestrial_normal")  #: Only from irradiances to epsilon and Delta.

#: Median sky brightness of each bin of clearness in 15 900 hours (Z < 85 degrees) of four public weather files.
MEDIAN_DELTA = (0.18, 0.30, 0.31, 0.29, 0.25, 0.18, 0.14, 0.09)

_THREE_LINES = (
    "[perez]\ndni = 850.0    # direct normal irradiance, W m-2\ndhi = 95.0     # diffuse horizontal irradiance, W m-2"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class GivenInputs:
    """Inputs from options or arguments; a missing one is None or an empty section."""

    perez: PerezSection = field(default_factory=PerezSection)
    sun: SunSection = field(default_factory=SunSection)
    model: Mapping[str, Any] = field(default_factory=dict)
    lights: Mapping[str, float] = field(default_factory=dict)
    weather: Weather | None = None  #: what `sun` and, of a file, `perez` were made of

    @property
    def origin(self) -> str:
        """Who gave these."""
        return "options" if self.weather is None else self.weather.origin

    @property
    def names(self) -> list[str]:
        """Given inputs, for messages; the law inside a patch is left out, because every sky has it."""
        parts = {
            "Perez inputs": self.perez.has_set,
            "spectrum": self.perez.spectrum is not None,
            "the sun": not self.sun.is_empty,
        }
        return [*(name for name, is_given in parts.items() if is_given), *self.model_names]

    @property
    def model_names(self) -> list[str]:
        """Choices of the Perez sky that were given."""
        return [name for name in self.model if name != "within"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Sun:
    """The sun: `zenith_deg` [0 to 90), `azimuth_deg` from +x towards +y, `disc`, and who said so."""

    zenith_deg: float
    azimuth_deg: float
    disc: bool = False
    origin: str = "amc.inp"
    #: on a plane that faces the sun outside the air, as in skies/perez, which scenes of tables do not load [W m-2]
    extraterrestrial_normal: float = 1361.1

    @property
    def cosine(self) -> float:
        """Cosine of the zenith angle."""
        return float(sin_cos_deg(self.zenith_deg)[1])

    def as_options(self) -> dict[str, Any]:
        """JSON values for a manifest."""
        return {
            "zenith_deg": self.zenith_deg,
            "azimuth_deg": self.azimuth_deg,
            "disc": self.disc,
            "from": self.origin,
        }


@dataclass(frozen=True, kw_only=True, slots=True)
class PerezInputs:
    """The complete set of inputs in use; `origin` is its source, `text` describes it for a person."""

    section: PerezSection
    origin: str
    text: str

    def __str__(self) -> str:
        return f"{self.text} ({self.origin})"


def given_inputs(
    perez: Mapping[str, Any] | None,
    sun: Mapping[str, Any] | None,
    within: str | None,
    atmosphere: Mapping[str, Any] | None = None,
    weather: Mapping[str, Any] | None = None,
) -> GivenInputs:
    """Check the inputs of a caller; a value None is left out.

    `perez` has keys of [perez] and `MODEL`, `sun` those of [sun]; `atmosphere` is as for `given_lights`, `weather` as
    for `weather_of`. A time or a weather file replaces the sun's angles, and a file also the Perez inputs.
    """
    moment = None
    if any(value is not None for value in (weather or {}).values()):
        from aomc_sky.source.light.weather import weather_of

        moment = weather_of(weather, perez, sun)
    if moment is not None:
        angles = {"zenith_deg": moment.sun_zenith_deg, "azimuth_deg": moment.sun_azimuth_deg}
        perez, sun = {**(perez or {}), **moment.irradiances}, {**(sun or {}), **angles}
    values = {name: value for name, value in {**(perez or {}), "within": within}.items() if value is not None}
    model = {name: values.pop(name) for name in MODEL if name in values}
    model = _checked("model", model)
    if moment is not None and "extraterrestrial_normal" in model:
        model["extraterrestrial_normal"] *= moment.distance_factor
    perez_keys, position = _checked("perez", values), _checked("sun", sun or {})
    message, advice = set_problem(list(perez_keys))
    if message:
        raise UsageError(f"the Perez sky: {message}; {advice}")
    return GivenInputs(
        perez=perez_section(perez_keys),
        sun=SunSection(**position),
        model=model,
        lights=given_lights(atmosphere),
        weather=moment,
    )


def given_lights(given: Mapping[str, Any] | None) -> dict[str, float]:
    """Checked keys of [atmosphere] for the Moon and the glow of the ground; a value None is left out."""
    values = {name: value for name, value in (given or {}).items() if value is not None}
    for name in values:
        if name not in LIGHTS:
            raise UsageError(f"atmosphere has no input {name!r}; the inputs are {', '.join(LIGHTS)}")
    message, advice = moon_problem([name for name in values if name in MOON_KEYS and name != "moon_distance_km"])
    if message:
        raise UsageError(f"the Moon: {message}; {advice}")
    return _checked("atmosphere", values)


def _checked(section: str, values: Mapping[str, Any]) -> dict[str, Any]:
    good: dict[str, Any] = {}
    for name, value in values.items():
        if name not in RULES[section]:
            raise UsageError(f"{section} has no input {name!r}; the inputs are {', '.join(RULES[section])}")
        if isinstance(value, np.bool_):
            value = bool(value)
        elif isinstance(value, Real) and not isinstance(value, bool):
            value = float(value)
        if value is not None:
            _, message, advice = value_problem(section, name, value)
            if message:
                raise UsageError(f"{name}: {message}; {advice}")
            good[name] = value
    return good


def resolve_sun(config: AmcConfig, toml: SunSection, given: SunSection, who: str = "options") -> Sun:
    """The sun: each of zenith angle, azimuth and disc from the first of `who`, sky.toml, amc.inp that has it."""
    file = SunSection(
        zenith_deg=float(config.direct_zenith_deg), azimuth_deg=float(config.direct_azimuth_deg), disc=False
    )
    sources = ((who, given), ("sky.toml", toml), ("amc.inp", file))
    values: dict[str, Any] = {}
    origins: dict[str, None] = {}
    for name in ("zenith_deg", "azimuth_deg", "disc"):
        origin, value = next((o, getattr(s, name)) for o, s in sources if getattr(s, name) is not None)
        values[name] = value
        if name != "disc":
            origins[origin] = None
    return Sun(**values, origin=" and ".join(origins))


def choose_perez(toml: PerezSection, given: PerezSection, who: str = "options") -> PerezInputs | None:
    """The set of inputs from `who`, or else from sky.toml, or None."""
    section, origin = (given, who) if given.has_set else (toml, "sky.toml")
    if not section.has_set:
        return None
    if section.coefficients is not None:
        text = f"coefficients {', '.join(f'{c:g}' for c in section.coefficients)}"
    elif section.epsilon is not None:
        text = f"epsilon {section.epsilon:g} and Delta {section.delta:g}"
    else:
        named = (("ghi", section.ghi), ("dni", section.dni), ("dhi", section.dhi))
        *others, last = [f"{name} {value:g}" for name, value in named if value is not None]
        text = f"{', '.join(others)} and {last} W m-2"
    return PerezInputs(section=section, origin=origin, text=text)


@dataclass(frozen=True, kw_only=True, slots=True)
class SkyInputs:
    """Everything beside difcol.inp that shapes the light of a sky model."""

    sun: Sun
    perez: PerezInputs | None = None  #: without one, difcol.inp alone
    #: further arguments of `PerezSky`: limits, within; with irradiances also air_mass, extraterrestrial_normal
    model: Mapping[str, Any] = field(default_factory=dict)
    spectrum: str | None = None  #: how beam and sky share each waveband without difcol.inp
    is_of_file: bool = False  #: whether the irradiances are those of an hour of a weather file
    notes: tuple[str, ...] = ()  #: inputs that a time, a place or a weather file replaces


def sky_inputs(config: AmcConfig, toml: SkyToml, given: GivenInputs) -> SkyInputs:
    """Join the inputs by their precedence."""
    weather = given.weather
    if weather is not None:
        weather.require_sun()
    of_file = weather is not None and weather.path is not None
    perez = choose_perez(toml.perez, given.perez, given.origin if of_file else "options")
    choices = {name: allowed[0] for name, allowed in MODEL_CHOICES.items()} | dict(given.model)
    if perez is None or not perez.section.has_irradiances:
        idle = [name for name in FOR_IRRADIANCES if name in given.model]
        if idle:
            raise UsageError(f"{' and '.join(idle)}: used only with two of dni, dhi and ghi, which are not given")
        choices = {name: value for name, value in choices.items() if name not in FOR_IRRADIANCES}
    elif weather is not None:
        choices.setdefault("extraterrestrial_normal", weather.extraterrestrial_normal)
    sun = resolve_sun(config, toml.sun, given.sun, given.origin)
    if sun.zenith_deg >= 90.0 and sun.origin != "amc.inp":
        raise UsageError(
            f"zenith_deg: {sun.zenith_deg:g} ({sun.origin}) is outside the range 0 to below 90; a sun that has set "
            "needs [atmosphere]"
        )
    if perez is not None:
        refuse_kilowatts(perez, sun)
    sun = replace(sun, extraterrestrial_normal=choices.get("extraterrestrial_normal", sun.extraterrestrial_normal))
    spectrum = given.perez.spectrum or toml.perez.spectrum
    notes = () if weather is None else _replaced(config, toml, weather)
    return SkyInputs(sun=sun, perez=perez, model=choices, spectrum=spectrum, is_of_file=of_file, notes=notes)


def refuse_kilowatts(inputs: PerezInputs, sun: Sun) -> None:
    """Raise if irradiances are probably in kW m-2."""
    from aomc_sky.skies.perez.irradiances import kilowatts

    section = inputs.section
    if text := kilowatts((section.ghi, section.dni, section.dhi), sun.zenith_deg):
        raise SceneError(f"{inputs}: {text}")


def _replaced(config: AmcConfig, toml: SkyToml, weather: Weather) -> tuple[str, ...]:
    """Notes on inputs that a time, a place or a weather file replaces."""
    before = resolve_sun(config, toml.sun, SunSection())
    text = (
        f"{weather.origin}: the sun at a zenith angle of {weather.sun_zenith_deg:.4f} and an azimuth of "
        f"{weather.sun_azimuth_deg:.4f} degrees, not at {before.zenith_deg:g} and {before.azimuth_deg:g} as in "
        f"{before.origin}"
    )
    if weather.irradiances and toml.perez.has_set:
        return (text, f"{weather.origin}: its irradiances take the place of [perez] in sky.toml")
    return (text,)


def direct_fraction(inputs: PerezInputs, sun: Sun) -> float | None:
    """Share of the beam, dni cos Z / (dni cos Z + dhi); or None with coefficients alone. [0 to 1]"""
    section = inputs.section
    if section.coefficients is not None:
        return None
    if section.epsilon is not None:
        from aomc_sky.skies.perez.coefficients import beam_ratio

        beam, diffuse = beam_ratio(section.epsilon, math.radians(sun.zenith_deg)) * sun.cosine, 1.0
    else:
        normal, diffuse = irradiances(inputs, sun)
        beam = normal * sun.cosine
    if beam + diffuse == 0:
        raise SceneError(f"{inputs} leave no light at all")
    return 1.0 if beam + diffuse == math.inf else beam / (beam + diffuse)


def irradiances(inputs: PerezInputs, sun: Sun) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance; of epsilon and Delta at the sun's mean distance. [W m-2]"""
    from aomc_sky.skies.perez.irradiances import closed_irradiances

    section = inputs.section
    if section.epsilon is None:
        return closed_irradiances(
            ghi=section.ghi,
            dni=section.dni,
            dhi=section.dhi,
            sun_zenith_deg=sun.zenith_deg,
            extraterrestrial_normal=sun.extraterrestrial_normal,
        )
    from aomc_sky.skies.perez.coefficients import beam_ratio, sky_brightness

    zenith = math.radians(sun.zenith_deg)
    diffuse = (section.delta or 0.0) / float(sky_brightness(1.0, zenith))
    return beam_ratio(section.epsilon, zenith) * diffuse, diffuse


def model_inputs(inputs: PerezInputs, sun: Sun) -> dict[str, Any]:
    """Arguments of `PerezSky`: coefficients, epsilon and delta, or dni and dhi."""
    from aomc_sky.skies.perez.irradiances import dhi_exceeds_ghi

    section = inputs.section
    if section.coefficients is not None:
        return {"coefficients": section.coefficients}
    if section.epsilon is not None:
        return {"epsilon": section.epsilon, "delta": section.delta}
    direct, diffuse = irradiances(inputs, sun)
    if diffuse == 0:
        raise SceneError(
            f"{inputs} leave no light for the sky, but bands have diffuse light; give a "
            "positive diffuse irradiance, or direct fractions of 1"
        )
    if is_exceeded := dhi_exceeds_ghi(section.ghi, section.dni, section.dhi):
        warnings.warn(is_exceeded, ModelLimitWarning, stacklevel=2)
    return {"dni": direct, "dhi": diffuse}


def difcol_of_inputs(inputs: PerezInputs | None, sun: Sun, path: str, n_wavebands: int) -> DifcolTable:
    """Substitute for a missing difcol.inp: one direct fraction, intensity 1."""
    fraction = None if inputs is None else direct_fraction(inputs, sun)
    if fraction is None:
        reason = "nothing else says" if inputs is None else f"{inputs.text} do not say"
        raise refuse(
            path,
            f"there is no such file, and {reason} how much of the light is direct",
            advice=f"write difcol.inp, or these lines into sky.toml beside amc.inp:\n\n{_THREE_LINES}\n",
        )
    return DifcolTable(direct_fraction=np.full(n_wavebands, fraction), intensity=np.ones(n_wavebands))


def missing_inputs() -> UsageError:
    """The error for a Perez sky instead of a sky file, without inputs; with the three lines to write."""
    return UsageError(
        "--sky perez instead of skydist.inp needs dni and dhi (or epsilon and delta, or a to e): give them as options, "
        f"or write into sky.toml beside amc.inp\n\n{_THREE_LINES}\n"
    )


def inputs_of_difcol(difcol: DifcolTable, sun: Sun) -> PerezInputs:
    """Sky clearness of the photons' mean direct fraction f, and the median brightness of its bin.

    epsilon = 1 + [f / ((1 - f) cos Z)] / (1 + 1.041 Z^3), Delta of `MEDIAN_DELTA`; at least one band with light has a
    direct fraction below 1. Always warns: wavebands are not the whole spectrum.
    """
    from aomc_sky.skies.perez.functions import epsilon_bin, sky_clearness

    weight = difcol.intensity if np.any(difcol.intensity > 0) else np.ones_like(difcol.intensity)
    weight = weight / weight.max()  # sums of huge intensities stay finite
    mean = float(np.sum(weight * difcol.direct_fraction) / np.sum(weight))
    diffuse = float(np.sum(weight * (1.0 - difcol.direct_fraction)) / np.sum(weight))
    epsilon = float(sky_clearness(mean / sun.cosine, diffuse, math.radians(sun.zenith_deg)))
    delta = MEDIAN_DELTA[int(epsilon_bin(epsilon))]
    warnings.warn(
        "difcol.inp: the sky's clearness is computed from the direct fraction; from bands within 400 to 700 nm it is "
        "too low, often by a bin; give dni and dhi in sky.toml or as options",
        InputWarning,
        stacklevel=2,
    )
    text = f"the mean direct fraction {mean:.4g} and the median brightness of that clearness"
    return PerezInputs(section=PerezSection(epsilon=epsilon, delta=delta), origin=DIFCOL, text=text)
