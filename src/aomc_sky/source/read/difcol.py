"""A scene lit by the sun and a sky model (light-source flag 0): how the bands share photons between the two."""

from __future__ import annotations

import dataclasses
import math
import warnings
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError
from aomc_sky.formats.amc.amc_inp import AmcConfig
from aomc_sky.formats.amc.band_files import DifcolTable
from aomc_sky.sampling.allocation import MAX_PHOTONS, AllocationMethod
from aomc_sky.skies.direct_beam import SOLAR_RADIUS_DEG, DirectBeam
from aomc_sky.skies.registry import sky_model
from aomc_sky.source.light.inputs import DIFCOL, PerezInputs, SkyInputs, Sun
from aomc_sky.source.light.perez import direct_fraction, inputs_of_difcol, model_inputs
from aomc_sky.source.options import Order, Placement, SamplingOptions

AOMC_INTERNAL_PRESET = SamplingOptions(
    allocation=AllocationMethod.MULTINOMIAL, placement=Placement.PHILOX, order=Order.SHUFFLED
)


def internal_scene_parts(
    config: AmcConfig,
    difcol: DifcolTable,
    inputs: SkyInputs,
    *,
    split: str,
    sky: str | None,
    weighting: str | None,
    compat: str | None,
) -> dict[str, Any]:
    """Return components, photons, rows, notes and options of a scene lit by the sun and a sky model.

    Parameters
    ----------
    config : AmcConfig
        amc.inp.
    difcol : DifcolTable
        Direct fraction and intensity of every band.
    inputs : SkyInputs
        The sun, and the weather where it is given.
    split : str
        Where the direct fractions come from, for the notes.
    sky : {"perez", "uniform"}, optional
        Law of the diffuse light; None is "perez", and "uniform" under `compat`.
    weighting, compat : str, optional
        As `read_scene` has them.
    """
    if weighting not in (None, "projected", "solid-angle", "aomc"):
        raise UsageError(f"weighting {weighting!r} is for sky files; a sky model has 'projected' or 'solid-angle'")
    per_solid_angle = bool(compat) or weighting == "solid-angle"
    rows = np.unique(difcol.direct_fraction, return_inverse=True)
    fractions, row_of_band = rows[0], rows[1].ravel()
    components: list[Component] = []
    if np.any(fractions > 0):
        components += _with_strength(_beam(inputs.sun).lower(fractions), fractions)
    model = ("uniform" if compat else sky or "perez") if has_diffuse_light(difcol) else None
    diffuse = Diffuse()
    if model == "perez":
        diffuse = _perez(inputs, difcol, weighting, fractions)
    elif model is not None:
        diffuse = Diffuse(components=sky_model(model)(per_solid_angle=per_solid_angle).lower(fractions))
    components += _with_strength(diffuse.components, 1.0 - fractions)
    intensity = difcol.intensity
    return {
        "components": tuple(components),
        "n_photons": _program_photons(intensity, config)
        if compat
        else photons_of_intensity(intensity, config.iterations),
        "row_of_band": row_of_band,
        "notes": (_split_note(difcol, model, split, inputs), *diffuse.notes),
        "options": {
            "sky": model,
            "weighting": "solid-angle" if per_solid_angle else "projected",
            "sun": inputs.sun.as_options(),
            **diffuse.options,
        },
        **({"preset": AOMC_INTERNAL_PRESET} if compat else {}),
    }


@dataclass(frozen=True, kw_only=True, slots=True)
class Diffuse:
    """The diffuse part of a scene: components of strength 1, and what to tell about them."""

    components: tuple[Component, ...] = ()
    notes: tuple[str, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)


def has_diffuse_light(difcol: DifcolTable) -> bool:
    """Whether a band with light, or any band where none has, leaves a part of it to the sky."""
    lit = difcol.intensity > 0
    return bool(np.any(difcol.direct_fraction[lit if lit.any() else slice(None)] < 1))


def _beam(sun: Sun) -> DirectBeam:
    radius = SOLAR_RADIUS_DEG if sun.disc else 0.0
    return DirectBeam(sun_zenith_deg=sun.zenith_deg, sun_azimuth_deg=sun.azimuth_deg, radius_deg=radius)


def _perez(inputs: SkyInputs, difcol: DifcolTable, weighting: str | None, fractions: np.ndarray) -> Diffuse:
    """The Perez sky, with what it limited kept for the manifest besides being warned of."""
    if weighting not in (None, "projected"):
        raise UsageError(
            f"the Perez sky sends photons through the horizontal sea surface; weighting {weighting!r} does not; "
            "leave --weighting out, or write --sky uniform"
        )
    weather = inputs.perez or inputs_of_difcol(difcol, inputs.sun)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        sky = sky_model("perez")(
            sun_zenith_rad=math.radians(inputs.sun.zenith_deg),
            sun_azimuth_rad=math.radians(inputs.sun.azimuth_deg),
            **inputs.model,
            **model_inputs(weather, inputs.sun),
        )
        components = sky.lower(fractions)
    for warning in caught:
        warnings.warn(warning.message, stacklevel=2)
    limited = [str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning)]
    shown = {
        "epsilon": None if sky.clearness is None else float(sky.clearness),
        "delta": None if sky.brightness is None else float(sky.brightness),
        "coefficients": [float(c) for c in sky.model_coefficients],
        **inputs.model,
        "from": str(weather),
        "limited": limited,
    }
    return Diffuse(components=components, notes=(_perez_note(shown, weather),), options={"perez": shown})


def _perez_note(shown: dict[str, Any], weather: PerezInputs) -> str:
    if shown["epsilon"] is None or (weather.section.epsilon is not None and weather.origin != DIFCOL):
        return f"Perez sky: {weather}"  # the text has the numbers already
    return f"Perez sky: epsilon {shown['epsilon']:.4g}, Delta {shown['delta']:.4g}, from {weather}"


def _with_strength(components: tuple[Component, ...], strength: np.ndarray) -> list[Component]:
    return [dataclasses.replace(c, strength=strength * c.strength) for c in components]


def photons_of_intensity(intensity: np.ndarray, iterations: int) -> np.ndarray:
    """Round-half-up of intensity x iterations, exact in the decimals of the file."""
    exact = [math.floor(Fraction(repr(float(x))) * iterations + Fraction(1, 2)) for x in intensity]
    if max(exact) > MAX_PHOTONS:
        raise SceneError(f"intensity x iterations must not exceed 2^62 photons in a band, got {max(exact)}")
    return np.array(exact, dtype=np.int64)


def _program_photons(intensity: np.ndarray, config: AmcConfig) -> np.ndarray:
    """The program's NINT of a product of 32-bit floats."""
    product = intensity.astype(np.float32) * np.float32(config.iterations)
    return np.floor(product.astype(np.float64) + 0.5).astype(np.int64)


def _split_note(difcol: DifcolTable, used_sky: str | None, split: str, inputs: SkyInputs) -> str:
    if used_sky is None:
        return f"{split}: all light is direct, so no sky is modelled"
    low, high = float(difcol.direct_fraction.min()), float(difcol.direct_fraction.max())
    shown = f"{low:g}" if low == high else f"{low:g} to {high:g}"
    given = inputs.perez if split == DIFCOL and used_sky == "perez" else None
    other = None if given is None else direct_fraction(given, inputs.sun)
    hint = "" if given is None or other is None else f" ({given.text} alone: {other:.3g})"
    return f"{split}: direct fraction {shown}{hint}, the rest from a {used_sky} sky"
