"""Sky tables of AMC and MCPL files, without a scene."""

from aomc_sky.formats.aomc.skydist import SkyTable as SkyTable
from aomc_sky.formats.aomc.skydist import read_skydist as read_skydist
from aomc_sky.formats.aomc.skydist import write_skydist as write_skydist
from aomc_sky.formats.mcpl.file import read_mcpl as read_mcpl

__all__ = ["SkyTable", "read_mcpl", "read_skydist", "write_skydist"]
