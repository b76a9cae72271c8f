"""
A day of skies
==============

The sun's path over Helgoland at midsummer, and the clear sky of each time.
"""

import matplotlib.pyplot as plt

import aomc_sky as sky

figure, axes = plt.subplots(2, 4, figsize=(9, 5), layout="constrained")
for ax, hour in zip(axes.flat, range(4, 20, 2), strict=True):
    sun = sky.sun_position(f"2026-06-21T{hour:02d}:00Z", latitude_deg=54.18, longitude_deg=7.89)
    place = {"sun_zenith_deg": sun.apparent_zenith_deg, "sun_azimuth_deg": sun.azimuth_deg}
    sky.plot(sky.PerezSky(epsilon=6, delta=0.12, **place), ax=ax, limits=(0.3, 10))
    ax.set_title(f"{hour:02d}:00 UTC")
figure.colorbar(axes[0, 0].collections[-1], ax=axes, label="relative radiance, log scale", shrink=0.7)
