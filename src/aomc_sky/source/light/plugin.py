"""The sky model of another package: its options, and its components for a sun and wavebands."""

from __future__ import annotations

import dataclasses
import datetime
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import (
    AomcSkyError,
    InputFileError,
    InputWarning,
    ModelLimitWarning,
    Problem,
    Span,
    UsageError,
)
from aomc_sky.formats.report import nearest_text
from aomc_sky.formats.sky_models import MakeSky, installed_skies
from aomc_sky.formats.sky_toml.keys import KEYS, POLARISATION
from aomc_sky.formats.sky_toml.sections import SkySection
from aomc_sky.options import say
from aomc_sky.skies.function_sky import FunctionSky, as_sky_model

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

_OUR_WARNINGS = (InputWarning, ModelLimitWarning)  # exceptions where warnings are errors


@dataclass(frozen=True, kw_only=True, slots=True)
class PluginSky:
    """A sky model of another package and the options that it gets."""

    make: MakeSky
    options: Mapping[str, Any]
    section: SkySection  #: where options of sky.toml stand; empty where it is not about this model
    path: str  #: of sky.toml

    def __str__(self) -> str:
        return str(self.make.plugin)

    @property
    def record(self) -> dict[str, Any]:
        """JSON values for a manifest: what to install and what to write for the same sky."""
        plugin = self.make.plugin
        return {
            "name": plugin.name,
            "distribution": plugin.distribution,
            "version": plugin.version,
            "entry_point": plugin.entry_point.value,
            "options": {name: plain_option(name, value, _json_text) for name, value in self.options.items()},
        }

    @property
    def text(self) -> str:
        """The model and its options for a person."""
        plugin = self.make.plugin
        shown = ", ".join(f"{name} {value}" for name, value in self.record["options"].items())
        options = f" with {shown}" if shown else ""
        return f"sky model {plugin.name!r} of {plugin.distribution} {plugin.version}{options}"

    def model(self, sun_zenith_rad: float, sun_azimuth_rad: float, polarisation: RayleighPattern | None = None) -> Any:
        """The sky under a sun, one that can be lowered; `polarisation` is for a sky of ours."""
        plugin = self.make.plugin
        try:
            sun: dict[str, Any] = {"sun_zenith_rad": sun_zenith_rad, "sun_azimuth_rad": sun_azimuth_rad}
            if plugin.is_ours and polarisation is not None:
                sun["polarisation"] = polarisation
            given = self.make.make(**{n: v for n, v in sun.items() if self.make.takes(n)}, **self.options)
        except _OUR_WARNINGS:
            raise
        except (AomcSkyError, TypeError, ValueError) as error:
            self._refuse_options(error)
        except Exception as error:
            raise plugin.failed("fails", error) from error
        is_model = hasattr(given, "lower") or hasattr(given, "radiance") or callable(given)
        if not is_model or isinstance(given, type):
            what = f"the class {given.__name__}" if isinstance(given, type) else type(given).__name__
            raise plugin.wrong(f"gives {what} instead of an object with radiance(zenith, azimuth, wavelength)")
        model = as_sky_model(given)
        return dataclasses.replace(model, name=plugin.name) if isinstance(model, FunctionSky) else model

    def lower(self, model: Any, wavelength_nm: np.ndarray) -> tuple[Component, ...]:
        """Components of a `model` with a row for each wavelength; one alone has the name of the plugin."""
        plugin, components = self.make.plugin, self._called(model.lower, wavelength_nm)
        for component in components:
            if not isinstance(component, Component):
                raise plugin.wrong(f"lower() gives {type(component).__name__} instead of Components")
            if component.strength.shape != wavelength_nm.shape:
                n = component.strength.size
                raise plugin.wrong(f"lower() gives {n} strengths for {wavelength_nm.size} wavelengths")
        if not components:
            raise plugin.wrong("lower() gives no component")
        is_alone = len(components) == 1
        return (dataclasses.replace(components[0], name=plugin.name),) if is_alone else components

    def notes(self, model: Any, wavelength_nm: np.ndarray) -> tuple[str, ...]:
        """Notes of a `model`, if it has any."""
        return self._called(model.notes, wavelength_nm) if hasattr(model, "notes") else ()

    def _called(self, method: Callable[[np.ndarray], Iterable[Any]], wavelength_nm: np.ndarray) -> tuple[Any, ...]:
        """What a method of the model gives; its errors name the package."""
        try:
            return tuple(method(wavelength_nm))
        except _OUR_WARNINGS:
            raise
        except AomcSkyError as error:
            raise self.make.plugin.wrong(str(error)) from error
        except Exception as error:
            raise self.make.plugin.failed("fails", error) from error

    def _refuse_options(self, error: Exception) -> NoReturn:
        """Raise the model's refusal, at the key of sky.toml in its reason, or at the name of the model."""
        reason = " ".join(str(error).split())
        message = f"the sky model {self} refuses what it is given: {reason or type(error).__name__}"
        section_options = [option for option in self.section.options if self.options[option.name] is option.value]
        named = [option for option in section_options if option.name in reason.replace("'", " ").split()]
        if named or (section_options and len(section_options) == len(self.options)):
            span = named[0].value_span if named else self.section.model_span
            raise InputFileError([_problem(self.path, span, "E704", message, options_text(self.make))]) from error
        raise UsageError(f"{message}; {options_text(self.make)}") from error


