"""Where the marks of a dome stand: beams, the sun, narrow lobes."""

from __future__ import annotations

from collections.abc import Iterable

from aomc_sky.component import Component, Law, beam_direction_deg
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.content import Mark, Symbol
from aomc_sky.pictures.domes.lobe_share import axis_and_width_deg

BEAMS = (Law.BEAM, Law.DISC, Law.DISC_AT_HORIZON)
"""Laws of light without patches that comes from one place."""


def marks_of(
    components: Iterable[Component], grid: PatchGrid, sun_deg: tuple[float, float] | None = None
) -> tuple[Mark, ...]:
    """Marks of components: beams, lobes narrower than a ring of `grid`, and the sun where no beam shows it.

    A given sun stands for a beam's position and that of a Perez sky.
    """
    marks, perez_sun = [], None
    for component in components:
        place = beam_direction_deg(component)
        if place is not None and component.law in BEAMS:
            marks.append(Mark(zenith_deg=place[0], azimuth_deg=place[1], symbol=Symbol.BEAM))
        if component.law is Law.PEREZ and component.shared is not None:
            perez_sun = 90.0 * float(component.shared[5]), 90.0 * float(component.shared[6])
        marks += narrow_lobe(component, grid) if component.law.is_lobe else []
    sun = sun_deg or perez_sun
    if sun is not None and not any(mark.symbol is Symbol.BEAM for mark in marks):
        marks.append(sun_mark(*sun))
    return tuple(marks)


def narrow_lobe(component: Component, grid: PatchGrid) -> list[Mark]:
    """The mark of a lobe of which half lies within less than the width of a ring around an axis above the horizon."""
    zenith, azimuth, width = axis_and_width_deg(component)
    if width >= 90.0 / grid.n_zenith or zenith > 90.0:
        return []
    return [Mark(zenith_deg=zenith, azimuth_deg=azimuth, symbol=Symbol.LOBE)]


def sun_mark(zenith_deg: float, azimuth_deg: float) -> Mark:
    """The sun without light of its own, above the horizon or below it."""
    symbol = Symbol.SUN if zenith_deg <= 90.0 else Symbol.SUN_BELOW
    return Mark(zenith_deg=zenith_deg, azimuth_deg=azimuth_deg, symbol=symbol)
