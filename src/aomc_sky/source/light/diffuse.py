"""Diffuse skies beside which the sun's beam is launched: what each needs, and its components for a scene's rows."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import travel_from_sky
from aomc_sky.errors import InputWarning, ModelLimitWarning, SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import value_problem
from aomc_sky.formats.sky_toml.sections import PerezSection, SkySection
from aomc_sky.inputs import Entrance
from aomc_sky.plan.laws import law_of
from aomc_sky.skies.model import Share, sky_model
from aomc_sky.source.light.sun import Sun, perez_arguments

if TYPE_CHECKING:
    from aomc_sky.grid import PatchGrid
    from aomc_sky.skies.perez.sky import PerezSky
    from aomc_sky.source.light.inputs import LightInputs
    from aomc_sky.source.light.plugin import PluginSky

FIELD = "field"
"""The sky of a scene whose sky.toml has [sky] table, and of a field that is run alone."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Diffuse:
    """The diffuse part of a scene: components whose strengths add up to 1, with notes and options."""

    components: tuple[Component, ...] = ()
    notes: tuple[str, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)
    irradiance: np.ndarray | None = None  #: of each row on a horizontal plane, where known [W m-2 nm-1]


@dataclass(frozen=True, kw_only=True, slots=True)
class Rows:
    """The rows of a scene: each has a direct fraction, a wavelength, and a row of the sky's own table."""

    direct_fraction: np.ndarray
    wavelength_nm: np.ndarray
    table_row: np.ndarray
    of_band: np.ndarray  #: the row of each waveband
    band_nm: np.ndarray  #: the wavelength of each waveband
    is_alone: bool = False  #: Whether a scene without the beam is meant


@dataclass(frozen=True, kw_only=True, slots=True)
class DiffuseSky:
    """A sky that does not say itself how bright the sun's beam is."""

    name: str
    lower: Callable[[Sun | None, Rows, PerezSection], Diffuse]
    takes_sun: bool = False  #: Whether its law depends on the sun's angles
    is_spectral: bool = False  #: Whether each waveband has a row of its own
    #: Row of the sky's table for each wavelength; None where the sky has no table
    table_rows: Callable[[np.ndarray], np.ndarray] | None = None
    #: Wavelength of its table that serves each wavelength, NaN where the table has none [nm]
    table_wavelength_nm: Callable[[np.ndarray], np.ndarray] | None = None
    is_file: bool = False  #: Whether the light of a file is the whole light of a scene, unless a beam is asked for
    is_sunless: bool = False  #: Whether it is the same under any sun, so that no pattern can be around it
    words: str = ""  #: For a person, by default "a uniform sky"

    def __str__(self) -> str:
        return self.words or f"{'an' if self.name[0] in 'aeio' else 'a'} {self.name} sky"


def diffuse_of(components: Sequence[Component], name: str, rows: Rows) -> Diffuse:
    """Components in their shares; their irradiances count where every waveband has some sky."""
    total = np.sum([c.strength for c in components], axis=0)
    fractions = rows.direct_fraction
    dark = np.flatnonzero(~(total > 0) & (fractions > 0) & (fractions < 1))
    if dark.size:
        raise SceneError(
            f"{name} is dark at {rows.wavelength_nm[dark[0]]:g} nm, but {1 - fractions[dark[0]]:g} of the light there "
            "is diffuse"
        )
    shares = [np.divide(c.strength, total, out=np.zeros_like(total), where=total > 0) for c in components]
    is_absolute = all(c.irradiance_W_m2_nm is not None for c in components)
    notes: tuple[str, ...] = ()
    if is_absolute and np.any(fractions == 1):
        is_absolute = False
        notes = (f"{name}: its own irradiance is not used, for a waveband has direct light alone",)
    return Diffuse(
        notes=notes,
        components=tuple(
            dataclasses.replace(c, strength=share, irradiance_W_m2_nm=None)
            for c, share in zip(components, shares, strict=True)
        ),
        irradiance=total if is_absolute else None,
    )


def patterned(
    model: Any, components: Sequence[Component], sun: Sun | None, wavelength_nm: np.ndarray, name: str
) -> tuple[Component, ...]:
    """Components of a model with the pattern of polarisation that is asked for, around the sun of the scene."""
    if sun is None or sun.polarisation is None:
        return tuple(components)
    if any(one.stokes is not None for one in components):
        raise UsageError(f"polarisation: {name} is polarised already; leave its Q and U out, or Rayleigh's pattern")
    if not hasattr(model, "radiance") or all(one.grid is None for one in components):
        raise UsageError(f"polarisation: {name} has no radiance or no patches, as Rayleigh's pattern needs them")
    return sun.polarisation.polarised(components, model.radiance, wavelength_nm, sun.rad)


