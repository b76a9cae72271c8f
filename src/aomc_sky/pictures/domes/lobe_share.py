"""Lobes in pictures: their shares of patches, where they are, how wide, and what is said of them."""

from __future__ import annotations

import math

import numpy as np

from aomc_sky.component import Component
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.domes.narrow_lobe import needle_share
from aomc_sky.skies.lobes.frame import lobe_of
from aomc_sky.skies.lobes.patches import patch_shares

_NARROW_RINGS = 2.0


def lobe_share(component: Component, grid: PatchGrid) -> np.ndarray:
    """Share of the flux of a lobe that comes through each patch, sum 1, shape (n_patch,).

    Exact as `patch_shares` is; of a lobe narrower than two rings as `needle_share` is.
    """
    kind, first, second, rotation = lobe_of(component)
    if _width_deg(kind, first, second) < _NARROW_RINGS * 90.0 / grid.n_zenith:
        return needle_share(kind, first, second, rotation, grid)
    return patch_shares(component, grid)


def lobe_note(bins: tuple[int, int]) -> str:
    """What a picture says of lobes drawn on equal bins of zenith and azimuth."""
    size = f"{90.0 / bins[0]:g}° x {360.0 / bins[1]:g}°"
    return f"Lobes have no patches of their own: each is drawn by its mean in patches of {size}."


def axis_and_width_deg(component: Component) -> tuple[float, float, float]:
    """Zenith angle and azimuth of the axis, and how wide the lobe is about it. [deg]

    The width is twice the angle that holds half the lobe, of the narrower way where it has two.
    """
    kind, first, second, rotation = lobe_of(component)
    x, y, z = rotation[:, 2].tolist()
    place = math.degrees(math.atan2(math.hypot(x, y), z)), math.degrees(math.atan2(y, x)) % 360.0
    return *place, _width_deg(kind, first, second)


def _width_deg(kind: str, first: float, second: float) -> float:
    """Twice the angle about the axis that holds half of a lobe, of the narrower way where it has two. [deg]"""
    if kind == "hg":
        half = 2.0 * math.asin((1.0 - first) * math.sqrt(2.0 + first) / 2.0)
    else:
        half = math.atan(min(first, second) * (1.0 if kind == "ggx" else math.sqrt(math.log(2.0))))
    return 2.0 * math.degrees(half)
