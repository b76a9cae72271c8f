"""
Weather: three Perez skies
==========================

Two irradiances and the height of the sun make a sky of any weather: direct normal (DNI), diffuse horizontal (DHI), in
W m-2. A clear sky is bright around the sun and at the rim, an overcast one overhead.
"""

import matplotlib.pyplot as plt

import aomc_sky as sky

figure, axes = plt.subplots(1, 3, figsize=(9, 4.5), layout="constrained")
for ax, (name, dni, dhi) in zip(axes, [("clear", 850, 95), ("hazy", 500, 280), ("overcast", 5, 220)], strict=True):
    model = sky.PerezSky(sun_zenith_deg=45, sun_azimuth_deg=60, dni=dni, dhi=dhi)
    sky.plot(model, ax=ax, limits=(12, 320))
    ax.set_title(f"{name}: DNI {dni}, DHI {dhi}")
label = "radiance [W m$^{-2}$ sr$^{-1}$], log scale"
bar = figure.colorbar(ax.collections[-1], ax=axes, orientation="horizontal", label=label, shrink=0.5)
bar.set_ticks([20, 50, 100, 200], labels=["20", "50", "100", "200"])
bar.minorticks_off()
