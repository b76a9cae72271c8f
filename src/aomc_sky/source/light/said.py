"""What one speaker says about the light of a scene, checked: a caller, a weather file, sky.toml or the files of AOMC.

Speakers stand in this order. Each question is answered by the first who says it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.errors import UsageError, require_kind
from aomc_sky.formats.sky_toml.keys import MOON_KEYS, RULES, moon_problem, plain_number, set_problem, value_problem
from aomc_sky.formats.sky_toml.sections import PerezSection, SkyToml, SunSection, perez_section
from aomc_sky.options import AMOUNTS, INPUTS, LIGHTS
from aomc_sky.skies.model import require_pattern

if TYPE_CHECKING:
    from aomc_sky.formats.aomc.amc import DifcolTable
    from aomc_sky.skies.polarisation import RayleighPattern
    from aomc_sky.source.light.weather import Moment

CALLER = "options"  #: The origin of what a caller says.


@dataclass(frozen=True, kw_only=True, slots=True)
class Said:
    """What one speaker says; what it does not say is None or empty."""

    sun: SunSection = field(default_factory=SunSection)
    moment: Moment | None = None  #: of which `sun`, and of a weather file `perez`, were made
    altitude_m: float | None = None
    perez: PerezSection = field(default_factory=PerezSection)  #: amounts or coefficients, and the spectrum
    clear_sky: Mapping[str, Any] = field(default_factory=dict)
    lights: Mapping[str, float] = field(default_factory=dict)  #: the Moon and the glow of the ground
    diffuse_only: bool = False
    polarisation: RayleighPattern | None = None
    shares: DifcolTable | None = None  #: of difcol.inp
    #: Irradiances of beam and sky on a horizontal plane, (n_band,), of [sky]. [W m-2 nm-1]
    direct_irradiance: tuple[float, ...] | None = None
    diffuse_irradiance: tuple[float, ...] | None = None
    is_file: bool = False  #: whether it is no caller: sky.toml, a field, the sun of a model, a file of AOMC

    @property
    def names(self) -> tuple[str, ...]:
        """The inputs that it says; the name of a weather file stands for its sun and its amounts."""
        if self.moment is not None and self.moment.path is not None:
            return self.moment.names
        amounts = [name for name in AMOUNTS if getattr(self.perez, name) is not None]
        amounts += ["coefficients"] * (self.perez.coefficients is not None)
        amounts += ["spectrum"] * (self.perez.spectrum is not None)
        sun = [name for name in ("zenith_deg", "azimuth_deg") if getattr(self.sun, name) is not None]
        if self.moment is not None:
            sun = list(self.moment.names)
        sun += ["altitude_m"] * (self.altitude_m is not None and self.moment is None)
        sun += ["disc"] * (self.sun.disc is not None)
        others = ["diffuse_only"] * self.diffuse_only + ["polarisation"] * (self.polarisation is not None)
        return (*amounts, *sun, *self.perez.model, *self.clear_sky, *self.lights, *others)


Speakers = tuple[Said, ...]


def said_by_caller(
    *,
    perez: Mapping[str, Any] | None = None,
    sun: Mapping[str, Any] | None = None,
    within: str | None = None,
    atmosphere: Mapping[str, Any] | None = None,
    weather: Mapping[str, Any] | None = None,
    clear_sky: Any = None,
    diffuse_only: bool = False,
    polarisation: Any = None,
) -> Speakers:
    """Check the inputs of a caller, a value None being left out; a weather file that is named speaks next.

    `perez` has keys of [perez], `sun` those of [sun], `weather` those of `MOMENT`; `clear_sky` is a mapping
    or a `ClearSky`.
    """
    perez, sun, weather = _given({**(perez or {}), "within": within}), _given(sun), _given(weather)
    moment = None
    if weather:
        from aomc_sky.source.light.weather import moment_of

        moment = moment_of(weather, perez, sun)
    amounts, angles = _checked("perez", perez), _checked("sun", sun)
    if problem := set_problem(list(amounts)):
        raise UsageError(f"how bright are sun and sky? {problem.message}", problem.advice)
    if dataclasses.is_dataclass(clear_sky) and not isinstance(clear_sky, type):
        clear_sky = _given(dataclasses.asdict(clear_sky))
    if clear_sky is not None and not isinstance(clear_sky, Mapping):
        raise UsageError(f"clear_sky must be a ClearSky(...) or a mapping, got {clear_sky!r}")
    if not isinstance(diffuse_only, (bool, np.bool_)):
        raise UsageError(f"diffuse_only must be True or False, got {diffuse_only!r}")
    require_pattern(polarisation)
    is_of_file = moment is not None and moment.path is not None
    place = SunSection(**angles, origin=CALLER)
    if moment is not None and not is_of_file:
        place = dataclasses.replace(moment.sun, disc=place.disc)
    caller = Said(
        sun=place,
        moment=None if is_of_file else moment,
        altitude_m=weather.get("altitude_m") or None,
        perez=dataclasses.replace(perez_section(amounts), origin=CALLER),
        clear_sky=_checked("clear_sky", clear_sky or {}),
        lights=checked_lights(atmosphere),
        diffuse_only=bool(diffuse_only),
        polarisation=polarisation,
    )
    if moment is None or not is_of_file:
        return (caller,)
    return caller, Said(sun=moment.sun, moment=moment, perez=moment.perez)


def said_by_toml(toml: SkyToml) -> Said:
    """What sky.toml says."""
    return Said(
        sun=toml.sun,
        perez=toml.perez,
        clear_sky=toml.clear_sky,
        polarisation=None if toml.sky.polarisation is None else rayleigh_pattern(toml.sky.polarisation),
        direct_irradiance=toml.sky.direct_irradiance,
        diffuse_irradiance=toml.sky.diffuse_irradiance,
        is_file=True,
    )


def rayleigh_pattern(max_degree: float) -> RayleighPattern:
    """The pattern of a largest degree; its module is loaded where polarisation is asked for."""
    from aomc_sky.skies.polarisation import RayleighPattern

    return RayleighPattern(max_degree=max_degree)


def checked_lights(given: Mapping[str, Any] | None) -> dict[str, float]:
    """Checked keys of [atmosphere] for the Moon and the glow of the ground; a value None is left out."""
    values = _given(given)
    for name in values:
        if name not in LIGHTS:
            raise UsageError(f"atmosphere has no input {name!r}; the inputs are {', '.join(LIGHTS)}")
    if problem := moon_problem([name for name in values if name in MOON_KEYS and name != "moon_distance_km"]):
        raise UsageError(f"the Moon: {problem.message}", problem.advice)
    return _checked("atmosphere", values)


def _given(values: Mapping[str, Any] | None) -> dict[str, Any]:
    require_kind(values or {}, Mapping, "a mapping of names to values")
    return {name: value for name, value in (values or {}).items() if value is not None}


def _checked(section: str, values: Mapping[str, Any]) -> dict[str, Any]:
    good: dict[str, Any] = {}
    for name, value in values.items():
        if name not in RULES[section]:
            raise UsageError(f"{section} has no input {name!r}; the inputs are {', '.join(RULES[section])}")
        if isinstance(value, np.bool_):
            value = bool(value)
        value = plain_number(value)
        if value is not None:
            if problem := value_problem(section, name, value):
                shown = (INPUTS[name].keyword if section == "sun" else "") or name
                raise UsageError(f"{shown}: {problem.message}", problem.advice, field=shown)
            good[name] = value
    return good


# The first who says it.


def first(values: list[Any]) -> Any:
    """The first value that is not None, else None."""
    return next((value for value in values if value is not None), None)


def callers_of(speakers: Speakers) -> Speakers:
    """The caller, and the weather file that he names."""
    return tuple(one for one in speakers if not one.is_file)


def is_diffuse_only(speakers: Speakers) -> bool:
    """Whether the beam is left out."""
    return any(one.diffuse_only for one in speakers)


def sun_said(speakers: Iterable[Said]) -> SunSection:
    """Zenith angle, azimuth and disc, each by the first who says it."""
    found = None
    for one in speakers:
        found = one.sun if found is None else found.over(one.sun)
    return found or SunSection()


def spectrum_said(speakers: Speakers) -> str | None:
    """How beam and sky share each waveband."""
    found: str | None = first([one.perez.spectrum for one in speakers])
    return found


def air_said(speakers: Speakers) -> dict[str, Any]:
    """The air of a cloudless sky, each value by the first who says it."""
    return {name: value for one in reversed(speakers) for name, value in one.clear_sky.items()}


def moment_said(speakers: Speakers) -> Moment | None:
    """The time and place, or the hour of a weather file."""
    found: Moment | None = first([one.moment for one in speakers])
    return found
