"""
Photons in a loop of numba
==========================

A sampler is inlined into your own compiled loop: here the light of a clear sky after refraction, counted by angle below
the surface. Beyond the critical angle there is none.
"""

import matplotlib.pyplot as plt
import numba
import numpy as np

import aomc_sky as sky

sample = sky.read_scene("../../inputs/clear_day").source(seed=1).numba_sampler(band=1).sample


@numba.njit
def below_the_surface(n, counts):
    for i in range(n):
        uz = sample(i)[2]
        angle = np.degrees(np.arcsin(np.sqrt(1 - uz * uz) / 1.34))
        counts[int(angle)] += 1


counts = np.zeros(60)
below_the_surface(1_000_000, counts)
figure, axis = plt.subplots(figsize=(7, 3.6), layout="constrained")
axis.stairs(counts / 1e4, np.arange(61), fill=True)
axis.axvline(np.degrees(np.arcsin(1 / 1.34)), color="black", linestyle=":", label="critical angle")
axis.set(xlabel="zenith angle below the surface [deg]", ylabel="photons [% per degree]", xlim=(0, 60))
axis.legend(frameon=False)
