"""
Weather: three Perez skies
==========================

Two irradiances and the height of the sun make a sky of any weather, from the all-weather model of Perez.
"""

import matplotlib.pyplot as plt
import numpy as np

import aomc_sky as sky

figure, axes = plt.subplots(1, 3, figsize=(9, 3.4), subplot_kw={"projection": "polar"}, layout="constrained")
azimuth, zenith = np.meshgrid(np.radians(np.arange(0, 361, 2)), np.radians(np.arange(0, 90.1, 1)))
for axis, (name, dni, dhi) in zip(axes, [("clear", 850, 95), ("hazy", 500, 280), ("overcast", 5, 220)], strict=True):
    model = sky.PerezSky(sun_zenith_deg=45, sun_azimuth_deg=60, dni=dni, dhi=dhi)
    radiance = model.radiance(zenith, azimuth, 550.0)
    axis.pcolormesh(azimuth, np.degrees(zenith), np.log10(radiance), cmap="viridis", shading="gouraud")
    axis.set(title=f"{name}: DNI {dni}, DHI {dhi} W m$^{{-2}}$", xticks=[], yticks=[])
