"""
A table of radiances
====================

Values over patches, as a camera or another program gives them: here broken clouds. ``weighting="projected"`` says that
they are radiances; without it they are shares of the photons, as in skydist.inp.
"""

import numpy as np

import aomc_sky as sky

grid = sky.PatchGrid.regular(45, 180)
zenith, azimuth = np.meshgrid(np.radians(np.arange(1, 90, 2)), np.radians(np.arange(1, 360, 2)), indexing="ij")
x, y = np.tan(0.85 * zenith) * np.cos(azimuth), np.tan(0.85 * zenith) * np.sin(azimuth)
waves = np.sin(5 * x + 2 * np.sin(3 * y)) + np.sin(6 * y + 2 * np.cos(4 * x)) + 0.5 * np.sin(13 * x - 9 * y)
cloud = 1 / (1 + np.exp(-6 * waves))
values = (1 - cloud) * (0.3 + 0.5 * zenith**2) + cloud * (1.3 - 0.4 * zenith)
table = sky.TabulatedSky(wavelength_nm=[550], values=values[None], grid=grid, weighting="projected")

figure = sky.plot(sky.Scene(wavebands=[550], n_photons=100_000, components=table))
