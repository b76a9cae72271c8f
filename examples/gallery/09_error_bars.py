"""
Error bars from replicates
==========================

A run shared among 16 independent replicates knows its own error. Ours falls about ten times for ten times the photons,
that of independent photons three times.
"""

import matplotlib.pyplot as plt
import numpy as np

import aomc_sky as sky

numbers = [10_000, 100_000, 1_000_000]
figure, axis = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, method in (("independent photons", "iid"), ("ours, the default", "stratified")):
    errors = []
    for n in numbers:
        source = sky.read_scene("../../inputs/clear_day", iterations=n).source(seed=1, replicates=16, method=method)
        ranges = [source.replicate_range(0, replicate) for replicate in range(16)]
        means = [-source.photons(0, start, stop).uz.mean(dtype=float) for start, stop in ranges]
        errors.append(np.std(means, ddof=1) / 4)
    axis.loglog(numbers, errors, "o-", label=name)
axis.set(xlabel="photons", ylabel="standard error of the mean cosine")
axis.legend(frameon=False)
