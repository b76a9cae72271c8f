"""
Counts too even to be chance
============================

A pull is (photons - expected) / sqrt(expected), a patch at a time. Independent photons have pulls of size one; ours are
within one photon of what each patch should get, and ``aomc-sky verify`` asks for that of every patch.
"""

import matplotlib.pyplot as plt
import numpy as np

import aomc_sky as sky

scene = sky.read_scene("../../inputs/clear_day")
figure, axis = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, method in {"independent photons": "iid", "ours, the default": "stratified"}.items():
    source = scene.source(seed=1, method=method)
    expected, counts = source.expected(0), source.counts[0]
    is_lit = expected > 0
    pull = (counts[is_lit] - expected[is_lit]) / np.sqrt(expected[is_lit])
    axis.hist(pull, np.linspace(-4.5, 4.5, 91), label=f"{name}, largest {np.abs(pull).max():.2f}", alpha=0.7)
axis.set(xlabel="pull of a patch", ylabel="patches", yscale="log")
axis.legend(frameon=False)