def options_text(make: MakeSky) -> str:
    """Options of a model, for messages."""
    names = [make.shown(n, "needed" * is_needed) for n, is_needed in make.options.items()]
    open_ended = [] if make.parameters is not None and not make.takes("") else ["and others that it does not name"]
    return f"its options are {', '.join([*names, *open_ended])}" if names or open_ended else "it has no options"


def choose_plugin(name: str, section: SkySection, given: Mapping[str, Any], path: str) -> PluginSky:
    """The model of this name with the options of sky.toml, and those that are `given`, which come first.

    Wrong names of options are errors here; the model checks their values.
    """
    section_options = section if section.model == name else SkySection()
    make = installed_skies().plugins[name].load()
    problems, wrong = [], []
    for option in section_options.options:
        if not make.has_option(option.name):
            message, advice = _unknown(make, option.name, (*make.options, *KEYS["sky"]))
            problems.append(_problem(path, option.key_span, "E702", message, advice))
    for option_name in given:
        if not make.has_option(option_name):
            message, advice = _unknown(make, option_name, tuple(make.options))
            is_of_scene = option_name == POLARISATION and make.plugin.is_ours
            wrong.append(f"{message}; {say('write {polarisation:0.75}') if is_of_scene else advice}")
    options = {option.name: option.value for option in section_options.options} | dict(given)
    missing = [n for n, is_needed in make.options.items() if is_needed and n not in options]
    if missing and not problems and not wrong:
        message = f"the sky model {make.plugin} needs {' and '.join(map(make.shown, missing))}"
        if section_options.model_span is None:
            by_option = " ".join(f"--sky-option {n}=..." for n in missing)
            pairs = ", ".join(f'"{n}": ...' for n in missing)
            wrong.append(f"{message}; write {by_option} (sky_options={{{pairs}}})")
        else:
            advice = f"add {' and '.join(f'{n} = ...' for n in missing)} below it"
            problems.append(_problem(path, section_options.model_span, "E705", message, advice))
    if problems:
        raise InputFileError(problems)
    if wrong:
        raise UsageError(". ".join(wrong))
    return PluginSky(make=make, options=options, section=section_options, path=path)


def _unknown(make: MakeSky, name: str, known: Sequence[str]) -> tuple[str, str]:
    return f"the sky model {make.plugin} has no option {name!r}{nearest_text(name, known)}", options_text(make)


def _problem(path: str, span: Span | None, code: str, message: str, advice: str) -> Problem:
    assert span is not None, "what stands in a file has a span"
    return span.problem(path, code, message, field="sky", advice=advice)


def _json_text(value: Any) -> Any:
    """Dates, and numbers that are not finite, as text for JSON."""
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def plain_option(name: str, value: Any, convert: Callable[[Any], Any] = lambda value: value) -> Any:
    """An option as plain values of Python, which a manifest can hold."""
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain_option(name, one, convert) for one in value]
    if isinstance(value, Mapping):
        return {str(key): plain_option(name, one, convert) for key, one in value.items()}
    if isinstance(value, (bool, int, float, str, datetime.date, datetime.time)):
        return convert(value)
    raise UsageError(
        f"option {name} of a sky model must be a number, a text, true or false, or a list of such, got "
        f"{type(value).__name__}; a model made in Python goes into Scene(components=...)"
    )
