"""Lobes and the files of background skies: functions of the laws, and what a file is made of."""

from aomc_sky.skies.lobes.background import BackgroundSky as BackgroundSky
from aomc_sky.skies.lobes.file.data import SkyLobe as SkyLobe
from aomc_sky.skies.lobes.file.data import background_of_lobes as background_of_lobes
from aomc_sky.skies.lobes.file.file import read_background_file as read_background_file
from aomc_sky.skies.lobes.file.file import write_background as write_background
from aomc_sky.skies.lobes.functions import KINDS as KINDS
from aomc_sky.skies.lobes.functions import mass_above_horizon as mass_above_horizon
from aomc_sky.skies.lobes.functions import patch_mass as patch_mass
from aomc_sky.skies.lobes.functions import pdf as pdf
from aomc_sky.skies.lobes.functions import rotation_matrix as rotation_matrix
from aomc_sky.skies.lobes.functions import sample as sample
from aomc_sky.skies.lobes.functions import to_local as to_local
from aomc_sky.skies.lobes.functions import to_world as to_world
from aomc_sky.skies.lobes.sky import WeightedLobe as WeightedLobe

__all__ = [
    "KINDS",
    "BackgroundSky",
    "SkyLobe",
    "WeightedLobe",
    "background_of_lobes",
    "mass_above_horizon",
    "patch_mass",
    "pdf",
    "read_background_file",
    "rotation_matrix",
    "sample",
    "to_local",
    "to_world",
    "write_background",
]
