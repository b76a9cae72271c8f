"""What every sky model promises, our sky models by name, and how one that only knows its radiance is sampled.

`SKY_MODELS` is the only place that names ours; those of other packages are in `sky_plugins`.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError

#: Name of a sky model -> "module:Class".
SKY_MODELS = {
    "atmosphere": "aomc_sky.skies.atmosphere:AtmosphereSky",
    "lobes": "aomc_sky.skies.lobes.sky:LobeSky",
    "tabulated": "aomc_sky.skies.tabulated:TabulatedSky",
    "perez": "aomc_sky.skies.perez.sky:PerezSky",
    "uniform": "aomc_sky.skies.uniform:UniformSky",
}


@runtime_checkable
class SkyModel(Protocol):
    """Radiance of the sky.

    `radiance` broadcasts its arguments and is finite, not negative, and pure: equal arguments give
    equal values. A model may also have `lower(wavelength_nm)`, which returns its components with
    exact laws, and `notes(wavelength_nm)`, sentences for the notes of its scene. One without `lower`
    is lowered to patches of constant radiance by `FunctionSky`, those of its `grid` if it has one.
    """

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance, relative unless the model says otherwise, of a sky element. [>= 0]"""
        ...


def as_sky_model(given: Any) -> Any:
    """A model that can be lowered: itself, or a `FunctionSky` of what has a radiance alone or is a function."""
    if hasattr(given, "lower"):
        return given
    function = getattr(given, "radiance", given)
    if not callable(function):
        raise SceneError(
            f"a scene is made of sky models, Components and functions of zenith, azimuth and wavelength; got {given!r}"
        )
    from aomc_sky.skies.function_sky import FunctionSky

    chosen = {name: getattr(given, name, None) for name in ("name", "grid", "strength", "irradiance_W_m2_nm")}
    is_function = function is given  # whose attributes are its own affair
    return FunctionSky(function, **({} if is_function else {k: v for k, v in chosen.items() if v is not None}))


def sky_model(name: str) -> Any:
    """The class of a sky model, by a name of `SKY_MODELS`; its instances are `SkyModel`s."""
    target = SKY_MODELS.get(name)
    if target is None:
        raise UsageError(f"there is no sky model {name!r}; the models are {', '.join(sorted(SKY_MODELS))}")
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)
