"""Light-source flag 0: the direct beam and the diffuse sky that difcol.inp shares photons between."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.formats.amc import AmcConfig
from aomc_sky.formats.difcol import DifcolTable
from aomc_sky.sampling.allocation import AllocationMethod
from aomc_sky.skies import sky_model
from aomc_sky.skies.direct_beam import DirectBeam
from aomc_sky.source.sampling_options import Order, Placement, SamplingOptions
from aomc_sky.source.scene import MAX_PHOTONS
from aomc_sky.wavebands import Wavebands

AOMC_INTERNAL_PRESET = SamplingOptions(
    allocation=AllocationMethod.MULTINOMIAL, placement=Placement.PHILOX, order=Order.SHUFFLED
)


def internal_scene_parts(
    config: AmcConfig,
    bands: Wavebands,
    difcol: DifcolTable,
    *,
    sky: str | None,
    weighting: str | None,
    compat: str | None,
) -> dict[str, Any]:
    """Return components, photons, rows, notes and options of a scene with light-source flag 0."""
    if weighting not in (None, "projected", "solid-angle", "aomc"):
        raise UsageError(f"weighting {weighting!r} is for sky files; a sky model has 'projected' or 'solid-angle'")
    per_solid_angle = bool(compat) or weighting == "solid-angle"
    model = "uniform" if compat else sky
    rows = np.unique(difcol.direct_fraction, return_inverse=True)
    fractions, row_of_band = rows[0], rows[1].ravel()
    components: list[Component] = []
    if np.any(fractions > 0):
        beam = DirectBeam(sun_zenith_deg=config.direct_zenith_deg, sun_azimuth_deg=config.direct_azimuth_deg)
        components += _with_strength(beam.lower(fractions), fractions)
    if np.any(fractions < 1):
        components += _with_strength(_diffuse(model, per_solid_angle, fractions), 1.0 - fractions)
    intensity = difcol.intensity
    n_photons = _program_photons(intensity, config) if compat else _photons(intensity, config.iterations)
    used_sky = model if np.any(fractions < 1) else None
    return {
        "components": tuple(components),
        "n_photons": n_photons,
        "row_of_band": row_of_band,
        "notes": _notes(difcol, used_sky),
        "options": {"sky": used_sky, "weighting": "solid-angle" if per_solid_angle else "projected"},
        **({"preset": AOMC_INTERNAL_PRESET} if compat else {}),
    }


def _diffuse(model: str | None, per_solid_angle: bool, fractions: np.ndarray) -> tuple[Component, ...]:
    if model is None:
        raise UsageError(
            "light-source flag 0 needs the Perez sky for its diffuse light, which is not part of this version; "
            "write --sky uniform (sky='uniform' in Python) for a uniform diffuse sky"
        )
    components: tuple[Component, ...] = sky_model(model)(per_solid_angle=per_solid_angle).lower(fractions)
    return components


def _with_strength(components: tuple[Component, ...], strength: np.ndarray) -> list[Component]:
    return [
        Component(
            name=c.name,
            law=c.law,
            strength=strength * c.strength,
            mass=c.mass,
            cell=c.cell,
            grid=c.grid,
            weight=c.weight,
        )
        for c in components
    ]


def _photons(intensity: np.ndarray, iterations: int) -> np.ndarray:
    """Round-half-up of intensity x iterations, exact in the decimals of the file."""
    exact = [math.floor(Fraction(repr(float(x))) * iterations + Fraction(1, 2)) for x in intensity]
    if max(exact) > MAX_PHOTONS:
        raise SceneError(f"intensity x iterations must not exceed 2^62 photons in a band, got {max(exact)}")
    return np.array(exact, dtype=np.int64)


def _program_photons(intensity: np.ndarray, config: AmcConfig) -> np.ndarray:
    """The program's NINT of a product of 32-bit floats."""
    product = intensity.astype(np.float32) * np.float32(config.iterations)
    return np.floor(product.astype(np.float64) + 0.5).astype(np.int64)


def _notes(difcol: DifcolTable, used_sky: str | None) -> tuple[str, ...]:
    if used_sky is None:
        return ("difcol.inp: all light is direct, so no sky is modelled",)
    low, high = float(difcol.direct_fraction.min()), float(difcol.direct_fraction.max())
    shown = f"{low:g}" if low == high else f"{low:g} to {high:g}"
    return (f"difcol.inp: direct fraction {shown}, the rest from a {used_sky} sky",)
