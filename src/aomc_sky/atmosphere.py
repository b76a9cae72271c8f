"""What an atmosphere is made of, what lights it, and what its solver gives."""

from aomc_sky.skies.atmosphere.description.reader import read_atmo as read_atmo
from aomc_sky.skies.atmosphere.lights import Moon as Moon
from aomc_sky.skies.atmosphere.medium import Constituent as Constituent
from aomc_sky.skies.atmosphere.medium import Medium as Medium
from aomc_sky.skies.atmosphere.medium import rayleigh_cross_section as rayleigh_cross_section
from aomc_sky.skies.atmosphere.sky.solve import AtmosphereResult as AtmosphereResult

__all__ = ["AtmosphereResult", "Constituent", "Medium", "Moon", "rayleigh_cross_section", "read_atmo"]
