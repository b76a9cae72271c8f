"""
A day of skies
==============

The sun's path of a place and the hours of a weather file: how much of the light goes down steeply, through one day.
"""

import matplotlib.pyplot as plt

import aomc_sky as sky

figure, axis = plt.subplots(figsize=(7, 3.6), layout="constrained")
hours, steep = [], []
for row in range(6, 20):
    weather = {"epw": "../../inputs/weather/two_days.epw", "row": row}
    source = sky.read_scene("../../inputs/perez_sky", weather=weather, iterations=20_000).source(seed=1)
    hours.append(row - 0.5)
    steep.append(-source.photons(0).uz.mean(dtype=float))
axis.plot(hours, steep, "o-")
axis.set(xlabel="hour of the day", ylabel="mean cosine at the surface", ylim=(0, 1))
