"""Skies of lobes, and their components, from a line for each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

import aomc_sky as sky
from aomc_sky.component import Component


def lobe_sky(
    *shapes: tuple[str, float, float, ArrayLike],
    names: Sequence[str] | None = None,
    wavelength_nm: ArrayLike = (400.0, 700.0),
    spectra: ArrayLike = (1e-9, 3e-9),
) -> sky.LobeSky:
    """Lobes of (kind, param0, param1, quaternion), with spectra of their own or one for all."""
    rows = np.broadcast_to(np.asarray(spectra, float), (len(shapes), np.size(wavelength_nm)))
    lobes = (
        sky.WeightedLobe(
            name=name, kind=kind, param0=a, param1=b, quaternion=np.asarray(turn), wavelength_nm=wavelength_nm,
            spectrum=row,
        )
        for name, (kind, a, b, turn), row in zip(names or [shape[0] for shape in shapes], shapes, rows, strict=True)
    )  # fmt: skip
    return sky.LobeSky(lobes=tuple(lobes))


def lobe_components(
    *,
    names: Sequence[str],
    kinds: Sequence[str],
    param0: Sequence[float],
    param1: Sequence[float],
    quaternion: Sequence[ArrayLike] | np.ndarray,
    irradiance: ArrayLike,
) -> tuple[Component, ...]:
    shapes = zip(kinds, param0, param1, quaternion, strict=True)
    nm = 500.0 + np.arange(np.shape(irradiance)[1])
    return lobe_sky(*shapes, names=names, wavelength_nm=nm, spectra=irradiance).lower(nm)
