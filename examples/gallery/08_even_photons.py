"""
Even, and not in a pattern
==========================

Two thousand photons of one clear sky: drawn independently they leave gaps and clumps, ours have exact counts in every
patch and a sequence of low discrepancy inside.
"""

import matplotlib.pyplot as plt
import numpy as np

import aomc_sky as sky

model = sky.PerezSky(sun_zenith_deg=48, sun_azimuth_deg=55, epsilon=3, delta=0.15)
scene = sky.Scene(wavebands=[550], n_photons=2000, components=model)
figure, axes = plt.subplots(1, 2, figsize=(9, 5.2), layout="constrained")
for ax, (name, method) in zip(axes, [("independent", "iid"), ("ours, the default", "stratified")], strict=True):
    photons = scene.source(seed=1, method=method).photons(band=0)
    zenith = np.degrees(np.arccos(-photons.uz))  # a photon travels away from where it comes from
    azimuth = np.arctan2(-photons.uy, -photons.ux)
    sky.plot(model, ax=ax, cmap="Blues_r", limits=(0.1, 6))
    ax.plot(zenith * np.cos(azimuth), zenith * np.sin(azimuth), ".", color="black", markersize=2)
    ax.set_title(name)
