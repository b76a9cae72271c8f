"""
The Moon before the sun
=======================

A partial eclipse: the Moon hides part of the disc from every point of the air, and what it leaves lights the sky.
"""

import aomc_sky as sky

scene = sky.read_scene("../../inputs/eclipse")
figure = sky.plot(scene, caption=False)
for component, irradiance in zip(scene.components, scene.irradiance.of_component[0], strict=True):
    print(f"{component.name}: {irradiance:.4f} W m-2 nm-1 of {scene.wavebands.wavelength_nm[0]:g} nm")
