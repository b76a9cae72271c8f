"""Checks of animations and spectra, one for skies of files and for those that are made by hand.

Faults have the names and the units of the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from aomc_sky.errors import InputFileError, SceneError
from aomc_sky.formats.radiance_words import MAX_RADIANCE, doubt_of_gaps
from aomc_sky.formats.report import Report, printable
from aomc_sky.skies.lobes.file.data import Animation, LobeType, ReferenceType, normalised

NM_PER_UM = 1e3
SI_PER_FILE_UNIT = 10.0  #: W m-2 nm-1 in one W cm-2 um-1.


def check_sky(
    animations: Mapping[str, Animation], wavelength_nm: np.ndarray, curves: np.ndarray, report: Report
) -> None:
    """Report faults of animations and their spectra: the first of each kind and member, with their number."""
    shape = wavelength_nm.shape
    if len(shape) != 1 or shape == (0,) or curves.ndim != 2 or curves.shape[1:] != shape:
        message = f"shape {curves.shape} with wavelengths of shape {shape}"
        advice = "give (curves, wavelengths) and (wavelengths,), both at least 1"
        add(report, "E505", "/SpectralCurves", message, advice)
        return
    _check_spectra(wavelength_nm / NM_PER_UM, curves / SI_PER_FILE_UNIT, report)
    for name, animation in animations.items():
        _check_animation(f"/LobeAnims/{name}/Lobes", animation, len(curves), report)


def close_by_hand(report: Report) -> None:
    """Raise all errors of what is made by hand, as a SceneError."""
    try:
        report.close()
    except InputFileError as error:
        raise SceneError(str(error)) from None


def add(report: Report, code: str, name: str, message: str, advice: str) -> None:
    """Note a problem of a member."""
    report.add(code, message, name=printable(name), advice=advice)


def _check_spectra(wavelength_um: np.ndarray, value: np.ndarray, report: Report) -> None:
    check = partial(_add_first, report, "/SpectralSamples", "wavelength", unit=" um")
    good = np.isfinite(wavelength_um) & (wavelength_um > 0.0)
    check("E506", ~good, wavelength_um, "finite and above 0", "write micrometres")
    if good.all():
        decreases = np.append(False, np.diff(wavelength_um) <= 0.0)
        check("E507", decreases, wavelength_um, "above the one before it", "sort samples and curves")
    check = partial(_add_first, report, "/SpectralCurves", "value", unit=" W cm-2 um-1")
    bad = ~(np.isfinite(value) & (value >= 0.0))
    right = "write W cm-2 um-1, integrated over the sphere"
    check("E506", bad, value, "finite and not negative", right)
    if good.all() and value.size and not bad.any() and (doubt := doubt_of_gaps(value)):
        advice = "write a value for each wavelength, or leave it out"
        add(report, "E506", "/SpectralCurves", doubt[0].replace("radiance", "value"), advice)
    is_fill = np.isfinite(value) & (value > MAX_RADIANCE)
    check("E506", is_fill, value, f"up to {MAX_RADIANCE:g}, no fill value", right)


def _check_animation(where: str, keys: Animation, n_curves: int, report: Report) -> None:
    n = len(keys)
    columns = (keys.param0, keys.param1, keys.coefficient, keys.curve_index, keys.relative_time_days)
    if keys.lobe_type.ndim != 1 or any(c.shape != (n,) for c in columns) or keys.quaternion.shape != (n, 4):
        add(report, "E505", where, "its arrays have different lengths", "give one value for each key")
        return
    if not n:
        add(report, "E505", where, "no lobe", "give at least one lobe")
        return
    check = partial(_add_first, report, where)
    known = np.isin(keys.lobe_type, list(LobeType))
    kinds = "1 (Henyey-Greenstein), 2 (VNDF-GGX) or 3 (VNDF-Beckmann)"
    check("Type", "E506", ~known, keys.lobe_type, kinds, "write one of these")
    is_hg = keys.lobe_type == LobeType.HENYEY_GREENSTEIN
    allowed = "at least 0 and below 1 (g)"
    negative = is_hg & (keys.param0 < 0.0)
    check("Param0", "E506", negative, keys.param0, allowed, "turn the lobe around instead of a negative g")
    bad = is_hg & ~negative & ~(keys.param0 < 1.0)
    check("Param0", "E506", bad, keys.param0, allowed, "write at most 0.9999999; the file holds 32-bit floats")
    for name, values in (("Param0", keys.param0), ("Param1", keys.param1)):
        bad = known & ~is_hg & ~(np.isfinite(values) & (values > 0.0))
        check(name, "E506", bad, values, "finite and above 0 (alpha)", "write a roughness")
    bad = ~(np.isfinite(keys.coefficient) & (keys.coefficient >= 0.0))
    check("Coeff", "E506", bad, keys.coefficient, "finite and not negative", "write a factor")
    length = np.sqrt(np.sum(np.square(normalised(keys.quaternion)), axis=1))
    bad = ~(np.abs(length - 1.0) < 1e-6)  # what is no rotation stays as it is
    allowed = "a finite quaternion (w, x, y, z) that is not 0"
    check("LocalTransform", "E506", bad, keys.quaternion, allowed, "(1, 0, 0, 0) turns nothing")
    bad = (keys.curve_index < 0) | (keys.curve_index >= n_curves)
    allowed = f"below {n_curves}, the number of rows of /SpectralCurves; rows count from 0"
    check("CurveIndex", "E508", bad, keys.curve_index, allowed, "add the curve or correct the index")
    time = keys.relative_time_days
    inside, allowed = np.isfinite(time), "finite"
    if keys.reference is not ReferenceType.ABSOLUTE:
        period = 1.0 if keys.reference is ReferenceType.DIURNAL else 7.0
        inside &= (time >= 0.0) & (time <= period)
        allowed = f"0 to {period:g} inclusive"
    check("RelativeTime", "E507", ~inside, time, allowed, "write days, not seconds or hours")
    if inside.all():
        decreases = np.append(False, np.diff(time) < 0.0)
        check("RelativeTime", "E507", decreases, time, "not before the lobe above", "sort the lobes")


def _add_first(
    report: Report,
    where: str,
    name: str,
    code: str,
    bad: np.ndarray,
    values: np.ndarray,
    allowed: str,
    advice: str,
    unit: str = "",
) -> None:
    """Report the first of the bad values and how many there are."""
    n_bad = int(np.count_nonzero(bad))
    if not n_bad:
        return
    index = tuple(int(k) for k in np.argwhere(bad)[0])
    value = values[index]
    message = f"({', '.join(f'{v:.7g}' for v in value)})" if np.ndim(value) else f"{value:.7g}{unit}"
    others = f", and {n_bad - 1} more like it" if n_bad > 1 else ""
    position = ", ".join(str(k) for k in index)
    add(report, code, where, f"{name} [{position}] is {message}{others}; allowed: {allowed}", advice)
