"""
Twilight
========

Molecules and aerosol under a sun 3 degrees below the horizon, solved by paths through spherical shells, in absolute
units. Where hardly a path reaches air in sunlight, a warning says so.
"""

import aomc_sky as sky

scene = sky.read_scene("../../inputs/twilight")
figure = sky.plot(scene, caption=False, scale="each")
for nm, irradiance in zip(scene.wavebands.wavelength_nm, scene.irradiance.of_component[:, 0], strict=True):
    print(f"{nm:g} nm: {irradiance:.5f} W m-2 nm-1 on the sea")
print(scene.notes[-1])
