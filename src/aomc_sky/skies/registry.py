"""The sky models by name.

This registry is the only place that names them; third parties add theirs as entry points
of the group ``aomc_sky.sky_models``, which are looked at only for a name that is not here.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from aomc_sky.errors import UsageError

ENTRY_POINT_GROUP = "aomc_sky.sky_models"

#: Name of a sky model -> "module:Class".
SKY_MODELS = {
    "atmosphere": "aomc_sky.skies.atmosphere:AtmosphereSky",
    "lobes": "aomc_sky.skies.lobes.sky:LobeSky",
    "tabulated": "aomc_sky.skies.tabulated:TabulatedSky",
    "perez": "aomc_sky.skies.perez.sky:PerezSky",
    "uniform": "aomc_sky.skies.uniform:UniformSky",
}


def sky_model(name: str) -> Any:
    """The class of a sky model, by a name of `SKY_MODELS` or of an entry point; its instances are `SkyModel`s."""
    target = SKY_MODELS.get(name)
    if target is not None:
        module, _, attribute = target.partition(":")
        return getattr(import_module(module), attribute)
    from importlib.metadata import entry_points

    for entry in entry_points(group=ENTRY_POINT_GROUP, name=name):
        return entry.load()
    raise UsageError(f"there is no sky model {name!r}; the models are {', '.join(sorted(SKY_MODELS))}")
