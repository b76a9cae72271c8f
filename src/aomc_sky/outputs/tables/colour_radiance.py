"""Tristimulus values X, Y, Z and scotopic luminance W of a spectral radiance."""

from __future__ import annotations

import warnings

import numpy as np

from aomc_sky.errors import ModelLimitWarning, UsageError
from aomc_sky.extras import optional_module

EXTRA = "colour"
"""The extra that installs colour-science."""

PHOTOPIC_LM_W, SCOTOPIC_LM_W = 683.0, 1700.0
"""Luminous efficacies at the peaks of the eye's daylight and night functions. [lm W-1]"""

COMPONENTS = ("X", "Y", "Z", "W")

_TABLE_NM = np.arange(360.0, 831.0)
_WIDEST_STEP_NM = 20.0
_MISSED = 0.01


def require_colour() -> None:
    """Fail before the work where colour-science is not installed."""
    optional_module("colour", extra=EXTRA)


def xyzw_weights(wavelength_nm: np.ndarray) -> np.ndarray:
    """Factors (n_wl, 4) by which spectral radiances at rising wavelengths add up to X, Y, Z and W.

    In cd m-2 per W m-2 sr-1 nm-1: Y is the luminance with 683 lm W-1, W the scotopic one with 1700 lm W-1.
    The spectrum is linear between the wavelengths and zero outside them. Its products with the CIE 1931 2-degree
    colour-matching functions and the CIE 1951 scotopic function are summed in steps of 1 nm, 360 to 830 nm
    (CIE 15:2018, section 7.1), so that wide steps of the radiance do not cut the functions.
    """
    between = np.stack([np.interp(_TABLE_NM, wavelength_nm, row, 0.0, 0.0) for row in np.eye(wavelength_nm.size)])
    return between @ _eye()


def check_wavelengths(wavelength_nm: np.ndarray) -> None:
    """Refuse rising wavelengths that no colour follows from, and warn of those that it follows from badly.

    Refused: fewer than two. Warned of: steps wider than 20 nm, or more than 1 % of an equal-energy spectrum's
    X, Y, Z or W outside the wavelengths.
    """
    require_colour()
    if wavelength_nm.size < 2:
        raise UsageError("X, Y, Z and W are sums over a spectrum: they need two wavelengths or more")
    widest = float(np.diff(wavelength_nm).max())
    inside = xyzw_weights(wavelength_nm).sum(axis=0) / _eye().sum(axis=0)
    if widest > _WIDEST_STEP_NM:
        text = f"wavelengths are up to {widest:.4g} nm apart; X, Y, Z and W want {_WIDEST_STEP_NM:g} nm or less"
        warnings.warn(text, ModelLimitWarning, stacklevel=2)
    if inside.min() < 1.0 - _MISSED:
        missed = ", ".join(f"{name} {100 * (1 - share):.2g} %" for name, share in zip(COMPONENTS, inside, strict=True))
        text = f"of an even spectrum so much lies outside the wavelengths and is missing: {missed}"
        warnings.warn(text, ModelLimitWarning, stacklevel=2)


def xyzw(radiance: np.ndarray, wavelength_nm: np.ndarray) -> np.ndarray:
    """X, Y, Z and W, (..., 4) [cd m-2], of spectral radiances (..., n_wl) [W m-2 sr-1 nm-1]."""
    return np.asarray(radiance @ xyzw_weights(wavelength_nm))


def _eye() -> np.ndarray:
    """Colour-matching functions and scotopic function with their efficacies and the step, (n, 4). [lm W-1 nm]"""
    colour = optional_module("colour", extra=EXTRA)
    matching = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    night = optional_module("colour.colorimetry", extra=EXTRA).SDS_LEFS["CIE 1951 Scotopic Standard Observer"]
    columns = [
        PHOTOPIC_LM_W * np.interp(_TABLE_NM, matching.wavelengths, matching.values[:, k], 0.0, 0.0) for k in range(3)
    ]
    columns.append(SCOTOPIC_LM_W * np.interp(_TABLE_NM, night.wavelengths, night.values, 0.0, 0.0))
    return np.stack(columns, axis=1)
