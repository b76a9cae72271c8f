"""The photon source for Monte Carlo light transport in ocean and atmosphere.

Public names are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import logging
from importlib import import_module
from typing import Any

from aomc_sky.float_mode import in_default_mode

__version__ = "0.1.0"

logging.getLogger("aomc_sky").addHandler(logging.NullHandler())

_PUBLIC = {
    "AllocationError": "errors",
    "AllocationMethod": "sampling.allocation",
    "AomcSkyError": "errors",
    "AtmosphereResult": "atmosphere.solve",
    "AtmosphereSky": "skies.atmosphere",
    "AzimuthConvention": "directions",
    "BackgroundSky": "skies.background",
    "Component": "component",
    "Constituent": "atmosphere.medium",
    "DirectBeam": "skies.direct_beam",
    "Footprint": "source.footprint",
    "Frame": "directions",
    "InputFileError": "errors",
    "InputWarning": "errors",
    "Law": "component",
    "LobeSky": "skies.lobe_sky",
    "Medium": "atmosphere.medium",
    "ModelLimitWarning": "errors",
    "Moon": "atmosphere.moon",
    "OutputError": "errors",
    "PatchGrid": "grid",
    "PerezSky": "skies.perez_sky",
    "PhotonBatch": "source.photons",
    "PhotonSource": "source.photon_source",
    "Plan": "source.plan",
    "Scene": "source.scene",
    "SceneError": "errors",
    "SkyLobe": "formats.background_builder",
    "SkyTable": "formats.skydist",
    "TabulatedSky": "skies.tabulated",
    "UniformSky": "skies.uniform",
    "UsageError": "errors",
    "Wavebands": "wavebands",
    "WeightedDirections": "atmosphere.weighted_directions",
    "WeightedLobe": "skies.lobe_sky",
    "Weighting": "skies.tabulated",
    "allocate": "sampling.allocation",
    "animate": "pictures.animate",
    "background_at": "skies.background_at",
    "plot": "pictures.plot",
    "rayleigh_cross_section": "atmosphere.molecules",
    "read_atmo": "formats.atmo",
    "background_of_lobes": "formats.background_builder",
    "read_background": "source.background",
    "read_background_file": "formats.background_hdf5",
    "read_mcpl": "formats.mcpl",
    "read_scene": "source.from_files",
    "read_skydist": "formats.skydist",
    "solve_atmosphere": "source.solve_atmosphere",
    "to_xarray": "outputs.netcdf",
    "verify_counts": "verify",
    "weighted_directions": "source.weighted_directions",
    "write_background": "formats.background_hdf5",
    "write_mcpl": "outputs.mcpl",
    "write_skydist": "formats.skydist",
}

_PUBLIC_MODULES = {
    "directions": "directions",
    "henyey_greenstein": "phase.henyey_greenstein",
    "lobes": "skies.lobes",
    "perez": "skies.perez",
    "rayleigh": "phase.rayleigh",
    "scattering": "phase.scattering",
}

__all__ = ["__version__", *sorted({**_PUBLIC, **_PUBLIC_MODULES})]  # noqa: PLE0604


@in_default_mode
def __getattr__(name: str) -> Any:
    if name in _PUBLIC_MODULES:
        value: Any = import_module(f"aomc_sky.{_PUBLIC_MODULES[name]}")
    elif name in _PUBLIC:
        value = getattr(import_module(f"aomc_sky.{_PUBLIC[name]}"), name)
    else:
        raise AttributeError(f"module 'aomc_sky' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
