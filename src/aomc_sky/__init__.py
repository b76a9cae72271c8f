"""The photon source for Monte Carlo light transport in ocean and atmosphere.

Public names are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module

__version__ = "0.5.0"

_HOMES = {
    "skies.atmosphere.lights": "Moon",
    "skies.atmosphere.medium": "Constituent Medium rayleigh_cross_section",
    "skies.atmosphere.sky.solve": "AtmosphereResult",
    "component": "Component Law",
    "directions": "AzimuthConvention Frame",
    "engine.run": "write_run",
    "errors": (
        "AllocationError AomcSkyError InputFileError InputWarning ModelLimitWarning OutputError "
        "PluginError SceneError UsageError"
    ),
    "formats.aomc.skydist": "SkyTable read_skydist write_skydist",
    "skies.atmosphere.description.reader": "read_atmo",
    "skies.lobes.file.data": "SkyLobe background_of_lobes",
    "skies.lobes.file.file": "read_background_file write_background",
    "formats.mcpl.file": "read_mcpl",
    "grid": "PatchGrid",
    "outputs.photons.mcpl": "write_mcpl",
    "outputs.source_file": "write_source",
    "outputs.tables.netcdf": "to_xarray",
    "pictures.plot": "plot",
    "plan.allocation": "AllocationMethod allocate",
    "skies.atmosphere.model": "AtmosphereSky",
    "skies.cie": "CIESky",
    "skies.direct_beam": "DirectBeam",
    "skies.function_sky": "FunctionSky",
    "skies.harrison_coombes": "HarrisonCoombesSky",
    "skies.lobes.background": "BackgroundSky background_at",
    "skies.lobes.sky": "LobeSky WeightedLobe",
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
    "emission.photons": "Photon PhotonBatch",
    "plan.options": "Footprint FootprintShape",
    "plan.plan": "Plan",
    "source.irradiances": "irradiances",
    "source.read.measured": "read_radiance_csv",
    "source.read.scene": "read_scene",
    "source.scene": "Scene",
    "source.weather_scene": "weather_scene",
    "verify.counts": "verify_counts",
    "wavebands": "Wavebands",
}
"""Public names by the module that has them."""

_PUBLIC = {name: module for module, names in _HOMES.items() for name in names.split()}

_PUBLIC_MODULES = {
    "directions": "directions",
    "henyey_greenstein": "phase.henyey_greenstein",
    "lobes": "skies.lobes.functions",
    "perez": "skies.perez.functions",
    "rayleigh": "phase.rayleigh",
    "scattering": "phase.scattering",
}

__all__ = ["__version__", *sorted({**_PUBLIC, **_PUBLIC_MODULES})]  # noqa: PLE0604


def __getattr__(name: str) -> object:
    if name in _PUBLIC_MODULES:
        value: object = _module(_PUBLIC_MODULES[name])
    elif name in _PUBLIC:
        value = getattr(_module(_PUBLIC[name]), name)
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
