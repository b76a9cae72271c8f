"""The photon source for Monte Carlo light transport in ocean and atmosphere.

Public names are loaded when they are first used, so that importing the package costs nothing. ``dir(aomc_sky)`` has the
names of the first days. The modules `atmosphere`, `component`, `directions`, `errors`, `files`, `lobes`, `perez`,
`rayleigh`, `henyey_greenstein` and `scattering` have what builders of skies and other codes use.
"""

from __future__ import annotations

import sys
import warnings
from importlib import import_module

__version__ = "0.5.0"

_HOMES = {
    "engine.run": "write_run",
    "errors": "AomcSkyError InputFileError InputWarning ModelLimitWarning SceneError UsageError",
    "grid": "PatchGrid",
    "outputs.photons.mcpl": "write_mcpl",
    "outputs.source_file": "write_source",
    "outputs.tables.netcdf": "to_xarray",
    "pictures.plot": "plot",
    "plan.allocation": "allocate",
    "skies.atmosphere.model": "AtmosphereSky",
    "skies.cie": "CIESky",
    "skies.direct_beam": "DirectBeam",
    "skies.function_sky": "FunctionSky",
    "skies.harrison_coombes": "HarrisonCoombesSky",
    "skies.lobes.background": "background_at",
    "skies.lobes.sky": "LobeSky",
    "skies.measured": "RadianceField",
    "skies.overcast": "CardioidalSky OvercastSky",
    "skies.perez.sky": "PerezSky",
    "skies.polarisation": "RayleighPattern",
    "skies.tabulated": "TabulatedSky Weighting",
    "skies.uniform": "UniformSky",
    "source.read.solve": "solve_atmosphere",
    "skies.lobes.light": "read_background",
    "source.light.spectral_split": "Aerosol ClearSky",
    "source.light.sun_position": "sun_position",
    "emission.photon_source": "PhotonSource",
    "emission.photons": "PhotonBatch",
    "plan.options": "Footprint",
    "plan.plan": "Plan",
    "source.irradiances": "irradiances",
    "source.read.measured": "read_radiance_csv",
    "source.read.scene": "read_scene",
    "source.scene": "Scene",
    "source.weather_scene": "weather_scene",
    "verify.counts": "verify_counts",
    "wavebands": "Wavebands",
}
"""Names of the first days by the module that has them."""

_MOVED = {
    "atmosphere": "AtmosphereResult Constituent Medium Moon rayleigh_cross_section read_atmo",
    "component": "Component Law",
    "directions": "AzimuthConvention Frame",
    "emission.photons": "Photon",
    "errors": "AllocationError OutputError PluginError",
    "files": "SkyTable read_mcpl read_skydist write_skydist",
    "lobes": "BackgroundSky SkyLobe WeightedLobe background_of_lobes read_background_file write_background",
    "plan.allocation": "AllocationMethod",
    "plan.options": "FootprintShape",
}
"""Names that builders of laws, lobes, atmospheres and files need, by their public module; until version 0.6 the package
has them too, with a DeprecationWarning."""

_PUBLIC = {name: module for module, names in _HOMES.items() for name in names.split()}
_OLD = {name: module for module, names in _MOVED.items() for name in names.split()}

_PUBLIC_MODULES = {
    "atmosphere": "atmosphere",
    "component": "component",
    "directions": "directions",
    "errors": "errors",
    "files": "files",
    "henyey_greenstein": "phase.henyey_greenstein",
    "lobes": "lobes",
    "perez": "skies.perez.functions",
    "rayleigh": "phase.rayleigh",
    "scattering": "phase.scattering",
}

__all__ = ["__version__", *sorted(_PUBLIC)]  # noqa: PLE0604


def __getattr__(name: str) -> object:
    if name in _PUBLIC_MODULES:
        value: object = _module(_PUBLIC_MODULES[name])
    elif name in _PUBLIC:
        value = getattr(_module(_PUBLIC[name]), name)
    elif name in _OLD:
        new = f"aomc_sky.{_OLD[name]}.{name}"
        warnings.warn(f"aomc_sky.{name} goes with version 0.6: write {new}", DeprecationWarning, stacklevel=2)
        return getattr(_module(_OLD[name]), name)
    else:
        raise AttributeError(f"module 'aomc_sky' has no attribute {name!r}")
    globals()[name] = value
    return value


def _module(name: str) -> object:
    """A module whose constants are computed in the default mode; errors are there whatever the mode is."""
    from aomc_sky.float_mode import in_default_mode

    return sys.modules.get(f"aomc_sky.{name}") or in_default_mode(import_module)(f"aomc_sky.{name}")


def __dir__() -> list[str]:
    return list(__all__)
