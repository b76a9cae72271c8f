"""Sky models by name: ours, and those of other packages (entry points of one group)."""

from __future__ import annotations

import contextlib
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import aomc_sky
from aomc_sky.errors import PluginError

#: Name of a sky model of ours -> "module:Class".
SKY_MODELS = {
    "atmosphere": "aomc_sky.skies.atmosphere.model:AtmosphereSky",
    "cardioidal": "aomc_sky.skies.overcast:OvercastSky",
    "cie": "aomc_sky.skies.cie:CIESky",
    "harrison-coombes": "aomc_sky.skies.harrison_coombes:HarrisonCoombesSky",
    "lobes": "aomc_sky.skies.lobes.sky:LobeSky",
    "overcast": "aomc_sky.skies.overcast:OvercastSky",
    "tabulated": "aomc_sky.skies.tabulated:TabulatedSky",
    "perez": "aomc_sky.skies.perez.sky:PerezSky",
    "uniform": "aomc_sky.skies.uniform:UniformSky",
}

ENTRY_POINT_GROUP = "aomc_sky.sky_models"

OUR_NAMES = ("perez", "uniform", "none", "atmosphere", "direct", "field", "function", "lobes", "table", "tabulated")
"""Skies that a scene makes in a way of its own, and names of their components. Other skies of ours are made as those of
other packages are, from a sun and options; no other package can take the names of either."""

SUN = ("sun_zenith_rad", "sun_azimuth_rad")
"""What every `make` gets besides its options."""

_SCENE_OPTIONS = ("sun_zenith_deg", "sun_azimuth_deg", "strength", "irradiance_W_m2_nm", "grid", "polarisation")
"""Arguments of our classes that a scene of files sets otherwise: no options."""


@dataclass(frozen=True, slots=True)
class SkyPlugin:
    """A sky model of another package, or one of ours that is made as these are."""

    name: str
    distribution: str
    version: str
    entry_point: EntryPoint

    def __str__(self) -> str:
        return f"{self.name!r} ({self.distribution} {self.version})"

    @property
    def is_ours(self) -> bool:
        """Whether it is a sky of this package."""
        return self.name in SKY_MODELS

    def load(self) -> MakeSky:
        """Import it; PluginError where that fails, or where what it names cannot be called with a sun.

        Its prints go to standard error, because standard output may be JSON.
        """
        try:
            with contextlib.redirect_stdout(sys.stderr):
                make = self.entry_point.load()
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise self.failed("cannot be imported", error) from error
        if not callable(make):
            raise self.wrong(f"{self.entry_point.value} is not a function")
        try:
            parameters: Mapping[str, inspect.Parameter] | None = inspect.signature(make).parameters
        except (TypeError, ValueError):  # some compiled functions do not say what they take
            parameters = None
        found = MakeSky(plugin=self, make=make, parameters=parameters)
        missing = [name for name in SUN if not found.takes(name)]
        if missing and not self.is_ours:  # a sky of ours may have no sun
            raise self.wrong(f"{self.entry_point.value} takes no {' and no '.join(missing)}")
        return found

    def wrong(self, what: str) -> PluginError:
        """The error for what it should not do."""
        return PluginError(f"the sky model {self} cannot be used: {what}")

    def failed(self, what: str, error: BaseException) -> PluginError:
        """The error for an exception that is not ours."""
        reason = " ".join(str(error).split())[:300]
        return PluginError(
            f"the sky model {self} {what}: {type(error).__name__}{': ' if reason else ''}{reason}; "
            f"this is a fault of {self.distribution}"
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class MakeSky:
    """The function of a plugin that makes its sky, and what it takes."""

    plugin: SkyPlugin
    make: Callable[..., Any]
    parameters: Mapping[str, inspect.Parameter] | None  #: None: not known

    def takes(self, name: str) -> bool:
        """Whether it may be called with this argument."""
        if self.parameters is None or any(p.kind is p.VAR_KEYWORD for p in self.parameters.values()):
            return True
        return name in self.parameters and self.parameters[name].kind in _BY_NAME

    def has_option(self, name: str) -> bool:
        """Whether it may be given as an option; of a sky of ours only what a scene does not set otherwise."""
        return name in self.options if self.plugin.is_ours else self.takes(name)

    @property
    def options(self) -> dict[str, bool]:
        """Its options by name, and whether each is needed; what it takes as ``**`` has no names."""
        known = (self.parameters or {}).items()
        no_options = (*SUN, *_SCENE_OPTIONS) if self.plugin.is_ours else SUN
        return {n: p.default is p.empty for n, p in known if n not in no_options and p.kind in _BY_NAME}

    def shown(self, name: str, *more: str) -> str:
        """An option with its range, where the model states it: `option_ranges` of the class or function."""
        ranges = getattr(self.make, "option_ranges", None)
        stated = ranges.get(name) if isinstance(ranges, Mapping) else None
        about = ", ".join(filter(None, (stated and str(stated), *more)))
        return f"{name} ({about})" if about else name


_BY_NAME = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


@dataclass(frozen=True, kw_only=True, slots=True)
class InstalledSkies:
    """All sky models that are made from a sun and options; of those that cannot be used, a sentence."""

    plugins: Mapping[str, SkyPlugin]
    refused: Mapping[str, str]


def is_sunless(name: object) -> bool:
    """Whether a named sky of ours is the same under any sun."""
    if name == "uniform":
        return True
    plugin = installed_skies().plugins.get(name) if isinstance(name, str) else None
    return plugin is not None and plugin.is_ours and not plugin.load().takes(SUN[0])


def installed_skies() -> InstalledSkies:
    """Look through `SKY_MODELS` and the installed packages; nothing is imported."""
    ours = {
        name: SkyPlugin(name, "aomc-sky", aomc_sky.__version__, EntryPoint(name, value, ENTRY_POINT_GROUP))
        for name, value in SKY_MODELS.items()
        if name not in OUR_NAMES
    }
    found: dict[str, list[SkyPlugin]] = {}
    for entry in entry_points(group=ENTRY_POINT_GROUP):
        dist = entry.dist
        known = ("an unknown package", "") if dist is None else (str(dist.name), str(dist.version))
        found.setdefault(entry.name, []).append(SkyPlugin(entry.name, *known, entry))
    refused = {}
    for name, plugins in found.items():
        owners = " and ".join(f"{p.distribution} {p.version}" for p in plugins)
        if name in OUR_NAMES or name in ours:
            refused[name] = f"{owners} has a sky model {name!r}, a name of aomc-sky's own, so it is not used"
        elif len(plugins) > 1:
            refused[name] = f"{owners} have each a sky model {name!r}; uninstall all but one"
    others = {name: plugins[0] for name, plugins in sorted(found.items()) if name not in refused}
    return InstalledSkies(plugins=ours | others, refused=refused)
