"""Components of lobes from columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

import aomc_sky as sky
from aomc_sky.component import Component


def lobe_components(
    *,
    names: Sequence[str],
    kinds: Sequence[str],
    param0: Sequence[float],
    param1: Sequence[float],
    quaternion: Sequence[ArrayLike] | np.ndarray,
    irradiance: ArrayLike,
) -> tuple[Component, ...]:
    light = np.asarray(irradiance, dtype=np.float64)
    wavelength_nm = 500.0 + np.arange(light.shape[1])
    lobes = tuple(
        sky.WeightedLobe(
            name=name,
            kind=kind,
            param0=first,
            param1=second,
            quaternion=np.asarray(turn),
            wavelength_nm=wavelength_nm,
            spectrum=row,
        )
        for name, kind, first, second, turn, row in zip(names, kinds, param0, param1, quaternion, light, strict=True)
    )
    return sky.LobeSky(lobes=lobes).lower(wavelength_nm)
