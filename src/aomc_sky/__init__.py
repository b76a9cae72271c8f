"""The photon source for Monte Carlo light transport in ocean and atmosphere.

Public names are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import logging
import sys
from importlib import import_module
from typing import Any

from aomc_sky.float_mode import in_default_mode

__version__ = "0.3.0"

logging.getLogger("aomc_sky").addHandler(logging.NullHandler())

_PUBLIC = {
    "AllocationError": "errors",
    "AllocationMethod": "sampling.allocation",
    "AomcSkyError": "errors",
    "AtmosphereResult": "atmosphere.sky.solve",
    "AtmosphereSky": "skies.atmosphere",
    "AzimuthConvention": "directions",
    "BackgroundSky": "skies.lobes.background",
    "Component": "component",
    "Constituent": "atmosphere.medium",
    "DirectBeam": "skies.direct_beam",
    "FunctionSky": "skies.function_sky",
    "Footprint": "source.photons",
    "Frame": "directions",
    "InputFileError": "errors",
    "InputWarning": "errors",
    "Law": "component",
    "LobeSky": "skies.lobes.sky",
    "Medium": "atmosphere.medium",
    "ModelLimitWarning": "errors",
    "Moon": "atmosphere.lights",
    "OutputError": "errors",
    "PatchGrid": "grid",
    "PerezSky": "skies.perez.sky",
    "PhotonBatch": "source.photons",
    "PhotonSource": "source.photon_source",
    "Plan": "source.plan.plan",
    "PluginError": "errors",
    "Scene": "source.scene",
    "SceneError": "errors",
    "SkyLobe": "formats.background.data",
    "SkyTable": "formats.aomc.skydist",
    "TabulatedSky": "skies.tabulated",
    "UniformSky": "skies.uniform",
    "UsageError": "errors",
    "Wavebands": "wavebands",
    "WeightedLobe": "skies.lobes.sky",
    "Weighting": "skies.tabulated",
    "allocate": "sampling.allocation",
    "animate": "pictures.animate",
    "background_at": "skies.lobes.background",
    "plot": "pictures.plot",
    "rayleigh_cross_section": "atmosphere.medium",
    "read_atmo": "formats.atmo.reader",
    "background_of_lobes": "formats.background.data",
    "read_background": "source.backgrounds.light",
    "read_background_file": "formats.background.file",
    "read_mcpl": "formats.mcpl.file",
    "read_scene": "source.read.scene",
    "read_skydist": "formats.aomc.skydist",
    "sun_position": "source.light.sun_position",
    "solve_atmosphere": "source.atmospheres.solve",
    "to_xarray": "outputs.tables.netcdf",
    "verify_counts": "verify.counts",
    "write_background": "formats.background.file",
    "write_mcpl": "outputs.photons.mcpl",
    "write_run": "engine.run",
    "write_skydist": "formats.aomc.skydist",
}

_PUBLIC_MODULES = {
    "directions": "directions",
    "henyey_greenstein": "phase.henyey_greenstein",
    "lobes": "skies.lobes.functions",
    "perez": "skies.perez.functions",
    "rayleigh": "phase.rayleigh",
    "scattering": "phase.scattering",
}

__all__ = ["__version__", *sorted({**_PUBLIC, **_PUBLIC_MODULES})]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    if name in _PUBLIC_MODULES:
        value: Any = _module(_PUBLIC_MODULES[name])
    elif name in _PUBLIC:
        value = getattr(_module(_PUBLIC[name]), name)
    else:
        raise AttributeError(f"module 'aomc_sky' has no attribute {name!r}")
    globals()[name] = value
    return value


def _module(name: str) -> Any:
    """A module whose constants are computed in the default mode; errors are there whatever the mode is."""
    return sys.modules.get(f"aomc_sky.{name}") or in_default_mode(import_module)(f"aomc_sky.{name}")


def __dir__() -> list[str]:
    return list(__all__)
