"""Maps of pulls: where photons lie off what is expected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.content import PULL, Dome, Picture
from aomc_sky.pictures.source_domes import spread

_SMALL = "Independent photons would give pulls of size 1; photons that a plan spreads evenly give smaller ones."


def pull_picture(maps: Sequence[tuple[str, PatchGrid, np.ndarray]], *, title: str = "") -> Picture:
    """Maps of pulls side by side, 12 spread over them where there are more.

    Parameters
    ----------
    maps : sequence of (str, PatchGrid, ndarray)
        Title, zones and pulls of each; NaN where nothing is expected, or too little to say.
    title : str
        Of the picture.

    Returns
    -------
    Picture
        Colours part at zero.
    """
    chosen = [maps[k] for k in spread(range(len(maps)))]
    domes = tuple(Dome(grid=grid, values=values.ravel(), title=name) for name, grid, values in chosen)
    hidden = len(maps) - len(chosen)
    notes = (_SMALL, f"{len(maps)} wavebands, {len(chosen)} of them shown.") if hidden else (_SMALL,)
    return Picture(domes=domes, quantity=PULL, title=title, notes=notes)
