"""A scene in the making: what shines, and what to say of it, before wavebands and files are joined to it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import SceneError
from aomc_sky.sampling.allocation import MAX_PHOTONS
from aomc_sky.source.irradiance import Irradiance
from aomc_sky.source.options import SamplingOptions
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneDraft:
    """What a table, a sky model, an atmosphere or backgrounds make of a scene; fields as `Scene` has them."""

    components: tuple[Component, ...]
    n_photons: np.ndarray
    row_of_band: np.ndarray
    sky_wavelength_nm: np.ndarray = None  # type: ignore[assignment]
    notes: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    preset: SamplingOptions = field(default_factory=SamplingOptions)
    irradiance: Irradiance | None = None

    def scene(self, wavebands: Wavebands, **others: Any) -> Scene:
        """The scene; `others` are the fields that a draft has not."""
        return Scene(
            wavebands=wavebands,
            components=self.components,
            n_photons=self.n_photons,
            row_of_band=self.row_of_band,
            sky_wavelength_nm=self.sky_wavelength_nm,
            notes=self.notes,
            options=self.options,
            preset=self.preset,
            irradiance=self.irradiance,
            **others,
        )


def photons_of_intensity(intensity: np.ndarray, iterations: int) -> np.ndarray:
    """Round-half-up of intensity x iterations, exact in the decimals of the file."""
    exact = [math.floor(Fraction(repr(float(x))) * iterations + Fraction(1, 2)) for x in intensity]
    if max(exact) > MAX_PHOTONS:
        raise SceneError(f"intensity x iterations must not exceed 2^62 photons in a band, got {max(exact)}")
    return np.array(exact, dtype=np.int64)
