"""What the winning inputs of the Perez sky mean: shares of beam and sky, and what difcol.inp stands in for."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from aomc_sky.errors import InputFileError, InputWarning, Problem, SceneError, UsageError
from aomc_sky.formats.amc import DifcolTable
from aomc_sky.formats.sky_toml.keys import PerezSection
from aomc_sky.source.light.inputs import DIFCOL, PerezInputs, Sun

MEDIAN_DELTA = (0.18, 0.30, 0.31, 0.29, 0.25, 0.18, 0.14, 0.09)
"""Median sky brightness of each bin of clearness in 15 900 hours (Z < 85 degrees) of four public weather files."""

_THREE_LINES = (
    "[perez]\ndni = 850.0    # direct normal irradiance, W m-2\ndhi = 95.0     # diffuse horizontal irradiance, W m-2"
)


def direct_fraction(inputs: PerezInputs, sun: Sun) -> float | None:
    """Share of the beam, dni cos Z / (dni cos Z + dhi); None where coefficients are all that is given. [0 to 1]"""
    section = inputs.section
    if section.coefficients is not None:
        return None
    if section.epsilon is not None:
        from aomc_sky.skies.perez.functions import sky_clearness

        per_ratio = float(sky_clearness(1.0, 1.0, math.radians(sun.zenith_deg))) - 1.0
        beam, diffuse = (section.epsilon - 1.0) / per_ratio * sun.cosine, 1.0
    else:
        beam, diffuse = (section.dni or 0.0) * sun.cosine, diffuse_irradiance(inputs, sun)
    if beam + diffuse == 0:
        raise SceneError(f"{inputs} leave no light at all")
    return 1.0 if beam + diffuse == math.inf else beam / (beam + diffuse)


def diffuse_irradiance(inputs: PerezInputs, sun: Sun) -> float:
    """Diffuse horizontal irradiance, also from ghi and dni. [W m-2]"""
    section = inputs.section
    if section.dhi is not None:
        return section.dhi
    beam = (section.dni or 0.0) * sun.cosine
    diffuse = (section.ghi or 0.0) - beam
    if diffuse < -1e-9 * beam:
        raise SceneError(
            f"{inputs} leave less than nothing for the sky: dni cos Z is {beam:g} W m-2 with "
            f"the sun at {sun.zenith_deg:g} degrees; check that ghi and dni are of the same hour"
        )
    return max(diffuse, 0.0)


def irradiances(inputs: PerezInputs, sun: Sun) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance; of epsilon and Delta at the sun's mean distance. [W m-2]"""
    section = inputs.section
    if section.epsilon is None:
        return section.dni or 0.0, diffuse_irradiance(inputs, sun)
    from aomc_sky.skies.perez.functions import sky_brightness, sky_clearness

    zenith = math.radians(sun.zenith_deg)
    diffuse = (section.delta or 0.0) / float(sky_brightness(1.0, zenith))
    return (section.epsilon - 1.0) / (float(sky_clearness(1.0, 1.0, zenith)) - 1.0) * diffuse, diffuse


def model_inputs(inputs: PerezInputs, sun: Sun) -> dict[str, Any]:
    """Arguments of `PerezSky`: coefficients, epsilon and delta, or dni and dhi."""
    section = inputs.section
    if section.coefficients is not None:
        return {"coefficients": section.coefficients}
    if section.epsilon is not None:
        return {"epsilon": section.epsilon, "delta": section.delta}
    diffuse = diffuse_irradiance(inputs, sun)
    if diffuse == 0:
        raise SceneError(
            f"{inputs} leave no light for the sky, but bands have diffuse light; give a "
            "positive diffuse irradiance, or direct fractions of 1"
        )
    return {"dni": section.dni, "dhi": diffuse}


def difcol_of_inputs(inputs: PerezInputs | None, sun: Sun, path: str, n_wavebands: int) -> DifcolTable:
    """What difcol.inp would say where it is absent: one direct fraction, intensity 1."""
    fraction = None if inputs is None else direct_fraction(inputs, sun)
    if fraction is None:
        raise InputFileError([_nothing_tells(path, inputs)])
    return DifcolTable(direct_fraction=np.full(n_wavebands, fraction), intensity=np.ones(n_wavebands))


def _nothing_tells(path: str, inputs: PerezInputs | None) -> Problem:
    reason = "nothing else tells" if inputs is None else f"{inputs.text} do not tell"
    return Problem(
        path=path,
        line=0,
        column=0,
        code="E100",
        field="",
        message=f"there is no such file, and {reason} how much of the light is direct",
        advice=f"write difcol.inp, or these lines into sky.toml beside amc.inp:\n\n{_THREE_LINES}\n",
    )


def missing_inputs() -> UsageError:
    """The error for a Perez sky instead of a sky file, without inputs; with the three lines to write."""
    return UsageError(
        "--sky perez instead of skydist.inp needs dni and dhi (or epsilon and delta, or a to e): give them as options, "
        f"or write into sky.toml beside amc.inp\n\n{_THREE_LINES}\n"
    )


def inputs_of_difcol(difcol: DifcolTable, sun: Sun) -> PerezInputs:
    """Sky clearness of the photons' mean direct fraction f, and the median brightness of its bin.

    epsilon = 1 + [f / ((1 - f) cos Z)] / (1 + 1.041 Z^3), Delta of `MEDIAN_DELTA`; at least one band with light has a
    direct fraction below 1. Always warns: wavebands are not the whole spectrum.
    """
    from aomc_sky.skies.perez.functions import epsilon_bin, sky_clearness

    weight = difcol.intensity if np.any(difcol.intensity > 0) else np.ones_like(difcol.intensity)
    weight = weight / weight.max()  # sums of huge intensities stay finite
    mean = float(np.sum(weight * difcol.direct_fraction) / np.sum(weight))
    diffuse = float(np.sum(weight * (1.0 - difcol.direct_fraction)) / np.sum(weight))
    epsilon = float(sky_clearness(mean / sun.cosine, diffuse, math.radians(sun.zenith_deg)))
    delta = MEDIAN_DELTA[int(epsilon_bin(epsilon))]
    warnings.warn(
        "difcol.inp: the sky's clearness follows from the direct fraction; bands within 400 to 700 nm understate it, "
        "often by a bin; dni and dhi in sky.toml or as options are better",
        InputWarning,
        stacklevel=2,
    )
    text = f"the mean direct fraction {mean:.4g} and the median brightness of that clearness"
    return PerezInputs(section=PerezSection(epsilon=epsilon, delta=delta), origin=DIFCOL, text=text)
