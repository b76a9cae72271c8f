"""Perez skies typed from Table 1 by hand, and how photons are compared with the continuous law."""

from dataclasses import dataclass

import numpy as np

from tests.reference import perez_law
from tests.reference.perez_law import PerezLaw
from tests.support import chi2

ZENITH_EDGES_DEG = np.linspace(0, 90, 37)
AZIMUTH_EDGES_DEG = np.linspace(0, 360, 73)
CONE_RINGS = 24
CONE_SECTORS = 24
KS_RADIUS_RAD = np.deg2rad(3.0)


@dataclass(frozen=True, slots=True)
class PerezCase:
    """A sky by its inputs, and its coefficients from eqs. (6) to (8) at 9 decimals; the limits change none."""

    epsilon: float
    delta: float
    sun_zenith_deg: float
    coefficients: tuple[float, float, float, float, float]

    @property
    def law(self):
        return PerezLaw(coefficients=self.coefficients, sun_zenith_rad=float(np.deg2rad(self.sun_zenith_deg)))


CASES = {
    "narrow aureole": PerezCase(6.8, 0.02, 40, (-1.016291408, -0.228699069, 20.790475197, -6.672752355, 1.096377910)),
    "bright overcast": PerezCase(1.03, 0.5, 30, (0.707019955, -0.162213345, 4.640085147, -1.894591360, -0.055364176)),
    "turbid, low sun": PerezCase(5.5, 0.14, 64, (-0.986132764, -0.242156235, 13.290483556, -3.876723805, 0.509631067)),
}
"""On patches of 10 degrees the sun stands on an edge in the first two, and inside a patch in the last."""

CLIPPED = {
    "dark around the sun": PerezLaw(
        coefficients=(-0.7295225793545204, -2.6019002430716784, -2.881273326026232, -2.8056797546629864, 0.38285433395),
        sun_zenith_rad=float(np.deg2rad(5)),
        tolerance=1e-6,
    ),
    "dark overhead": PerezLaw(coefficients=(-1.2, -0.1, 8.0, -4.0, 0.3), sun_zenith_rad=0.9, tolerance=1e-6),
}
"""Skies with negative values: row 4 of Table 1 at Delta = 0.6, and a first factor below 0 over most of the sky."""


def cell_counts(mu, u, azimuth):
    """Photons in the cells of zenith angle and azimuth from the sun; angles by arctan2, sharp at both ends."""
    zenith = np.rad2deg(np.arctan2(np.sqrt(u), mu))
    azimuth = np.mod(np.rad2deg(azimuth), 360.0)
    return np.histogram2d(zenith, azimuth, bins=[ZENITH_EDGES_DEG, AZIMUTH_EDGES_DEG])[0]


def cell_shares(law):
    return perez_law.patch_shares(law, ZENITH_EDGES_DEG, AZIMUTH_EDGES_DEG)


def cell_p(law, mu, u, azimuth):
    return chi2.chi2_p(cell_counts(mu, u, azimuth), cell_shares(law) * mu.size)


def cone_p(law, gamma, psi):
    """Chi-square in rings and sectors around the sun, narrower towards it, the rest of the sky one cell."""
    radius = min(np.pi / 2 - law.sun_zenith_rad, np.pi / 4)
    edges = radius * np.linspace(0, 1, CONE_RINGS + 1) ** 2
    seen = np.histogram2d(gamma, psi, bins=[edges, np.linspace(0, 2 * np.pi, CONE_SECTORS + 1)])[0]
    share = perez_law.cone_shares(law, edges, CONE_SECTORS)
    observed = np.append(seen, gamma.size - seen.sum())
    return chi2.chi2_p(observed, np.append(share, 1 - share.sum()) * gamma.size)


def photon_p_values(law, mu, u, azimuth):
    """p-values of independent photons (azimuths from the sun) against quadrature of the continuous law."""
    gamma, psi = perez_law.around_the_sun(law, mu, u, azimuth)
    beside = gamma[gamma < KS_RADIUS_RAD]
    towards, aside = np.sqrt(u) * np.cos(azimuth), np.sqrt(u) * np.sin(azimuth)
    return {
        "cells": cell_p(law, mu, u, azimuth),
        "cone": cone_p(law, gamma, psi),
        "beside the sun": chi2.ks_p(perez_law.cone_places(law, beside, KS_RADIUS_RAD)),
        "mean mu": chi2.mean_p(mu, perez_law.mean(law, lambda x, y, mu: mu)),
        "mean towards the sun": chi2.mean_p(towards, perez_law.mean(law, lambda x, y, mu: x)),
        "mean aside": chi2.mean_p(aside, 0.0),
    }
