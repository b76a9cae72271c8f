"""
Twilight
========

Molecules and aerosol under a sun 3 degrees below the horizon, solved in spherical shells, in absolute units.
"""

import aomc_sky as sky

scene = sky.read_scene("../../inputs/twilight")
figure = sky.plot(scene)
print(scene.irradiance)
