"""Maps of pulls: where photons lie off what is expected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.content import PULL, Dome, Picture
from aomc_sky.pictures.domes.source import spread

_SMALL = "Independent photons would give pulls of size 1; photons that a plan spreads evenly give smaller ones."

PLANNED = (
    "Pulls are against the counts of the plan, which spreads photons evenly: a correct map is white. "
    "Independent photons would give pulls of size 1."
)
DRAWN = "Pulls are against the masses, from which the counts were drawn: correct photons give pulls of size 1."


def pull_picture(maps: Sequence[tuple[str, PatchGrid, np.ndarray]], *, title: str = "", note: str = _SMALL) -> Picture:
    """Maps of pulls side by side, 12 spread over them where there are more; colours part at zero.

    Each is a title, its zones and their pulls: NaN where nothing is expected, or too little to say. `note` says what
    size of pulls to expect.
    """
    chosen = [maps[k] for k in spread(range(len(maps)))]
    domes = tuple(Dome(grid=grid, values=values.ravel(), title=name) for name, grid, values in chosen)
    hidden = len(maps) - len(chosen)
    notes = (note, f"{len(maps)} wavebands, {len(chosen)} of them shown.") if hidden else (note,)
    return Picture(domes=domes, quantity=PULL, title=title, notes=notes)
