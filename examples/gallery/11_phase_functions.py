"""
Phase functions, and samples of them
====================================

Rayleigh and Henyey-Greenstein scattering: the exact density as a line, a million samples as steps.
"""

import matplotlib.pyplot as plt
import numpy as np

from aomc_sky import henyey_greenstein, rayleigh

gamma = rayleigh.air_gamma(550)
xi = np.random.default_rng(1).random(1_000_000)
mu = np.linspace(-1, 1, 400)
figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
for label, law, sample in (
    ("Rayleigh, air", rayleigh.pdf_sr(mu, gamma), rayleigh.sample_mu(xi, gamma)),
    ("Henyey-Greenstein, g = 0.5", henyey_greenstein.pdf_sr(1 - mu, 0.5), henyey_greenstein.sample_mu(xi, 0.5)),
    ("Henyey-Greenstein, g = 0.8", henyey_greenstein.pdf_sr(1 - mu, 0.8), henyey_greenstein.sample_mu(xi, 0.8)),
):
    (line,) = axis.semilogy(mu, law, label=label)
    density, edges = np.histogram(sample, bins=40, range=(-1, 1), density=True)
    axis.stairs(density / (2 * np.pi), edges, color=line.get_color(), alpha=0.3, fill=True, baseline=1e-3)
axis.set(xlabel="cosine of the scattering angle", ylabel="density [1/sr]", xlim=(-1, 1), ylim=(4e-3, 5))
axis.legend(frameon=False)
