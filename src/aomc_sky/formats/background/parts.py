"""The members of a background-sky file made into animations and spectra."""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.formats.background.data import (
    INFORMING,
    LOBE,
    NM_PER_UM,
    NUMBERS,
    OPTIONAL,
    SI_PER_FILE_UNIT,
    TEXTS,
    Animation,
    BackgroundFile,
    BackgroundInfo,
    LobeType,
    ReferenceType,
    frozen,
    normalised,
)
from aomc_sky.formats.background.hdf5_members import Hdf5Members, printable
from aomc_sky.formats.report import Report

_LIKE = "write it as docs/formats/background.md has it"
MAX_EXPECTED_UM = 100.0
"""A shortest wavelength beyond this one is more likely given in nanometres. [um]"""
_MOST_DIGITS = 10
"""Of a file type that is written as a text."""
_INTEGERS = ("Type", "CurveIndex", "TimePoint")


def background_of_members(members: Hdf5Members, report: Report) -> BackgroundFile | None:
    """Put a file together without the animations that are reported (E504, E505); None where its spectra are.

    Its values are not checked.
    """
    info = _info(members, report)
    animations = _animations(members, report)
    spectra = _spectra(members, report)
    if spectra is None:
        return None
    wavelength, curves = spectra
    return BackgroundFile(
        info=info,
        animations=animations,
        wavelength_nm=frozen(wavelength * NM_PER_UM),
        curves=frozen(curves * SI_PER_FILE_UNIT),
    )


def _spectra(members: Hdf5Members, report: Report) -> tuple[np.ndarray, np.ndarray] | None:
    """Wavelengths (n_wavelength,) and curves (n_curve, n_wavelength) in the units of the file."""
    wavelength = _plain(members, "SpectralSamples", report)
    curves = _plain(members, "SpectralCurves", report)
    if wavelength is None or curves is None:
        return None
    wavelength = wavelength.reshape(-1) if sum(n != 1 for n in wavelength.shape) <= 1 else wavelength
    if curves.ndim == 1 and curves.shape == wavelength.shape:
        curves = curves[np.newaxis]
    if wavelength.ndim != 1 or curves.ndim != 2 or curves.shape[1] != wavelength.size or curves.size == 0:
        found = f"shape {curves.shape} with SpectralSamples of shape {wavelength.shape}"
        allowed = "allowed: (curves, wavelengths) and (1, wavelengths), both at least 1"
        report.add("E505", f"{found}; {allowed}", name="/SpectralCurves", advice="one row per curve")
        return None
    if wavelength.min() > MAX_EXPECTED_UM:
        found = f"the wavelengths begin at {wavelength.min():g} micrometres, far beyond light"
        advice = "divide them by 1000 if they are nanometres"
        report.add("E506", found, name="/SpectralSamples", advice=advice, is_warning=True)
    return wavelength, curves


def _animations(members: Hdf5Members, report: Report) -> dict[str, Animation]:
    """The animations by name, in the order of their names, without those that are reported."""
    paths = sorted(n for n in members.names if n.startswith("LobeAnims/") and n.count("/") == 1)
    group = "/LobeAnims"
    if not paths and not any(p.field.startswith(group) for p in report.problems):
        report.add("E504", "no animation, or no such group", name=group, advice="give at least one lobe")
    found = {path.removeprefix("LobeAnims/"): _animation(members, path, report) for path in paths}
    return {name: animation for name, animation in found.items() if animation is not None}


def _info(members: Hdf5Members, report: Report) -> BackgroundInfo:
    """What the file says of itself; only its format version is a reason to refuse it."""
    values: dict[str, Any] = {}
    for name, field in (*NUMBERS.items(), *TEXTS.items()):
        paths = [f"Info/{name}", f"@{name}"]
        value = next((v for p in paths if (v := _info_value(members, p, is_number=name in NUMBERS)) is not None), None)
        if value is not None:
            values[field] = value
        elif _is_reported(report, f"Info/{name}") or any(p.field == f"attribute {name}" for p in report.problems):
            continue
        elif any(_is_there(members, p) for p in paths):
            wanted = "one whole number" if name in NUMBERS else "one text"
            is_warning = f"Info/{name}" in INFORMING
            message = f"wanted {wanted}" + (f"; {_default(field)!r} is taken" if is_warning else "")
            report.add("E505", message, name=f"/Info/{name}", advice=_LIKE, is_warning=is_warning)
        elif name not in OPTIONAL:
            message = f"missing, here and among the attributes of the root; {_default(field)!r} is taken"
            report.add("E504", message, name=f"/Info/{name}", advice="write it", is_warning=True)
    return BackgroundInfo(**values)


