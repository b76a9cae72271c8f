"""
A function of your own
======================

Any function of zenith angle, azimuth and wavelength is a sky: here blue above, white haze at the rim, and a glow
around the sun.
"""

import numpy as np

import aomc_sky as sky

SUN_ZENITH, SUN_AZIMUTH = np.radians(50), np.radians(40)


def radiance(zenith_rad, azimuth_rad, wavelength_nm):
    cosine = np.cos(zenith_rad) * np.cos(SUN_ZENITH)
    cosine = cosine + np.sin(zenith_rad) * np.sin(SUN_ZENITH) * np.cos(azimuth_rad - SUN_AZIMUTH)
    blue = (450 / wavelength_nm) ** 4
    haze = 0.25 / (np.cos(zenith_rad) + 0.12)
    return blue * (1 + cosine**2) + haze + 4 * np.exp(-9 * np.arccos(np.clip(cosine, -1, 1)))


scene = sky.Scene(wavebands=[440, 550, 670], n_photons=1_000_000, components=radiance)
figure = sky.plot(scene, caption=False)

# %%
# Photons of it are one line more. Each waveband has exactly the photons that were asked for.

photons = scene.source(seed=1).photons(band=0)
print(f"{len(photons.ux)} photons, mean cosine {-photons.uz.mean(dtype=float):.5f}")