def perez_diffuse(
    choices: Mapping[str, Any],
    *,
    grid: PatchGrid | None = None,
    replaces_file: bool = False,
    shows: Sequence[str] = (),
) -> DiffuseSky:
    """The Perez sky with these arguments of `PerezSky`; `shows` names what else of it a manifest has."""

    def lower(sun: Sun | None, rows: Rows, amounts: PerezSection) -> Diffuse:
        assert sun is not None, "light_of finds the sun of a sky that takes it"
        sky, limited = perez_sky(choices, amounts, sun, grid)
        shown = {name: getattr(sky, name) for name in shows}
        shown |= {**sky_options(sky), **choices, "from": str(amounts), "limited": limited}
        numbers = (
            "" if shown["epsilon"] is None else f"epsilon {shown['epsilon']:.4g}, Delta {shown['delta']:.4g}, from "
        )
        if amounts.epsilon is not None and not amounts.words:
            numbers = ""  # the text of the amounts has them already
        notes = [f"Perez sky: {numbers}{amounts}"]
        has_beam = bool(np.any(rows.direct_fraction > 0))
        if replaces_file and not (has_beam or rows.is_alone):
            missing = sky.missing_beam("write 0 as the light source of amc.inp to launch both")
            notes += [missing] * bool(missing)
        components = tuple(sky.lower(rows.direct_fraction))
        return Diffuse(components=components, notes=tuple(notes), options={"perez": shown})

    return DiffuseSky(name="perez", lower=lower, takes_sun=True)


