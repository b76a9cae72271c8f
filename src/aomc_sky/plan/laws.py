"""The laws by their numbers in a plan: the one place of the spine that names those of slices."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from aomc_sky.component import Law
from aomc_sky.skies.cell_law import CellLaw

_LAWS = {
    Law.CELL_MU2: "aomc_sky.skies.cell_law:CELL_MU2",
    Law.CELL_MU: "aomc_sky.skies.cell_law:CELL_MU",
    Law.BEAM: "aomc_sky.skies.cell_law:BEAM",
    Law.DISC: "aomc_sky.skies.cell_law:DISC",
    Law.DISC_AT_HORIZON: "aomc_sky.skies.cell_law:DISC_AT_HORIZON",
    Law.PEREZ: "aomc_sky.skies.perez.law:PEREZ",
    Law.HG: "aomc_sky.skies.lobes.law:LOBE",
    Law.GGX: "aomc_sky.skies.lobes.law:LOBE",
    Law.BECKMANN: "aomc_sky.skies.lobes.law:LOBE",
}


@cache
def law_of(number: Law) -> CellLaw:
    """The law of a number; the module of a slice is imported when the first plan or scene has its law."""
    module, _, name = _LAWS[number].partition(":")
    law: CellLaw = getattr(import_module(module), name)
    return law
