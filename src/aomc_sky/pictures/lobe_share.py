"""Lobes in pictures: their shares of patches, where they are, how wide, and what is said of them."""

from __future__ import annotations

import math

from aomc_sky.component import Component
from aomc_sky.skies.lobe_share import lobe_of, lobe_share

__all__ = ["axis_and_width_deg", "lobe_note", "lobe_share"]


def lobe_note(bins: tuple[int, int]) -> str:
    """What a picture says of lobes drawn on equal bins of zenith and azimuth."""
    size = f"{90.0 / bins[0]:g}° x {360.0 / bins[1]:g}°"
    return f"Lobes have no patches of their own: each is drawn by its exact mean in patches of {size}."


def axis_and_width_deg(component: Component) -> tuple[float, float, float]:
    """Zenith angle and azimuth of the axis, and how wide the lobe is about it. [deg]

    The width is twice the angle that holds half the lobe, of the narrower way where it has two.
    """
    kind, first, second, rotation = lobe_of(component)
    x, y, z = rotation[:, 2].tolist()
    if kind == "hg":
        half = 2.0 * math.asin((1.0 - first) * math.sqrt(2.0 + first) / 2.0)
    else:
        half = math.atan(min(first, second) * (1.0 if kind == "ggx" else math.sqrt(math.log(2.0))))
    place = math.degrees(math.atan2(math.hypot(x, y), z)), math.degrees(math.atan2(y, x)) % 360.0
    return *place, 2.0 * math.degrees(half)
