"""The promises of every sky model, the class of a name, and the share that a model has in the light of a scene."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.directions import angle_as_given
from aomc_sky.errors import SceneError, UsageError, floats, shown_value
from aomc_sky.record import short_repr


@runtime_checkable
class SkyModel(Protocol):
    """Radiance of the sky.

    `radiance` broadcasts its arguments. It is finite, not negative, and pure: equal arguments give equal values. Three
    other methods are optional. The method `lower(wavelength_nm)` returns components with exact laws. For the notes of a
    scene, `notes(wavelength_nm)` returns sentences, and `missing_beam()` one for a scene without a beam. If a model has
    no `lower`, `FunctionSky` lowers it, on its `grid` if it has one.
    """

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance, relative unless the model says otherwise; arguments and results of every model.

        Parameters
        ----------
        sky_zenith_rad, sky_azimuth_rad : array_like
            Sky direction: 0 overhead, azimuth from +x (east) towards +y (north). [rad, 0 to pi/2 and any turn]
        wavelength_nm : array_like
            Wavelength. [nm]

        Returns
        -------
        ndarray, float64
            Broadcast of the arguments. [>= 0]
        """
        ...


class Lowers(Protocol):
    """A model with exact laws of its own."""

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """Components with a row for each wavelength."""
        ...


def broadcast(*arguments: ArrayLike) -> list[np.ndarray]:
    """The arguments of `SkyModel.radiance` as float64 arrays of one shape."""
    names = ("sky_zenith_rad", "sky_azimuth_rad", "wavelength_nm")
    given = [floats(*one) for one in zip(names, arguments, strict=True)]
    if np.any(np.isinf(given[0])) or np.any(np.isinf(given[1])):
        raise SceneError("the zenith angle and the azimuth of a sky direction must be finite")
    if not np.all(np.isfinite(given[2])):
        raise SceneError("wavelength_nm must be finite")
    return list(np.broadcast_arrays(*given))


def sky_model(name: str) -> Any:
    """The class of a sky model, by a name of `SKY_MODELS`; its instances are `SkyModel`s."""
    from aomc_sky.formats.sky_models import SKY_MODELS  # with Python's list of packages, which few scenes need

    target = SKY_MODELS.get(name)
    if target is None:
        raise UsageError(f"there is no sky model {name!r}; the models are {', '.join(sorted(SKY_MODELS))}")
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)


@dataclass(frozen=True, kw_only=True, slots=True)
class Share:
    """The share of a model in a scene: one of the two, or none in a scene of one model."""

    strength: ArrayLike | None = None  #: Relative irradiance on a horizontal plane, a number or one per wavelength.
    irradiance_W_m2_nm: ArrayLike | None = None  # noqa: N815  #: The same in absolute units.

    def __post_init__(self) -> None:
        check_share(self)


def sky_repr(model: Share) -> str:
    """What differs from the defaults, angles in the unit in which they were given: a `__repr__`."""
    return short_repr(model, angle_as_given)


def check_share(model: Share) -> None:
    """Refuse both at once, and values that are no irradiance; arrays become tuples, which compare and hash."""
    if model.strength is not None and model.irradiance_W_m2_nm is not None:
        raise UsageError("give a sky model strength= (relative) or irradiance_W_m2_nm= (absolute), not both")
    for name in ("strength", "irradiance_W_m2_nm"):
        value = getattr(model, name)
        if value is None:
            continue
        try:
            numbers = floats(name, value)
        except UsageError:
            message = f"{name} must be a number or one for each wavelength, got {shown_value(value)}"
            raise SceneError(message) from None
        if numbers.ndim > 1 or not np.all(np.isfinite(numbers) & (numbers >= 0)):
            raise SceneError(
                f"{name} must be finite and not negative, a number or one for each wavelength, got {value!r}"
            )
        object.__setattr__(model, name, float(numbers) if numbers.ndim == 0 else tuple(numbers.tolist()))


def with_share(model: Share, components: tuple[Component, ...]) -> tuple[Component, ...]:
    """The components of a model with the share that it was given, divided among them as their strengths are."""
    name = "strength" if model.irradiance_W_m2_nm is None else "irradiance_W_m2_nm"
    given = getattr(model, name)
    if given is None or not components:
        return components
    strengths = np.stack([component.strength for component in components])
    n_wl = strengths.shape[1]
    if np.size(given) not in (1, n_wl):
        raise SceneError(f"{name} of sky {components[0].name!r} has {np.size(given)} values for {n_wl} wavelengths")
    total = strengths.sum(axis=0)
    wished = np.broadcast_to(np.asarray(given, dtype=np.float64), n_wl)
    if np.any((wished > 0) & ~(total > 0)):
        raise SceneError(f"sky {components[0].name!r} was given a share of the light at a wavelength where it is dark")
    shares = np.divide(strengths, total, out=np.zeros_like(strengths), where=total > 0) * wished
    return tuple(
        dataclasses.replace(c, strength=share, irradiance_W_m2_nm=share if name == "irradiance_W_m2_nm" else None)
        for c, share in zip(components, shares, strict=True)
    )


def polarised(
    model: Any, components: tuple[Component, ...], wavelength_nm: ArrayLike, sun_rad: Any = None
) -> tuple[Component, ...]:
    """The components of a model with a sun, with the Stokes vectors of its `polarisation` if it has any."""
    if model.polarisation is None:
        return components
    require_pattern(model.polarisation)
    sun_rad = (model.sun_zenith_rad, model.sun_azimuth_rad) if sun_rad is None else sun_rad
    found: tuple[Component, ...] = model.polarisation.polarised(components, model.radiance, wavelength_nm, sun_rad)
    return found


def require_pattern(polarisation: Any) -> None:
    """Refuse what is neither a pattern nor None."""
    if polarisation is not None and not hasattr(polarisation, "polarised"):
        raise UsageError(
            f"polarisation must be None or a pattern, sky.RayleighPattern(max_degree=0.75), got {polarisation!r}"
        )


def has_share(model: object) -> bool:
    """Whether a model was given its share; True for models of others, whose components say it."""
    return not isinstance(model, Share) or model.strength is not None or model.irradiance_W_m2_nm is not None
