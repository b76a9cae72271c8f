"""PythonicDISORT as a peer: one Rayleigh layer over a Lambertian ground."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np

from aomc_sky.extras import optional_module


def rayleigh_disort(
    n_stream: int, tau: float, mu0: float, ground_albedo: float
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Radiance at the ground for the sun's irradiance 1, of zenith angles and azimuths from the sun. [sr-1]"""
    # its own warning: conservative scattering may be unstable; at 1 - 1e-7 it is the reference's choice
    warnings.filterwarnings("ignore", message="Some delta-scaled single-scattering albedos")
    pydisort = optional_module("PythonicDISORT", extra="bench")
    from PythonicDISORT.subroutines import interpolate

    moments = np.zeros((1, n_stream))
    moments[0, 0], moments[0, 2] = 1.0, 0.1
    ground = {"BDRF_Fourier_modes": [ground_albedo]} if ground_albedo else {}

    def radiance(zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        *_, u = pydisort.pydisort(tau, 1.0 - 1e-7, n_stream, moments, mu0, 1.0, 0.0, NFourier=3, **ground)
        return interpolate(u)(-np.cos(zenith), tau, azimuth)

    return radiance
