"""Where a beam or a disc stands in the sky, from the parameters of its cell."""

from __future__ import annotations

import math

from aomc_sky.component import Component, Law


def beam_direction_deg(component: Component) -> tuple[float, float] | None:
    """Zenith angle and azimuth of a beam or of the centre of a disc, within 1e-9 degrees; None for patches. [deg]"""
    if component.grid is not None or component.n_cells != 1:
        return None
    first, second, third, fourth, sine, cosine = component.cell[0].tolist()
    if component.law is Law.BEAM:
        zenith = math.atan2(math.sqrt(first), math.sqrt(third))
    elif component.law is Law.DISC:
        zenith = math.atan2(first, second)
    elif component.law is Law.DISC_AT_HORIZON:
        zenith = math.acos(fourth)
    else:
        return None
    return math.degrees(zenith), math.degrees(math.atan2(sine, cosine)) % 360.0
