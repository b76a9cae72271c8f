"""What the values of a background-sky file must fulfil, whether they are read or to be written."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aomc_sky.formats.background.data import NUMBERS, TEXTS, Animation, BackgroundFile, LobeType, ReferenceType

Add = Callable[[str, str, str, str], None]
"""Takes code, path in the file, what was found, what to write."""


def check_background(file: BackgroundFile, add: Add) -> None:
    """Report faults of values in arrays of the right shapes: the first of each kind and member, with their number."""
    if file.info.format_version != 1:
        found = f"format version {file.info.format_version}; version 1 is read"
        add("E509", "/Info/FormatVersion", found, "write 1")
    _check_spectra(file, add)
    for name, animation in file.animations.items():
        _check_animation(f"/LobeAnims/{name}/Lobes", animation, len(file.curves), add)


def check_storable(background: BackgroundFile, add: Add) -> None:
    """Report shapes that do not fit each other, names and texts that HDF5 does not hold, numbers too large."""
    shape = background.curves.shape
    if background.wavelength_nm.ndim != 1 or len(shape) != 2 or shape[1] != background.wavelength_nm.size or 0 in shape:
        found = f"shape {shape} with wavelengths of shape {background.wavelength_nm.shape}"
        add("E505", "curves", found, "give (curves, wavelengths) and (wavelengths,), both at least 1")
    for field in TEXTS.values():
        if not _is_text(getattr(background.info, field)):
            add("E505", field, "a text with NUL characters or lone surrogates", "leave them out")
    for field in NUMBERS.values():
        if not 0 <= getattr(background.info, field) < 2**32:
            add("E505", field, f"{getattr(background.info, field)}; allowed: 0 to 2^32 - 1", "write such a number")
    if not background.animations:
        add("E504", "animations", "no animation", "give at least one lobe")
    for name, keys in background.animations.items():
        if not _is_text(name) or "/" in name or name in ("", ".", ".."):
            add("E502", repr(name), "not a name of an animation", "leave out slashes and NUL, and give it letters")
        if not 0 <= keys.time_point_s < 2**64:
            found = f"time point {keys.time_point_s} s; allowed: 0 to 2^64 - 1"
            add("E507", name, found, "count from 1970-01-01 UTC")
        n = len(keys)
        columns = (keys.param0, keys.param1, keys.coefficient, keys.curve_index, keys.relative_time_days)
        if keys.lobe_type.ndim != 1 or any(c.shape != (n,) for c in columns) or keys.quaternion.shape != (n, 4):
            add("E505", name, "its arrays have different lengths", "use animation_of_lobes")


def _is_text(text: str) -> bool:
    return "\0" not in text and not any("\ud800" <= c <= "\udfff" for c in text)


def _check_spectra(file: BackgroundFile, add: Add) -> None:
    wavelength_um = file.wavelength_nm / 1e3
    good = np.isfinite(wavelength_um) & (wavelength_um > 0.0)
    where = "/SpectralSamples"
    _report(where, "wavelength", ~good, wavelength_um, "finite and above 0", "write micrometres", add, code="E506")
    if good.all():
        falls = np.append(False, np.diff(wavelength_um) <= 0.0)
        allowed = "above the one before it"
        _report(where, "wavelength", falls, wavelength_um, allowed, "sort samples and curves", add, code="E507")
    value = file.curves / 10.0
    bad = ~(np.isfinite(value) & (value >= 0.0))
    advice = "write W cm-2 um-1, integrated over the sphere"
    _report("/SpectralCurves", "value", bad, value, "finite and not negative", advice, add, code="E506")


def _check_animation(where: str, keys: Animation, n_curves: int, add: Add) -> None:
    if not len(keys):
        add("E505", where, "no lobe", "give at least one lobe")
        return
    known = np.isin(keys.lobe_type, list(LobeType))
    kinds = "1 (Henyey-Greenstein), 2 (VNDF-GGX) or 3 (VNDF-Beckmann)"
    _report(where, "Type", ~known, keys.lobe_type, kinds, "write one of these", add, code="E506")
    is_hg = keys.lobe_type == LobeType.HENYEY_GREENSTEIN
    bad = is_hg & ~((keys.param0 >= 0.0) & (keys.param0 < 1.0))
    advice = "turn a lobe of negative g round instead"
    _report(where, "Param0", bad, keys.param0, "at least 0 and below 1 (g)", advice, add, code="E506")
    for name, values in (("Param0", keys.param0), ("Param1", keys.param1)):
        bad = known & ~is_hg & ~(np.isfinite(values) & (values > 0.0))
        _report(where, name, bad, values, "finite and above 0 (alpha)", "write a roughness", add, code="E506")
    bad = ~(np.isfinite(keys.coefficient) & (keys.coefficient >= 0.0))
    _report(where, "Coeff", bad, keys.coefficient, "finite and not negative", "write a factor", add, code="E506")
    length = np.sqrt(np.sum(np.square(keys.quaternion), axis=1))
    bad = ~(np.abs(length - 1.0) < 1e-6)  # every usable one has been normalised
    allowed = "a finite quaternion (w, x, y, z) that is not 0"
    _report(where, "LocalTransform", bad, keys.quaternion, allowed, "(1, 0, 0, 0) turns nothing", add, code="E506")
    bad = (keys.curve_index < 0) | (keys.curve_index >= n_curves)
    allowed = f"below {n_curves}, the number of rows of /SpectralCurves; rows count from 0"
    _report(where, "CurveIndex", bad, keys.curve_index, allowed, "add the curve or correct the index", add, code="E508")
    _check_times(where, keys, add)


def _check_times(where: str, keys: Animation, add: Add) -> None:
    time, period = keys.relative_time_days, keys.reference.period_days
    finite = np.isfinite(time)
    inside = finite if keys.reference is ReferenceType.ABSOLUTE else finite & (time >= 0.0) & (time <= period)
    allowed = "finite" if keys.reference is ReferenceType.ABSOLUTE else f"0 to {period:g} inclusive"
    _report(where, "RelativeTime", ~inside, time, allowed, "write days, not seconds or hours", add, code="E507")
    if inside.all():
        falls = np.append(False, np.diff(time) < 0.0)
        _report(where, "RelativeTime", falls, time, "not before the lobe above", "sort the lobes", add, code="E507")


def _report(
    where: str, name: str, bad: np.ndarray, values: np.ndarray, allowed: str, advice: str, add: Add, *, code: str
) -> None:
    """Report the first of the bad values and how many there are."""
    n_bad = int(np.count_nonzero(bad))
    if not n_bad:
        return
    index = tuple(int(k) for k in np.argwhere(bad)[0])
    value = values[index]
    found = f"({', '.join(f'{v:.7g}' for v in value)})" if np.ndim(value) else f"{value:.7g}"
    others = f", and {n_bad - 1} more like it" if n_bad > 1 else ""
    position = ", ".join(str(k) for k in index)
    add(code, where, f"{name} [{position}] is {found}{others}; allowed: {allowed}", advice)
