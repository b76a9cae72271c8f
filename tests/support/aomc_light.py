"""The law of examples/fortran/aomc_light.f90 in numpy: angles of the source as the AOMC program wants them."""

from __future__ import annotations

import re

import numpy as np

from tests.support.host_programs import EXAMPLES

FULL_TURN = np.float32(2) * np.float32(3.14159265)
"""2 pi of the program, where its last azimuth bin ends."""


def constant(name: str) -> np.float32:
    """A constant of single precision as the Fortran text has it."""
    text = (EXAMPLES / "fortran" / "aomc_light.f90").read_text()
    found = re.findall(rf"real, parameter :: {name} = ([0-9.]+)", text)
    assert len(found) == 1, f"{name} stands {len(found)} times in aomc_light.f90"
    return np.float32(found[0])


def free_azimuth(ux: np.ndarray, uy: np.ndarray) -> np.ndarray:
    """Azimuth of the source in single precision before `below_full_turn` is looked at. [0 to 2 pi, both there]"""
    return np.mod(np.arctan2(-uy.astype(np.float64), -ux.astype(np.float64)), 2 * np.pi).astype(np.float32)


def light_azimuth(ux: np.ndarray, uy: np.ndarray) -> np.ndarray:
    """Azimuth of the source, float32. [0 to 6.283184]"""
    return np.minimum(free_azimuth(ux, uy), constant("below_full_turn"))


def light_zenith(ux: np.ndarray, uy: np.ndarray, uz: np.ndarray) -> np.ndarray:
    """Zenith angle of the source, float32. [0 to 1.570796]"""
    x, y, z = (-u.astype(np.float64) for u in (ux, uy, uz))
    return np.minimum(np.arctan2(np.sqrt(x * x + y * y), z).astype(np.float32), constant("below_horizon"))


def azimuth_bin(phi: np.ndarray, n_bins: np.ndarray | int) -> np.ndarray:
    """The program's azimuth bin, from 1, in its own single precision; beyond n_bins it writes outside its array."""
    width = FULL_TURN / np.asarray(n_bins, dtype=np.float32)
    return (phi / width).astype(np.int64) + 1
