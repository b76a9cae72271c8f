"""Beam and sky of a scene as components in their shares."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from aomc_sky.component import Component, scaled
from aomc_sky.errors import SceneError
from aomc_sky.skies.direct_beam import SOLAR_RADIUS_DEG, DirectBeam
from aomc_sky.source.light.inputs import Sun


def beam_of(sun: Sun, fractions: np.ndarray) -> list[Component]:
    """The sun's beam with these strengths, if one of them is above 0."""
    if not np.any(fractions > 0):
        return []
    radius = SOLAR_RADIUS_DEG if sun.disc else 0.0
    beam = DirectBeam(sun_zenith_deg=sun.zenith_deg, sun_azimuth_deg=sun.azimuth_deg, radius_deg=radius)
    return scaled(beam.lower(fractions), fractions)


@dataclass(frozen=True, kw_only=True, slots=True)
class Diffuse:
    """The diffuse part of a scene: components of strength 1, with notes and options."""

    components: tuple[Component, ...] = ()
    notes: tuple[str, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)
    irradiance: tuple[float, ...] | None = None  #: of each waveband on a horizontal plane, where known [W m-2 nm-1]


def diffuse_of(components: Sequence[Component], name: str, fractions: np.ndarray, wavelength_nm: np.ndarray) -> Diffuse:
    """Components in their shares; their irradiances count where every waveband has some sky."""
    total = np.sum([c.strength for c in components], axis=0)
    dark = np.flatnonzero(~(total > 0) & (fractions > 0) & (fractions < 1))
    if dark.size:
        raise SceneError(
            f"{name} is dark at {wavelength_nm[dark[0]]:g} nm, but {1 - fractions[dark[0]]:g} of the light there is "
            "diffuse"
        )
    shares = [np.divide(c.strength, total, out=np.zeros_like(total), where=total > 0) for c in components]
    is_absolute = all(c.irradiance_W_m2_nm is not None for c in components) and bool(np.all(fractions < 1))
    return Diffuse(
        components=tuple(
            dataclasses.replace(c, strength=share, irradiance_W_m2_nm=None)
            for c, share in zip(components, shares, strict=True)
        ),
        irradiance=tuple(total.tolist()) if is_absolute else None,
    )