def _is_there(members: Hdf5Members, path: str) -> bool:
    """Whether there is such a member, be it a group or a record, whose parts have names of their own."""
    held = (path in some for some in (members.names, members.arrays, members.texts))
    return any(held) or any(name.startswith(f"{path}/") for name in members.arrays)


def _info_value(members: Hdf5Members, path: str, *, is_number: bool) -> int | str | None:
    """What a member of /Info says, as the number or the text that is wanted; None where it cannot be taken as one."""
    array, text = members.arrays.get(path), members.texts.get(path)
    if not is_number:
        return text if array is None else ", ".join(f"{value:.15g}" for value in array.reshape(-1).tolist())
    if array is not None and array.size == 1:
        value = array.reshape(-1)[0]
        return int(value) if np.isfinite(value) and value == int(value) else None
    if text is not None and path in INFORMING and text.isdecimal() and len(text) <= _MOST_DIGITS:
        return int(text)
    return None


def _default(field: str) -> object:
    return getattr(BackgroundInfo(), field)


def _plain(members: Hdf5Members, path: str, report: Report) -> np.ndarray | None:
    """An array of numbers as float64; None and a report where it is not there."""
    found = members.arrays.get(path)
    if found is not None:
        return found.astype(np.float64)
    if _is_reported(report, path):
        return None
    if path not in members.names:
        report.add("E504", "there is no such dataset", name=f"/{path}", advice=_LIKE)
    else:
        report.add("E505", "it is not a dataset of plain numbers", name=f"/{path}", advice=_LIKE)
    return None


def _is_reported(report: Report, path: str) -> bool:
    return any(p.field == printable(f"/{path}") for p in report.problems)


def _animation(members: Hdf5Members, path: str, report: Report) -> Animation | None:
    lobes = _record(members, f"{path}/Lobes", tuple(LOBE.names or ()), report)
    reference = _record(members, f"{path}/ReferenceTime", ("Type", "TimePoint"), report)
    if lobes is None or reference is None:
        return None
    kind = int(reference["Type"][0]) if reference["Type"].size == 1 else 0
    if kind not in list(ReferenceType):
        found = f"Type is {kind}" if reference["Type"].size == 1 else f"{reference['Type'].size} records, wanted 1"
        allowed = "allowed: 1 (absolute), 2 (diurnal) or 3 (hebdomadal)"
        shown = printable(f"/{path}/ReferenceTime")
        report.add("E506", f"{found}; {allowed}", name=shown, advice="write one record of these types")
        return None
    is_hg = lobes["Type"] == LobeType.HENYEY_GREENSTEIN
    return Animation(
        lobe_type=frozen(np.clip(lobes["Type"], 0, 255).astype(np.uint8)),
        param0=frozen(lobes["Param0"].astype(np.float64)),
        param1=frozen(np.where(is_hg, 0.0, lobes["Param1"]).astype(np.float64)),
        coefficient=frozen(lobes["Coeff"].astype(np.float64)),
        quaternion=normalised(lobes["LocalTransform"].astype(np.float64)),
        curve_index=frozen(np.minimum(lobes["CurveIndex"], np.iinfo(np.int64).max).astype(np.int64)),
        relative_time_days=frozen(lobes["RelativeTime"].astype(np.float64)),
        reference=ReferenceType(kind),
        time_point_s=int(reference["TimePoint"][0]),
    )


def _record(members: Hdf5Members, path: str, fields: tuple[str, ...], report: Report) -> dict[str, np.ndarray] | None:
    """The members of a table of records, each of shape (n,) or (n, 4); None and a report where one is wrong."""
    shown = printable(f"/{path}")
    if _is_reported(report, path):
        return None
    if path not in members.names:
        report.add("E504", "there is no such dataset", name=shown, advice=_LIKE)
        return None
    missing = [f for f in fields if f"{path}/{f}" not in members.arrays]
    if missing:
        report.add("E504", f"the records have no member {', '.join(missing)}", name=shown, advice=_LIKE)
        return None
    record = {}
    for field in fields:
        values = members.arrays[f"{path}/{field}"]
        tail = (4,) if field == "LocalTransform" else ()
        shape = values.shape[: values.ndim - len(tail)]
        is_kind = values.dtype.kind in ("iu" if field in _INTEGERS else "iuf")
        if values.shape[len(shape) :] != tail or sum(n != 1 for n in shape) > 1 or not is_kind:
            wanted = f"{'whole numbers' if field in _INTEGERS else 'numbers'}, shape {('n', *tail)}"
            found = f"{field} has shape {values.shape} and type {values.dtype}; wanted {wanted}"
            report.add("E505", found, name=shown, advice=_LIKE)
            return None
        record[field] = values.reshape(-1, *tail)
    return record