def perez_sky(
    choices: Mapping[str, Any], amounts: PerezSection, sun: Sun, grid: PatchGrid | None = None
) -> tuple[PerezSky, list[str]]:
    """The sky of strength 1, and the warnings of its model about limits; each is given once more."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        sky = sky_model("perez")(
            sun_zenith_rad=math.radians(sun.zenith_deg),
            sun_azimuth_rad=math.radians(sun.azimuth_deg),
            grid=grid,
            strength=1.0,
            polarisation=sun.polarisation,
            **{"extraterrestrial_normal": sun.extraterrestrial_normal, **choices},
            **perez_arguments(amounts, sun),
        )
    texts = list(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning)))
    for text in texts:
        warnings.warn(text, ModelLimitWarning, stacklevel=3)
    return sky, texts


def sky_options(sky: PerezSky) -> dict[str, Any]:
    """Clearness, brightness and coefficients of a Perez sky, for a manifest."""
    return {
        "epsilon": None if sky.clearness is None else float(sky.clearness),
        "delta": None if sky.brightness is None else float(sky.brightness),
        "coefficients": [float(c) for c in sky.model_coefficients],
    }


def uniform_diffuse(*, per_solid_angle: bool = False) -> DiffuseSky:
    """The same radiance everywhere."""

    def lower(_: Sun | None, rows: Rows, __: PerezSection) -> Diffuse:
        model = sky_model("uniform")(per_solid_angle=per_solid_angle)
        return Diffuse(components=tuple(model.lower(rows.direct_fraction)))

    return DiffuseSky(name="uniform", lower=lower, is_sunless=True)


def plugin_diffuse(plugin: PluginSky) -> DiffuseSky:
    """A named sky, whose radiance may depend on the wavelength."""

    def lower(sun: Sun | None, rows: Rows, _: PerezSection) -> Diffuse:
        model = plugin.model(*(0.0, 0.0) if sun is None else sun.rad, None if sun is None else sun.polarisation)
        components = plugin.lower(model, rows.wavelength_nm)
        if not plugin.make.plugin.is_ours:
            components = patterned(model, components, sun, rows.wavelength_nm, f"the sky model {plugin}")
        found = diffuse_of(components, f"the sky model {plugin}", rows)
        return dataclasses.replace(
            found,
            notes=(plugin.text, *found.notes, *plugin.notes(model, rows.wavelength_nm)),
            options={"plugin": plugin.record},
        )

    takes_sun = plugin.make.takes("sun_zenith_rad")
    name = plugin.make.plugin.name
    return DiffuseSky(name=name, lower=lower, takes_sun=takes_sun, is_spectral=True, is_sunless=not takes_sun)


def model_diffuse(
    given: Any, inputs: LightInputs | None = None, *, options: Mapping[str, Any] | None = None, **how: Any
) -> DiffuseSky:
    """A model or a function of Python, for `inputs`; `options` is what a manifest has of it."""
    from aomc_sky.skies.function_sky import as_sky_model

    model = as_sky_model(given)
    if inputs is not None and inputs.polarisation is not None and hasattr(model, "sun_zenith_rad"):
        raise UsageError(f"polarisation: this sky has a sun of its own: write {type(model).__name__}(polarisation=...)")
    if hasattr(model, "beam"):
        raise UsageError(
            f"{type(model).__name__} has a beam of its own: Scene(components=[*model.beam(nm), *model.lower(nm)])"
        )
    name = str(getattr(model, "name", type(model).__name__))

    def lower(sun: Sun | None, rows: Rows, _: PerezSection) -> Diffuse:
        components = tuple(_every_row(one, rows.wavelength_nm.size) for one in model.lower(rows.wavelength_nm))
        components = patterned(model, components, sun, rows.wavelength_nm, how.get("words") or f"sky {name!r}")
        if any(law_of(one.law).is_beam for one in components):
            raise UsageError(f"{name} is a beam and no diffuse sky; put it into Scene(components=[...])")
        if sun is not None:
            _warn_of_other_sun(model, name, sun)
        found = diffuse_of(components, f"sky {name!r}", rows)
        notes = found.notes + (tuple(model.notes(rows.wavelength_nm)) if hasattr(model, "notes") else ())
        if not (np.any(rows.direct_fraction > 0) or rows.is_alone) and hasattr(model, "missing_beam"):
            notes += tuple(filter(None, (model.missing_beam(),)))
        return dataclasses.replace(found, notes=notes, options=dict(options or {}))

    is_sunless = isinstance(model, Share) and name in ("UniformSky", "OvercastSky")
    of_table = getattr(model, "table_wavelength_nm", None)
    return DiffuseSky(
        name=name, lower=lower, is_spectral=True, is_sunless=is_sunless, table_wavelength_nm=of_table, **how
    )


_APART_DEG = 0.5  #: Two suns whose discs do not touch are two suns.


def _warn_of_other_sun(model: Any, name: str, sun: Sun) -> None:
    """Warn of a model that was made for another sun than that of the scene, which its beam has."""
    if not (hasattr(model, "sun_zenith_rad") and hasattr(model, "sun_azimuth_rad")):
        return
    own = math.degrees(model.sun_zenith_rad), math.degrees(model.sun_azimuth_rad)
    scene = sun.zenith_deg, sun.azimuth_deg
    if float(travel_from_sky(*own) @ travel_from_sky(*scene)) < math.cos(math.radians(_APART_DEG)):
        at, other = ("a zenith angle of {:.4g} and an azimuth of {:.4g}".format(*place) for place in (own, scene))
        text = f"sky {name!r} has its sun at {at}, the scene at {other} degrees; give the sky the angles of that sun"
        warnings.warn(text, InputWarning, stacklevel=5)


def _every_row(component: Component, n_rows: int) -> Component:
    """A component with one row serves all."""
    if component.strength.size == n_rows:
        return component
    if component.strength.size != 1:
        raise SceneError(f"component {component.name!r} has {component.strength.size} rows for {n_rows} wavelengths")
    own = component.irradiance_W_m2_nm
    every = None if own is None else np.repeat(own, n_rows)
    return dataclasses.replace(component, strength=np.repeat(component.strength, n_rows), irradiance_W_m2_nm=every)


def require_sky_name(name: str) -> None:
    """Raise for a name that no sky has."""
    _, message, advice = value_problem("sky", "model", name)
    if message:
        raise UsageError(f"sky: {message}; {advice}")


def named_diffuse(name: str, options: Mapping[str, Any], entrance: Entrance) -> DiffuseSky | None:
    """The sky of this name, if it is one that needs no files; but for that of Perez."""
    from aomc_sky.formats.sky_models import installed_skies

    if name in installed_skies().plugins:
        from aomc_sky.source.light.plugin import choose_plugin

        return plugin_diffuse(choose_plugin(name, SkySection(), options, "", entrance))
    if name != "uniform":
        return None
    if options:
        raise UsageError("the sky model 'uniform' has no options")
    return uniform_diffuse()
