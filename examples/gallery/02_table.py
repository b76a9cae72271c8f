"""
A table of radiances
====================

Values over patches, as a camera or another program gives them: here clouds over blue. ``weighting="projected"`` says
that they are radiances; without it they are shares of the photons, as in skydist.inp.
"""

import numpy as np

import aomc_sky as sky

grid = sky.PatchGrid.regular(90, 180)
zenith, azimuth = np.meshgrid(np.radians(np.arange(0.5, 90)), np.radians(np.arange(1, 360, 2)), indexing="ij")
x, y = 2.2 * zenith * np.cos(azimuth), 2.2 * zenith * np.sin(azimuth)
waves = np.sin(2 * x + 1.5 * np.sin(1.4 * y)) + np.sin(2.3 * y + 1.5 * np.cos(1.7 * x))
waves += 0.3 * np.sin(5 * x - 4 * y)
cloud = 1 / (1 + np.exp(-4 * waves))
values = (1 - cloud) * (0.25 + 0.2 * zenith**2) + cloud * (1.4 - 0.3 * zenith)
table = sky.TabulatedSky(wavelength_nm=[550], values=values[None], grid=grid, weighting="projected")

scene = sky.Scene(wavebands=[550], n_photons=100_000, components=table)
figure = sky.plot(scene, cmap="Blues_r", caption=False)
